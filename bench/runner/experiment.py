"""What is an experiment? A question, the functions that answer it, and what its record shows."""

import importlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from bench.plots.plot import Plot
    from bench.records.claims import Claim
    from bench.records.points import Point
    from bench.records.records import Record

Progress = Callable[[int, int, str], None]
"""Called with cases done, cases in all, and what comes next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""Heads and rows."""

EffortName = Literal["full", "quick"]


def silent(done: int, total: int, what: str) -> None:
    """Show no progress."""


@dataclass(frozen=True)
class Effort:
    """How much a run measures, as named sizes: ``effort["fields"]`` of each case, for example."""

    name: EffortName
    sizes: Mapping[str, Any]

    def __getitem__(self, name: str) -> Any:
        return self.sizes[name]


@dataclass(frozen=True)
class Lazy:
    """A function of a module that is imported when it is first called: listing stays fast."""

    module: str
    name: str

    def __call__(self, *arguments: Any, **named: Any) -> Any:
        """Import the module and call the function."""
        return getattr(importlib.import_module(self.module), self.name)(*arguments, **named)


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One question, how it is answered, what its record shows, and what that does not say.

    version       number of its cases: other cases, other version
    full, quick   sizes of a run that is full or quick, by name
    cases         of an Effort: what is measured, each plain data that another process can be sent;
                  where a metric is accepted, of its name or None as well
    measure       of one case and the run's seed: a point, or several; points of one case are merged
    judge         of all points: every claim that their samples decide
    plots, point_table   of a record: its plots; heads and rows of its points
    scene_hash    of all points: SHA-256 of everything that was looked at
    notes         of effort, seed and points: what else the record notes; the sizes if there is none
    summary       of a record: what it says in a few rows, before all else
    caveats       what the record does not say
    expected_seconds   of a full and of a quick run on two cores: for estimates only
    rendered      pictures are made: the record names the renderer's variant
    timed         it measures time, and so must stay on one machine
    all_cores     it measures on every core
    accepts_metric   it can try an installed metric beside its own
    order         place in lists and reports: the smaller comes first
    """

    name: str
    version: int
    about: str
    question: str
    full: Mapping[str, Any]
    quick: Mapping[str, Any]
    cases: Callable[..., Sequence[Any]]
    measure: Callable[[Any, int], "Point | list[Point]"]
    judge: Callable[[tuple["Point", ...]], tuple["Claim", ...]]
    plots: Callable[["Record"], tuple["Plot", ...]]
    point_table: Callable[["Record"], Table]
    scene_hash: Callable[[tuple["Point", ...]], str]
    notes: Callable[[Effort, int, tuple["Point", ...]], dict[str, Any]] | None = None
    summary: Callable[["Record"], Table] | None = None
    caveats: tuple[str, ...] = ()
    expected_seconds: Mapping[EffortName, float]
    rendered: bool = False
    timed: bool = False
    all_cores: bool = False
    accepts_metric: bool = False
    order: int = 1000

    def effort(self, name: EffortName) -> Effort:
        """Give the sizes of a full or a quick run."""
        return Effort(name, self.quick if name == "quick" else self.full)
