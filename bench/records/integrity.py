"""What is wrong with a record whatever its figures are, and what became otherwise between two.

A paired comparison needs no claim: points of the same case, seed and fields are held against each
other number by number. It finds what every verdict has room for, as land that is 1.5 % too bright.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from bench.records.probe import CASES
from bench.records.records import Column, Point, Record
from bench.statistics.estimates import holm

RELEVANT, RELEVANT_TIME = 0.005, 0.02
"""How far the mean of a quantity, and of a time, may be from what it was, as a share."""

LEVEL = 0.01
"""The chance that any drift at all is named between two runs of the same (Holm 1979)."""

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
    all of the record, the speed of the machine on that day.
    """
    first = {repr(point.case): _sums(point) for point in before.points}
    ratios: dict[tuple[str, str], list[float]] = {}
    for point in after.points:
        old = first.get(repr(point.case), {})
        for name, values in _sums(point).items():
            if name in old and len(old[name]) == len(values):
                short = _SHORTEST if _is_time(name[0]) else 0
                used = (old[name] > short) & (values > short)
                told = ratios.setdefault((name[0], f"{_said(point)}{name[1]}"), [])
                told += np.log(values[used] / old[name][used]).tolist()
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


def _of_scene(row: Sequence[Point]) -> Iterator[str]:
    """Yield what is wrong among points of one scene: their reference, suns, and sticks."""
    seen: dict[tuple[str, int], int] = {}
    whole = [p for p in row if "nothing" in p.case.values() or p.case.get("arm") == "full"]
    most = _by_replicate(whole[0], "sticks") if whole else {}
    suns = _by_replicate(row[0], "sun_deg").values()
    for point in row:
        for each in point.samples:
            if each.keys.get("picture") == "reference":
                name = f"{each.quantity} {sorted(each.keys.items())}"
                for place, value in zip(_places(point, each), each.values, strict=True):
                    if seen.setdefault((name, place), value) != value:
                        yield f"{_said(point)}: the reference is another beside other treatments"
        held = [*_by_replicate(point, "sun_deg").values()]
        if len({held.count(sun) for sun in suns}) > 1:
            yield f"{_said(point)}: some suns are missing, or there more often than others"
        mine = _by_replicate(point, "sticks")
        if any(n > most.get(place, math.inf) for place, n in mine.items()):
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
