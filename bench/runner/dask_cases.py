"""Cases of an experiment one after the other here, or at once on a cluster: the same numbers.

For what is counted or compared. What is timed stays here: machines differ.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, Protocol, runtime_checkable

_RETRIES = 2


@runtime_checkable
class CaseExecutor(Protocol):
    """Calls a function with each case's arguments; gives the results in the order of the cases."""

    def __call__(
        self, function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
    ) -> Iterator[Any]:
        """One result a case."""


def serial_executor(
    function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
) -> Iterator[Any]:
    """Here, each when it is asked for."""
    return (function(*case) for case in cases)


@contextlib.contextmanager
def dask_executor(where: str | None, say: Callable[[str], object]) -> Iterator[CaseExecutor]:
    """Over a cluster as scenes.render.sequence.dask_cluster has it; None = here. ``say`` hears of
    a dashboard."""
    if where is None:
        yield serial_executor
        return
    from scenes.render.sequence.dask_cluster import cluster

    with cluster(where, threads=1) as workers:
        say(f"lodbench: dashboard at {workers.dashboard}")
        yield _Tasks(workers.client)


class _Tasks:
    """One task a case."""

    def __init__(self, client: Any) -> None:
        self._client = client

    def __call__(
        self, function: Callable[..., Any], cases: Sequence[tuple[Any, ...]]
    ) -> Iterator[Any]:
        columns = map(list, zip(*cases, strict=True))
        futures = self._client.map(function, *columns, pure=False, retries=_RETRIES)
        try:
            for future in futures:
                yield future.result()
                future.release()
        finally:
            self._client.cancel(futures, force=True)
