"""Cases of an experiment one after the other here, or at once on a cluster: the same numbers.

For what is counted or compared. What is timed stays here: machines differ.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

_RETRIES = 2


@runtime_checkable
class CaseExecutor(Protocol):
    """A function that calls another with each case's arguments.

    It gives the results in the order of the cases.
    """

    def __call__(
        self, function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
    ) -> Iterator[Any]:
        """Yield one result for each case."""


def serial_executor(
    function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
) -> Iterator[Any]:
    """Measure the cases in this process, each when its result is asked for."""
    return (function(*case) for case in cases)


@contextlib.contextmanager
def dask_executor(where: str | None, say: Callable[[str], object]) -> Iterator[CaseExecutor]:
    """Give an executor over a Dask cluster, with one task for each case.

    ``where`` is what ``scenes.render.cluster`` takes; None gives ``serial_executor``.
    ``say`` is told of the cluster what someone who waits may want to know.
    """
    if where is None:
        yield serial_executor
        return
    from scenes.render.cluster import cluster

    with cluster(where, threads=1, say=say) as workers:

        def tasks(function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]) -> Iterator[Any]:
            arguments = map(list, zip(*cases, strict=True))
            futures = workers.client.map(function, *arguments, pure=False, retries=_RETRIES)
            try:
                for future in futures:
                    yield future.result()
                    future.release()
            finally:
                workers.client.cancel(futures, force=True)

        yield tasks
