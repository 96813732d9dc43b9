"""Which columns of a colonnade lose detail, and what error that makes, by true distance and depth?

(§2.1.) Each seed is a render of its own noise; the pruned and the unpruned picture of a seed share
it, so that where nothing is pruned they are equal. Errors are mean |difference of luminance| over a
column's pixels, each weighted alike, or by the solid angle it subtends at the eye.
"""

import hashlib
import json
import time

import numpy as np

from bench.experiments.colonnade.claims import judge
from bench.experiments.colonnade.scene import (
    COUNT,
    FINEST,
    LIGHT,
    SIZE_PX,
    Shot,
    camera,
    cut,
    picture,
    pixel_solid_angle,
    places,
)
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.runner.run_cases import make_record, merge_points, run_cases
from scenes.frame.quality import Quality
from scenes.models.column import column
from scenes.render.mitsuba.variants import choose

NAME, VERSION = "colonnade", 1
SHOTS = (
    *(Shot("blake", detail) for detail in (3.0, 8.0)),
    *(Shot("depth", detail) for detail in (3.0, 8.0, 12.0)),
)
"""At 3 px and 8 px by both metrics; and depth with about as many parts as blake at 8 px."""

_SPP, _SEEDS, _QUICK_SEEDS = 16, 8, 3


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
) -> Record:
    """Render every seed unpruned and by every way of pruning; judge the claims."""
    start, variant = time.perf_counter(), choose()
    seeds = [seed + k for k in range(_QUICK_SEEDS if quick else _SEEDS)]
    cases = [(f"seed {number}", (number, variant)) for number in seeds]
    found = merge_points(run_cases(progress, each, (measure, cases)))
    points = tuple(_with_parts(point) for point in found)
    return make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(scene_hash(), seed, variant=variant),
        points=points,
        claims=judge(points),
        notes={"samples_per_pixel": _SPP, "seeds": len(seeds)},
        start=start,
    )


def measure(seed: int, variant: str) -> list[Point]:
    """A point for each shot and column, of one seed."""
    quality = Quality(variant, _SPP, seed, 4)
    whole, owner = picture(Shot("blake", FINEST), quality)
    seen, points = sizes(owner), []
    for shot in SHOTS:
        found = seen | errors(picture(shot, quality)[0], whole, owner)
        for k in range(COUNT):
            case = {"metric": shot.metric, "detail": shot.detail, "column": k, "aside": places()[k]}
            points.append(Point(case, {}, {name: [row[k]] for name, row in found.items()}))
    return points


def sizes(owner: np.ndarray) -> dict[str, list[int]]:
    """Of every column: pixels it covers, their solid angle [µsr], and pixels of a row of its
    shaft, in thousandths."""
    angle = pixel_solid_angle()
    shaft = owner[SIZE_PX[1] // 2 - 30 : SIZE_PX[1] // 2 + 30]
    found = range(1, COUNT + 1)
    return {
        "pixels": [int((owner == k).sum()) for k in found],
        "solid_angle_usr": [round(1e6 * float(angle[owner == k].sum())) for k in found],
        "shaft_mpx": [round(1000 * float((shaft == k).sum(axis=1).mean())) for k in found],
    }


def errors(pruned: np.ndarray, whole: np.ndarray, owner: np.ndarray) -> dict[str, list[int]]:
    """Of every column: error as a share of its mean luminance, in millionths, by both weights."""
    far, angle = np.abs(pruned - whole), pixel_solid_angle()
    made: dict[str, list[int]] = {"error_image_ppm": [], "error_eye_ppm": []}
    for k in range(1, COUNT + 1):
        mine = owner == k
        for name, weight in (("image", np.ones_like(far)), ("eye", angle)):
            share = np.sum((far * weight)[mine]) / np.sum((whole * weight)[mine])
            made[f"error_{name}_ppm"].append(round(1e6 * float(share)))
    return made


def _with_parts(point: Point) -> Point:
    """With the parts of that column, which no seed changes."""
    metric, detail, column_ = (point.case[key] for key in ("metric", "detail", "column"))
    parts = cut(Shot(metric, detail))[1][column_]
    return Point(point.case, point.predicted, {**point.samples, "parts": [parts]})


def scene_hash() -> str:
    """SHA-256 of the column, where columns stand, the camera, the light and the shots."""
    eye, tree = camera(), column().hierarchy
    words = [places(), SIZE_PX, [str(shot) for shot in SHOTS], str(LIGHT), eye.eye.tolist()]
    digest = hashlib.sha256(json.dumps(words).encode())
    for array in (tree.parent, tree.position, tree.P, tree.R, eye.forward, np.array(eye.tan_half)):
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()
