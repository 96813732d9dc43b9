"""What changed between two runs: claim by claim, and whether the samples are the same.

Two records may meet where they ask the same of the same scene; commit, machine, packages and seed
may differ, for that is what is compared. Everything else is refused.

A paired comparison needs no claim: points of the same case, seed and fields are held against each
other number by number. It finds what every verdict has room for, as land that is 1.5 % too bright.
``problems`` are what is wrong with a record whatever its figures are.
"""

import math
from collections.abc import Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from scipy import stats

from bench.experiment import Experiment, experiments
from bench.records.claims import Claim
from bench.records.probe import CASES
from bench.records.provenance import scene_digest
from bench.records.records import PRESET_TEXT, Column, Point, Record, read_record, read_records
from bench.statistics.estimates import holm
from lod.errors import InputError

RELEVANT, RELEVANT_TIME = 0.005, 0.02
"""How far the mean of a quantity, and of a time, may be from what it was, as a share."""

LEVEL = 0.01  # the chance that any drift at all is named between two runs of the same (Holm 1979)

_TIMES, _SHORTEST = ("us", "ns"), 1000
"""Ends of the names of times, and how many of their units are too few to tell 1 % by."""


@dataclass(frozen=True)
class Drift:
    """A quantity whose mean is another than before.

    where   the texts in the cases of its points, and its own keys
    ratio   geometric mean of after ÷ before, with its 95 % interval low to high
    """

    quantity: str
    where: str
    ratio: float
    low: float
    high: float


def drifts(before: Record, after: Record) -> tuple[Drift, ...]:
    """Name what drifted between two records, by paired t-tests of logarithms, Holm's correction.

    Values are paired by their place in a column. Times are first divided by what they came to over
    all of the record, the speed of the machine on that day; those of another kind are left out.
    """
    one, other = (vars(record.provenance) for record in (before, after))
    alike = all(one[key] == other[key] for key in _MACHINE)
    first = {repr(point.case): _sums(point) for point in before.points}
    ratios: dict[tuple[str, str], list[float]] = {}
    for point in after.points:
        old = first.get(repr(point.case), {})
        for name, values in _sums(point).items():
            told = alike or not _is_time(name[0])
            if told and name in old and len(old[name]) == len(values):
                short = _SHORTEST if _is_time(name[0]) else 0
                used = (old[name] > short) & (values > short)
                row = ratios.setdefault((name[0], f"{_said(point)}{name[1]}"), [])
                row += np.log(values[used] / old[name][used]).tolist()
    timed = [np.mean(row) for (name, _), row in ratios.items() if _is_time(name) and row]
    pace = float(np.median(timed)) if len(timed) > 2 else 0.0
    found = []
    for (quantity, where), row in ratios.items():
        logs = np.array(row) - (pace if _is_time(quantity) else 0.0)
        least = RELEVANT_TIME if _is_time(quantity) else RELEVANT
        if len(logs) < 3:
            continue
        mean, error = float(logs.mean()), float(logs.std(ddof=1)) / math.sqrt(len(logs))
        reach = float(stats.t.ppf(0.975, len(logs) - 1)) * error
        p = 2 * float(stats.t.sf(abs(mean) / max(error, 1e-12), len(logs) - 1))
        ends = (math.exp(mean + k * reach) for k in (0, -1, 1))
        found.append((p, abs(mean) > math.log1p(least), Drift(quantity, where, *ends)))
    found.sort(key=lambda each: each[0])
    told_apart = holm([p for p, _, _ in found], LEVEL)
    return tuple(
        e for (_, large, e), apart in zip(found, told_apart, strict=True) if large and apart
    )


def _is_time(quantity: str) -> bool:
    return quantity.rsplit("_", 1)[-1] in _TIMES


def _said(point: Point) -> str:
    return ", ".join(str(value) for value in point.case.values() if isinstance(value, str))


def _sums(point: Point) -> dict[tuple[str, str], np.ndarray]:
    """Sum columns that differ in numbers alone, as bands do, by quantity and texts of keys."""
    found: dict[tuple[str, str], np.ndarray] = {}
    for each in point.samples:
        texts = [v for v in each.keys.values() if isinstance(v, str)]
        name = each.quantity, "".join(f", {text}" for text in texts)
        values = np.array(each.values, np.float64)
        before = found.get(name)
        if before is None or len(before) == len(values):
            found[name] = values if before is None else before + values
    return found


