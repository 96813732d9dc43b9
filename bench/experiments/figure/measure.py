"""How do the parts of a figure drop off with distance, and do they shrink with depth? (§2.3, §4)"""

from functools import singledispatch
from typing import Any

from bench.experiments.figure.cases import Approach, PosingTask, Sizes, object_of
from bench.experiments.figure.claims import COUNTED, POSED, SIZED
from bench.experiments.figure.fit import RESAMPLES
from bench.experiments.figure.part_counts import count, sizes
from bench.experiments.figure.posing import posing
from bench.records.points import Point, columns
from bench.runner.experiment import Effort


@singledispatch
def measure(case: Any, seed: int) -> Point | list[Point]:
    """Measure a case: each kind of case has its own function. Raises TypeError for others."""
    raise TypeError(case)


@measure.register
def _(case: Approach, seed: int) -> list[Point]:
    """One point a distance, with the count of every pose."""
    curve = case.curve
    distances = curve.distances(case.distances)
    same = {"parts": len(object_of(curve.kind).hierarchy), "fits": curve.fits}
    named = {"what": COUNTED, **curve.as_json(), **same}
    rows = count(curve, case.poses, distances, seed)
    return [
        Point({**named, "distance": float(distance)}, samples=columns({"parts": row.tolist()}))
        for distance, row in zip(distances, rows, strict=True)
    ]


@measure.register
def _(case: Sizes, seed: int) -> Point:
    """Level, whole and size of every part."""
    return Point({"what": SIZED, "kind": case.kind}, samples=columns(sizes(case.kind)))


@measure.register
def _(case: PosingTask, seed: int) -> Point:
    """Times of both ways of posing, repeat by repeat."""
    found, times = posing(case.task, case.poses, case.repeats, seed)
    return Point({"what": POSED, "task": case.task, **found}, samples=columns(times))


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the sizes of the run, and the number of bootstrap samples."""
    return {**effort.sizes, "bootstrap_samples": RESAMPLES}
