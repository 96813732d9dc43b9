"""How do the parts of a figure drop off with distance, and do they shrink with depth? (§2.3, §4)"""

import time
from dataclasses import dataclass

from bench.experiments.figure.cases import EVERYTHING, Curve, curves, object_of
from bench.experiments.figure.claims import COUNTED, SIZED, judge
from bench.experiments.figure.fit import RESAMPLES
from bench.experiments.figure.part_counts import count, scene_hash, sizes
from bench.experiments.figure.posing import POINTS_PER_JOINT, posing
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, run_cases

NAME, VERSION = "figure", 1


@dataclass(frozen=True)
class Effort:
    """poses of each kind; distances of each curve; repeats of posing, and poses in each."""

    poses: int
    distances: int
    repeats: int
    posed: int


FULL = Effort(poses=200, distances=60, repeats=101, posed=4000)
QUICK = Effort(poses=40, distances=30, repeats=21, posed=1000)


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
    metric: str | None = None,
) -> Record:
    """Count every curve, compare all sizes, time both ways of posing, and judge every claim.

    ``metric``: of another than its own as well.
    """
    grid, effort, start = curves(metric), QUICK if quick else FULL, time.perf_counter()
    cases = [(f"{curve.kind}, {curve.metric}", (curve, effort, seed)) for curve in grid]
    points = run_cases(progress, each, (measure, cases))
    points += tuple(Point({"what": SIZED, "kind": kind}, {}, sizes(kind)) for kind in EVERYTHING)
    times = {task: posing(task, effort.posed, effort.repeats, seed) for task in POINTS_PER_JOINT}
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(scene_hash(grid), seed),
        points=points,
        claims=judge(points, seed, times),
        notes={
            "poses": effort.poses,
            "distances": effort.distances,
            "bootstrap_samples": RESAMPLES,
            **{f"{task}_times": found.as_json() for task, found in times.items()},
        },
        start=start,
    )


def measure(curve: Curve, effort: Effort, seed: int) -> list[Point]:
    """One point a distance, with the count of every pose."""
    distances = curve.distances(effort.distances)
    same = {"parts": len(object_of(curve.kind).hierarchy), "fits": curve.fits}
    case = {"what": COUNTED, **curve.as_json(), **same}
    rows = count(curve, effort.poses, distances, seed)
    return [
        Point({**case, "distance": float(distance)}, {}, {"parts": row.tolist()})
        for distance, row in zip(distances, rows, strict=True)
    ]