def problems(record: Record) -> tuple[str, ...]:
    """Name what cannot be in a record, whatever was measured."""
    told = [line for row in _scenes(record.points) for line in _of_scene(row)]
    made = record.notes.get(CASES, ())
    if len({case.get("digest") for case in made}) > 1:
        commits = ", ".join(sorted({str(case.get("commit")) for case in made}))
        told.append(f"measured by different sources, of the commits {commits}")
    return tuple(dict.fromkeys(told))


def _scenes(points: Sequence[Point]) -> Iterable[list[Point]]:
    """Group points that show the same scenes, however they are pruned."""
    hidden = "pruned", "metric", "detail", "step", "arm", "setting"
    found: dict[str, list[Point]] = {}
    for point in points:
        name = repr({k: v for k, v in point.case.items() if k not in hidden})
        found.setdefault(name, []).append(point)
    return found.values()


def _drawn(point: Point) -> dict[int, int]:
    """Count sticks; of methods the triangles of leaves, too, which seen from afar are sticks."""
    leaves = _by_replicate(point, "triangles") if "arm" in point.case else {}
    found = _by_replicate(point, "sticks").items()
    return {place: n + leaves.get(place, 0) for place, n in found}


def _of_scene(row: Sequence[Point]) -> Iterator[str]:
    """Yield what is wrong among points of one scene: their reference, suns, and sticks."""
    seen: dict[tuple[str, int], int] = {}
    whole = [p for p in row if "nothing" in p.case.values() or p.case.get("arm") == "full"]
    most = _drawn(whole[0]) if whole and not _by_replicate(whole[0], "copies") else {}
    suns = {sun for point in row for sun in _by_replicate(point, "sun_deg").values()}
    for point in row:
        for each in point.samples:
            if each.keys.get("picture") == "reference":
                name = f"{each.quantity} {sorted(each.keys.items())}"
                for place, value in zip(_places(point, each), each.values, strict=True):
                    if seen.setdefault((name, place), value) != value:
                        yield f"{_said(point)}: the reference is another beside other treatments"
        held = [*_by_replicate(point, "sun_deg").values()]
        counts = [held.count(sun) for sun in suns]
        uneven = len(held) % max(len(suns), 1) > 0  # of four places two are under one of three suns
        if held and (min(counts) == 0 or max(counts) - min(counts) > uneven):
            yield f"{_said(point)}: some suns are missing, or there more often than others"
        if any(n > most.get(place, math.inf) for place, n in _drawn(point).items()):
            yield f"{_said(point)}: more sticks than its reference has"


def _by_replicate(point: Point, quantity: str) -> dict[int, int]:
    """Return a column by the numbers of its fields or places; nothing where there is none."""
    for each in point.samples:
        if each.quantity == quantity:
            return dict(zip(_places(point, each), each.values, strict=True))
    return {}


def _places(point: Point, column: Column) -> list[int]:
    named = [c.values for c in point.samples if c.quantity in ("field", "place")]
    fits = named and len(named[0]) == len(column.values)
    return named[0] if fits else list(range(len(column.values)))


Change = Literal["same", "within the intervals", "moved", "verdict", "new", "gone"]

_SAME = ("scene", "variant")
"""What two records must share; an experiment's version and whether it was quick, too."""

_MACHINE = ("cpu", "cores", "threads")
_MAY_DIFFER = ("commit", *_MACHINE, "packages", "platform", "python", "seed")


@dataclass(frozen=True)
class Difference:
    """What became of one claim, which is in both runs or in one of them."""

    name: str
    change: Change
    before: Claim | None
    after: Claim | None

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        sides = {"before": self.before, "after": self.after}
        told = {side: claim.as_json() if claim else None for side, claim in sides.items()}
        return {"name": self.name, "change": self.change, **told}


@dataclass(frozen=True)
class Comparison:
    """A comparison of two records of one experiment.

    origin  what else differs in their provenance, as (before, after) by name
    drifts  quantities whose mean is another, whatever the verdicts say
    problems  what cannot be in the second record
    """

    experiment: str
    before: str
    after: str
    same_samples: bool
    origin: dict[str, tuple[Any, Any]]
    differences: tuple[Difference, ...]
    drifts: tuple[Drift, ...]
    problems: tuple[str, ...]

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        told = {"differences": [each.as_json() for each in self.differences]}
        return {**vars(self), **told, "drifts": [vars(each) for each in self.drifts]}


