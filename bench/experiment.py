"""An experiment is one frozen object, in one file of ``bench/experiments``.

It has topics; each has cases that measure themselves, a function that makes claims of their points,
and a function that draws them. All else is made here or by ``bench.runs``: the table of its points,
the hash of what was looked at, resuming, provenance, the report.
"""

import importlib
import pkgutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Literal

from bench.records.claims import Claim
from bench.records.records import Point, where
from lod.errors import InputError
from scenes.presets.load import nearest_name
from scenes.presets.schema import Preset

if TYPE_CHECKING:
    from bench.plots import Plot
    from bench.records.records import Record

Progress = Callable[[int, int, str], None]
"""A function that is called with the cases done, the cases in all, and the name of the next."""

Table = tuple[tuple[str, ...], list[tuple[str, ...]]]
"""A table: the heads of its columns, and its rows."""

Own = Literal["metric", "stems", "preset"]
OwnPreset = tuple[str, Preset]  # the name of a preset, or of its file, and the preset
EffortName = Literal["full", "quick"]  # how much a run measures: everything, or enough to try it


def silent(done: int, total: int, what: str) -> None:
    """Show no progress."""


Case = partial[Any]
"""A function of a module with all of its arguments but the last, the run's seed.

It gives a Point or several, and can be sent to another process; points of the same case are merged.
"""


def _nothing(*given: object, **sizes: object) -> tuple[()]:
    return ()


@dataclass(frozen=True, kw_only=True)
class Topic:
    """One question of several that an experiment answers.

    about        what `lodbench list` says of it
    cases        function from sizes, by name, to its cases; it is also given what it ``accepts``
    claims       function from its points, whose ``case`` names it as ``topic``, to every claim that
                 they decide
    plots        function from a record of its points and of all claims to its plots
    tables       function from such a record to titled tables that follow its plots
    full, quick  sizes of a full run, and those that are others in a quick one. Time is spent on
                 fields first, on pixels second and on samples of a pixel last, for fields are the
                 replicates
    plan         function from the sizes to lines that say what its time is spent on
    seconds      how long a full and a quick run take on two cores, for estimates of time alone
    apart        whether ``run all`` leaves it out for its length, and so does the experiment's own
                 name where there are others
    accepts      what of a user's own it can measure, each given to ``cases`` by name, or None:
                 ``metric``, the name of an installed metric, beside the built-in ones; ``stems``,
                 the path of a map and the SHA-256 of that file; ``preset``, an OwnPreset, in place
                 of its own worlds
    """

    about: str
    cases: Callable[..., Sequence[Case]]
    claims: Callable[[Sequence[Point]], Iterable[Claim]] = _nothing
    plots: Callable[["Record"], Iterable["Plot"]] = _nothing
    tables: Callable[["Record"], Iterable[tuple[str, Table]]] = _nothing
    full: Mapping[str, Any] = field(default_factory=dict)
    quick: Mapping[str, Any] = field(default_factory=dict)
    plan: Callable[..., Sequence[str]] = _nothing
    seconds: tuple[float, float]
    apart: bool = False
    accepts: tuple[Own, ...] = ()

    def sizes(self, effort: EffortName) -> dict[str, Any]:
        """Return the sizes of a full or a quick run."""
        return {**self.full, **(self.quick if effort == "quick" else {})}


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """One question, and the topics that answer it.

    name, question   what `lodbench list` and the report say of it
    version    a number that goes up when the cases change: runs of different versions are not
               compared
    topics     its topics by name; `lodbench run` takes their names, too
    notes      function from all points to what else the record notes
    caveats    sentences that say what the record does not show
    rendered   whether pictures are rendered; the record then names the renderer's variant
    timed      whether time is measured; all cases then stay on one machine
    all_cores  whether one case uses every core
    whole_cases   whether times are compared within a case alone, so that cases which are timed may
                  be kept from a run that was stopped
    probe      preset of the frame by which its records tell whether newer sources change them
    order      place in lists and reports: smaller numbers come first
    """

    name: str
    question: str
    version: int
    topics: Mapping[str, Topic]
    notes: Callable[[tuple[Point, ...]], dict[str, Any]] | None = None
    caveats: tuple[str, ...] = ()
    rendered: bool = False
    timed: bool = False
    all_cores: bool = False
    whole_cases: bool = False
    probe: str = "meadow"
    order: int = 1000

    @property
    def usual(self) -> tuple[str, ...]:
        """Names of the topics that run where only the experiment is named."""
        return tuple(name for name, topic in self.topics.items() if not topic.apart)

    def accepting(self, own: Own, topics: Iterable[str]) -> tuple[str, ...]:
        """Return those of these topics that can measure a thing of a user's own."""
        return tuple(name for name in topics if own in self.topics[name].accepts)

    def seconds(self, topics: Iterable[str], effort: EffortName) -> float:
        """Estimate how long a run of these topics takes on two cores [s]."""
        return sum(self.topics[each].seconds[effort == "quick"] for each in topics)

    def judged(self, points: Sequence[Point]) -> tuple[Claim, ...]:
        """Make the claims of points. Raises InputError where two claims have one name."""
        mine = ((topic, where(points, topic=name)) for name, topic in self.topics.items())
        made = tuple(each for topic, row in mine if row for each in topic.claims(row))
        names = [each.name for each in made]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise InputError(f"claims of {self.name}", twice, "no two claims have one name")
        return made

    def plots(self, record: "Record") -> tuple["Plot", ...]:
        """Draw every topic that a record holds."""
        return tuple(p for topic, part in self._parts(record) for p in topic.plots(part))

    def tables(self, record: "Record") -> tuple[tuple[str, Table], ...]:
        """Return the titled tables of every topic that a record holds."""
        return tuple(each for topic, part in self._parts(record) for each in topic.tables(part))

    def _parts(self, record: "Record") -> Iterator[tuple[Topic, "Record"]]:
        for name, topic in self.topics.items():
            if points := where(record.points, topic=name):
                yield topic, replace(record, points=tuple(points))


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
            cure = nearest_name(name, known)
            if cure.startswith("one of"):
                cure = f"one of: {', '.join((*every, ALL))}, or a topic that `lodbench list` shows"
            raise InputError(key, name, rule, cure)
        if name == ALL:
            in_order = sorted(every.values(), key=lambda each: not each.timed)
            asked = {each.name: each.usual for each in in_order}
        else:
            asked = {owners.get(name, name): (name,)}
            if name in every:
                asked = {name: every[name].usual or tuple(every[name].topics)}
        for experiment, topics in asked.items():
            mine = found.setdefault(experiment, [])
            mine += [each for each in topics if each not in mine]
    return found
