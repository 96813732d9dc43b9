"""What an experiment is: a question, the way to answer it, and what its record shows."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

if TYPE_CHECKING:
    import bench.plots.plot
    import bench.records.claims
    import bench.records.records

Progress = Callable[[int, int, str], None]
"""Called with points done, points in all, and what comes next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""Heads and rows."""


def silent(done: int, total: int, what: str) -> None:
    """No progress shown."""


@runtime_checkable
class Run(Protocol):
    """Measures and judges; ``quick`` has the same points and fewer fields.

    What is not timed takes ``each`` as well, and has its cases measured by it, wherever that is;
    what tries metrics takes ``metric``, the name of another to be tried beside its own.
    """

    def __call__(
        self, quick: bool = False, progress: Progress = silent, seed: int = 0, **more: Any
    ) -> "bench.records.records.Record":
        """The finished record."""


@dataclass(frozen=True)
class Experiment:
    """One question, the way to answer it, what its record shows, and what that does not say.

    timed       it measures time, and so must stay on one machine
    tries       it can try an installed metric beside its own
    judge       every claim that a record's samples can decide
    expected_seconds     seconds that it takes, quick and full, on two cores: for estimates only
    summary     what its record says in a few rows, before all else
    """

    about: str
    question: str
    run: Run
    plots: Callable[["bench.records.records.Record"], tuple["bench.plots.plot.Plot", ...]]
    point_table: Callable[["bench.records.records.Record"], Table]
    caveats: tuple[str, ...]
    judge: Callable[["bench.records.records.Record"], tuple["bench.records.claims.Claim", ...]]
    timed: bool = False
    accepts_metric: bool = False
    expected_seconds: tuple[float, float] = (60.0, 600.0)
    summary: Callable[["bench.records.records.Record"], Table] | None = None