def compare(before: Record, after: Record, topics: Set[str] | None = None) -> Comparison:
    """Compare two records claim by claim, by these topics alone; without any, by those of both.

    Raises InputError where they cannot be compared.
    """
    names = before.name, after.name
    for key in ("experiment", "version", "quick"):
        _must_share(key, getattr(before, key), getattr(after, key))
    shared = _topics(before) & _topics(after) if topics is None else topics
    if shared and not shared == _topics(before) == _topics(after):
        today = experiments().get(before.experiment)
        if today and today.version == before.version:
            before, after = _of_topics(today, before, shared), _of_topics(today, after, shared)
    for key in _SAME:
        _must_share(key, getattr(before.provenance, key), getattr(after.provenance, key))
    origin = {
        key: pair
        for key in _MAY_DIFFER
        if len(set(map(str, pair := tuple(getattr(r.provenance, key) for r in (before, after)))))
        > 1
    }
    return Comparison(
        before.experiment,
        *names,
        before.samples_sha256 == after.samples_sha256,
        origin,
        tuple(_differences(before.claims, after.claims)),
        drifts(before, after),
        problems(after),
    )


def compare_paths(before: Path, after: Path) -> tuple[Comparison, ...]:
    """Compare two records, or the newest of every topic that two folders share.

    Raises InputError for a record and a folder, and for folders that share no experiment.
    """
    if before.is_dir() != after.is_dir():
        cure = "give a folder and a folder, or a file and a file"
        raise InputError("A B", f"{before} {after}", "two records or two folders", cure)
    if not before.is_dir():
        return (compare(read_record(before), read_record(after)),)
    first, second = _newest(before), _newest(after)
    shared = [key for key in first if key in second]
    if not shared:
        raise _nothing_shared(before, after, set(first), set(second))
    pairs: dict[tuple[int, int], tuple[Record, Record, set[str]]] = {}
    for key in shared:
        one, other = first[key], second[key]
        pairs.setdefault((id(one), id(other)), (one, other, set()))[2].add(key[2])
    return tuple(compare(*pair) for pair in pairs.values())


def _nothing_shared(
    before: Path, after: Path, first: set[tuple[str, bool, str]], second: set[tuple[str, bool, str]]
) -> InputError:
    """Say why no record of one folder meets one of the other: experiments, kinds, or topics."""
    rule, cure = "records of one experiment in both", "run one experiment into both"
    both = {name for name, *_ in first} & {name for name, *_ in second}
    if alike := {key[:2] for key in first} & {key[:2] for key in second}:
        name, _ = kind = min(alike)
        told = [" ".join(sorted(k[2] for k in keys if k[:2] == kind)) for keys in (first, second)]
        rule = f"one topic in both: of {name} {before} has {told[0]}, {after} {told[1]}"
        cure = f"run one topic into both: lodbench run {told[1]} -o {before}"
    elif both:
        quick, full = (
            (before, after) if (min(both), True) in {k[:2] for k in first} else (after, before)
        )
        named = ", ".join(sorted(both))
        rule = f"runs of one kind: of {named} {quick} has quick ones, {full} full"
        cure = f"measure in full: lodbench run {min(both).partition(' ')[0]} -o {quick}"
    return InputError("A B", f"{before} {after}", rule, cure)


def _newest(folder: Path) -> dict[tuple[str, bool, str], Record]:
    newest: dict[tuple[str, bool, str], Record] = {}
    for record in read_records(folder):
        for topic in sorted(_topics(record)):
            newest.setdefault((record.subject, record.quick, topic), record)
    return newest


def _topics(record: Record) -> set[str]:
    return {str(point.case.get("topic")) for point in record.points}


def _of_topics(experiment: Experiment, record: Record, topics: Set[str]) -> Record:
    """Leave other topics out of a record, and judge what is left again."""
    points = tuple(p for p in record.points if str(p.case.get("topic")) in topics)
    words = [[p.case, p.scene] for p in points], record.notes.get(PRESET_TEXT)
    return replace(
        record,
        points=points,
        claims=experiment.judged(points),
        provenance=replace(record.provenance, scene=scene_digest(words)),
    )


def _must_share(key: str, before: object, after: object) -> None:
    if before != after:
        arrived = f"{str(before)[:40]} and {str(after)[:40]}"
        cure = "runs of the same workload by the same variant can be compared"
        raise InputError(f"{key} of the two records", arrived, "the same in both", cure)


def _differences(before: Iterable[Claim], after: Iterable[Claim]) -> Iterable[Difference]:
    first, second = ({claim.name: claim for claim in claims} for claims in (before, after))
    for name in dict.fromkeys((*first, *second)):
        one, other = first.get(name), second.get(name)
        yield Difference(name, _change(one, other), one, other)


def _change(before: Claim | None, after: Claim | None) -> Change:
    if before is None or after is None:
        return "new" if before is None else "gone"
    if before.verdict != after.verdict:
        return "verdict"
    if before == after:
        return "same"
    apart = before.high < after.low or after.high < before.low
    return "moved" if apart else "within the intervals"
