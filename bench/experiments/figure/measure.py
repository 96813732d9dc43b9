"""How do the parts of a figure drop off with distance, and do they shrink with depth? (§2.3, §4)"""

from typing import Any

from bench.experiments.figure.cases import Approach, PosingTask, Sizes, object_of
from bench.experiments.figure.claims import COUNTED, POSED, SIZED
from bench.experiments.figure.fit import RESAMPLES
from bench.experiments.figure.part_counts import count, sizes
from bench.experiments.figure.posing import posing
from bench.old_experiment import Effort
from bench.records.records import Point, columns


def measure(case: Approach | Sizes | PosingTask, seed: int) -> Point | list[Point]:
    """Count a curve, a point a distance; list sizes; or time both ways of posing."""
    match case:
        case Approach():
            return _counted(case, seed)
        case Sizes(kind):
            return Point({"what": SIZED, "kind": kind}, samples=columns(sizes(kind)))
        case PosingTask(task):
            found, times = posing(task, case.poses, case.repeats, seed)
            return Point({"what": POSED, "task": task, **found}, samples=columns(times))


def _counted(case: Approach, seed: int) -> list[Point]:
    """Count the parts that every pose displays, at each distance."""
    curve = case.curve
    distances = curve.distances(case.distances)
    same = {"parts": len(object_of(curve.kind).hierarchy), "fits": curve.fits}
    named = {"what": COUNTED, **curve.as_json(), **same}
    rows = count(curve, case.poses, distances, seed)
    return [
        Point({**named, "distance": float(distance)}, samples=columns({"parts": row.tolist()}))
        for distance, row in zip(distances, rows, strict=True)
    ]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return the sizes of the run, and the number of bootstrap samples."""
    return {**effort.sizes, "bootstrap_samples": RESAMPLES}
