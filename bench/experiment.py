"""An experiment is one frozen object, in one file of ``bench/experiments``.

It has cases, a function that measures one of them, a function that makes claims of all points, and
a function that draws them. All else is made here or by ``bench.runs``: the table of its points, the
hash of what was looked at, resuming, provenance, the report.
"""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from bench.records.claims import Claim, plain_number
from lod.errors import InputError
from scenes.presets.keys import nearest_name

if TYPE_CHECKING:
    from bench.plots import Plot
    from bench.records.records import Point, Record

Progress = Callable[[int, int, str], None]
"""A function that is called with the cases done, the cases in all, and the name of the next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""A table: the heads of its columns, and its rows."""

EffortName = Literal["full", "quick"]
"""How much a run measures: everything, or enough to try it."""


def silent(done: int, total: int, what: str) -> None:
    """Show no progress."""


@dataclass(frozen=True, kw_only=True)
class Topic:
    """One question of several that an experiment answers by the same means.

    about        what `lodbench list` says of it
    full, quick  sizes of a full and of a quick run, by name. Time is spent on fields first, on
                 pixels second and on samples of a pixel last, for fields are the replicates
    seconds      how long a full and a quick run take on two cores, for estimates of time alone
    apart        whether it runs only where it is named: ``run all`` and the experiment's own name
                 leave it out for its length
    """

    about: str
    full: Mapping[str, Any] = field(default_factory=dict)
    quick: Mapping[str, Any] = field(default_factory=dict)
    seconds: tuple[float, float]
    apart: bool = False

    def sizes(self, effort: EffortName) -> Mapping[str, Any]:
        """Return the sizes of a full or a quick run."""
        return self.quick if effort == "quick" else self.full


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One question, and the functions that answer it.

    name, question   what `lodbench list` and the report say of it
    version    a number that goes up when the cases change: runs of different versions are not
               compared
    topics     its topics by name; `lodbench run` takes their names, too
    cases      function from a topic's name and its sizes to its cases: plain data that another
               process can be sent. Where ``accepts_metric`` is true it is also given the name of
               the metric that is tried, or None
    measure    function from one case and the run's seed to a Point or several, whose ``case`` names
               its ``topic``; points of the same case are merged
    claims     function from the points of any of its topics to every claim that they decide
    plots      function from a record, which may hold any of its topics, to its plots
    notes      function from all points to what else the record notes
    tables     function from a record to titled tables that follow its plots
    caveats    sentences that say what the record does not show
    rendered   whether pictures are rendered; the record then names the renderer's variant
    timed      whether time is measured; all cases then stay on one machine
    all_cores  whether one case uses every core
    accepts_metric   whether it can measure an installed metric beside the built-in ones
    whole_cases   whether times are compared within a case alone, so that cases which are timed may
                  be kept from a run that was stopped
    probe      preset of the frame by which its records tell whether newer sources change them
    order      place in lists and reports: smaller numbers come first
    """

    name: str
    question: str
    version: int
    topics: Mapping[str, Topic]
    cases: Callable[..., Sequence[Any]]
    measure: Callable[[Any, int], "Point | list[Point]"]
    claims: Callable[[tuple["Point", ...]], tuple[Claim, ...]]
    plots: Callable[["Record"], tuple["Plot", ...]]
    notes: Callable[[tuple["Point", ...]], dict[str, Any]] | None = None
    tables: Callable[["Record"], tuple[tuple[str, Table], ...]] | None = None
    caveats: tuple[str, ...] = ()
    rendered: bool = False
    timed: bool = False
    all_cores: bool = False
    accepts_metric: bool = False
    whole_cases: bool = False
    probe: str = "meadow"
    order: int = 1000

    @property
    def usual(self) -> tuple[str, ...]:
        """Names of the topics that run where only the experiment is named."""
        return tuple(name for name, topic in self.topics.items() if not topic.apart)

    def seconds(self, topics: Iterable[str], effort: EffortName) -> float:
        """Estimate how long a run of these topics takes on two cores [s]."""
        return sum(self.topics[each].seconds[effort == "quick"] for each in topics)

    def judged(self, points: tuple["Point", ...]) -> tuple[Claim, ...]:
        """Make the claims of points. Raises InputError where two claims have one name."""
        made = self.claims(points)
        names = [each.name for each in made]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"claims of {self.name}", twice, "no two claims have one name")
        return made


@cache
def experiments() -> Mapping[str, Experiment]:
    """Return every experiment by its name, in order: one for each file of ``bench.experiments``."""
    folder = importlib.import_module(f"{__package__}.experiments")
    names = [each.name for each in pkgutil.iter_modules(folder.__path__)]
    found = [importlib.import_module(f"{folder.__name__}.{name}").EXPERIMENT for name in names]
    return {each.name: each for each in sorted(found, key=lambda each: (each.order, each.name))}


ALL = "all"


def topics_named(names: Sequence[str], key: str = "name") -> dict[str, list[str]]:
    """Return the topics that names of experiments and topics ask for, by experiment.

    ``all`` is every topic that does not run apart; experiments that are timed come first, before
    others have filled memory. Raises InputError, which blames ``key``, for an unknown name.
    """
    every, found = experiments(), dict[str, list[str]]()
    owners = {topic: each.name for each in every.values() for topic in each.topics}
    known = (*every, *owners, ALL)
    for name in names:
        if name not in known:
            rule = "no experiment or topic of that name"
            raise InputError(key, name, rule, nearest_name(name, known))
        if name == ALL:
            in_order = sorted(every.values(), key=lambda each: not each.timed)
            asked = {each.name: each.usual for each in in_order}
        else:
            asked = {name: every[name].usual} if name in every else {owners[name]: (name,)}
        for experiment, topics in asked.items():
            mine = found.setdefault(experiment, [])
            mine += [each for each in topics if each not in mine]
    return found


def point_table(points: Sequence["Point"], most_columns: int = 12) -> Table:
    """Write a row for each quantity of each point: its case, mean, deviation and prediction.

    Columns that differ in their further keys alone are one quantity each while a point has no more
    than ``most_columns``; the others are in the files beside the report.
    """
    heads: tuple[str, ...] = ("case", "quantity", "n", "mean", "standard deviation", "predicted")
    rows: list[tuple[str, ...]] = []
    for point in points:
        case = ", ".join(f"{k} {_short(v)}" for k, v in point.case.items() if v is not None)
        for each in point.samples[:most_columns]:
            values = np.asarray(each.values, np.float64)
            spread = f"{values.std(ddof=1):.4g}" if len(values) > 1 else "-"
            found = [p.value for p in point.predicted if (p.quantity, p.keys) == each.name]
            mean = f"{values.mean():.6g}" if len(values) else "-"
            told = f"{found[0]:.6g}" if found else "-"
            rows.append((case, each.label, f"{len(values)}", mean, spread, told))
    return heads, rows


def _short(value: object) -> str:
    return plain_number(value) if isinstance(value, float) else str(value)
