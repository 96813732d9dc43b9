"""What is an experiment made of? A question, functions that answer it, and what is shown."""

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
"""A function that is called with the cases done, the cases in all, and the name of the next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""A table: the heads of its columns, and its rows."""

EffortName = Literal["full", "quick"]
"""How much a run measures: everything, or enough to try it."""


def silent(done: int, total: int, what: str) -> None:
    """Show no progress."""


@dataclass(frozen=True)
class Effort:
    """How much a run measures, as named sizes: ``effort["fields"]`` for example."""

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


_MODULES = {
    **dict.fromkeys(("cases", "measure", "scene_hash", "notes"), "measure"),
    "judge": "claims",
    **dict.fromkeys(("plots", "point_table", "summary", "tables"), "plots"),
}
"""The module of an experiment's package in which each of its functions stands by convention."""


def functions_of(package: str, *more: str, **elsewhere: str) -> dict[str, Any]:
    """Return the functions of an experiment by their names, each imported when first called.

    By convention ``cases``, ``measure`` and ``scene_hash`` stand in the module ``measure`` of its
    package, ``judge`` in ``claims``, ``plots`` and ``point_table`` in ``plots``.

    package    name of the experiment's package
    more       names of the functions that it has beside those: ``notes``, in ``measure``, and
               ``summary`` and ``tables``, in ``plots``
    elsewhere  names of functions that stand in another module, with that module: one of the
               package, or with a dot in its name one from anywhere
    """
    optional = {"notes", "summary", "tables"}.difference(more)
    modules = {name: at for name, at in _MODULES.items() if name not in optional} | elsewhere
    return {
        name: Lazy(module if "." in module else f"{package}.{module}", name)
        for name, module in modules.items()
    }


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One question, the functions that answer it, and what its record shows.

    Every function may be a ``Lazy``, so that listing experiments imports none of their modules:
    ``functions_of`` makes them.

    name, about, question   what `lodbench list` and the report say of the experiment
    version       a number that goes up when the cases change: runs of different versions are not
                  compared
    full, quick   the sizes of a full and of a quick run, by name. Time is spent on fields first, on
                  pixels second and on samples of a pixel last, for fields are the replicates
    cases         function from an Effort to the cases: plain data that another process can be sent.
                  Where ``accepts_metric`` is true, it is also given the name of the metric, or None
    measure       function from one case and the run's seed to a Point or several; points of the
                  same case are merged
    judge         function from all points to every claim that their samples decide
    plots         function from a record to its plots
    point_table   function from a record to the heads and rows of a table of its points
    scene_hash    function from all points to the SHA-256 of everything that was looked at
    notes         function from effort, seed and points to what else the record notes; None = sizes
    summary       function from a record to heads and rows that the report shows first; None = none
    tables        function from a record to titled tables that follow its plots; None = none
    caveats       sentences that say what the record does not show
    expected_seconds   how long a full and a quick run take on two cores; only for estimates of time
    rendered      whether pictures are rendered; the record then names the renderer's variant
    timed         whether time is measured; all cases then stay on one machine
    all_cores     whether one case uses every core
    accepts_metric   whether it can measure an installed metric beside the built-in ones
    probe         preset of the frame by which its records tell whether newer sources change them
    apart         whether it runs only where it is named: ``all`` leaves it out for its length
    whole_cases   whether times are compared within a case alone, so that cases which are timed may
                  be kept from a run that was stopped
    order         place in lists and reports: smaller numbers come first
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
    tables: Callable[["Record"], tuple[tuple[str, Table], ...]] | None = None
    caveats: tuple[str, ...] = ()
    expected_seconds: Mapping[EffortName, float]
    rendered: bool = False
    timed: bool = False
    all_cores: bool = False
    accepts_metric: bool = False
    probe: str = "meadow"
    apart: bool = False
    whole_cases: bool = False
    order: int = 1000

    def effort(self, name: EffortName) -> Effort:
        """Return the sizes of a full or a quick run."""
        return Effort(name, self.quick if name == "quick" else self.full)
