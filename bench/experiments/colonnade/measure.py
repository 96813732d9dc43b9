"""Which columns of a colonnade lose detail, and what error does that make? (§2.1)

Cuts by true distance and by depth are compared. Each seed is a render with noise of its own; the
pruned and the unpruned picture of a seed share it, so that where nothing is pruned they are equal.
Errors are mean |difference of luminance| over a column's pixels, weighted alike or by the solid
angle that each subtends at the eye.
"""

from dataclasses import dataclass

import numpy as np

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
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, columns
from scenes.frame.frame_input import Quality
from scenes.models.stone import column
from scenes.render.variants import choose

SHOTS = (
    *(Shot("blake", detail) for detail in (3.0, 8.0)),
    *(Shot("depth", detail) for detail in (3.0, 8.0, 12.0)),
)
"""Both metrics at 3 px and at 8 px, and depth with about as many parts as blake at 8 px."""

_SPP = 16


@dataclass(frozen=True)
class Render:
    """A render's number, added to the run's seed, and the variant that renders it."""

    number: int
    variant: str


@dataclass(frozen=True)
class PartCounts:
    """The case that counts the parts of every column, which are the same for every seed."""


def cases(effort: Effort) -> list[Render | PartCounts]:
    """Return as many renders as the effort says, and the case that counts parts."""
    variant = choose()
    return [*(Render(k, variant) for k in range(effort["seeds"])), PartCounts()]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, int]:
    """Return the samples of a pixel, and the sizes of the run."""
    return {"samples_per_pixel": _SPP, **effort.sizes}


def measure(case: Render | PartCounts, seed: int) -> list[Point]:
    """Measure a point for each shot and column: errors of one seed, or the number of parts."""
    if isinstance(case, PartCounts):
        return [
            Point(_named(shot, k), samples=columns({"parts": [parts]}))
            for shot in SHOTS
            for k, parts in enumerate(cut(shot)[1])
        ]
    quality = Quality(case.variant, _SPP, seed + case.number, 4)
    whole, owner = picture(Shot("blake", FINEST), quality)
    seen, points = sizes(owner), []
    for shot in SHOTS:
        wrong = errors(picture(shot, quality)[0], whole, owner)
        for k in range(COUNT):
            sized = columns({name: [row[k]] for name, row in seen.items()})
            errors_ = (Column("error_ppm", [row[k]], {"weight": w}) for w, row in wrong.items())
            points.append(Point(_named(shot, k), samples=(*sized, *errors_)))
    return points


def _named(shot: Shot, column: int) -> dict[str, object]:
    """Return the case of a column in one cut, as plain data."""
    place = {"column": column, "aside": places()[column]}
    return {"metric": shot.metric, "detail": shot.detail, **place}


def sizes(owner: np.ndarray) -> dict[str, list[int]]:
    """Measure every column: pixels, solid angle [µsr], and the width of its shaft [px/1000]."""
    angle = pixel_solid_angle()
    shaft = owner[SIZE_PX[1] // 2 - 30 : SIZE_PX[1] // 2 + 30]
    found = range(1, COUNT + 1)
    return {
        "pixels": [int((owner == k).sum()) for k in found],
        "solid_angle_usr": [round(1e6 * float(angle[owner == k].sum())) for k in found],
        "shaft_mpx": [round(1000 * float((shaft == k).sum(axis=1).mean())) for k in found],
    }


def errors(pruned: np.ndarray, whole: np.ndarray, owner: np.ndarray) -> dict[str, list[int]]:
    """Measure the error of every column as a share of its mean luminance [10⁻⁶], by weight."""
    far, angle = np.abs(pruned - whole), pixel_solid_angle()
    made: dict[str, list[int]] = {"image": [], "eye": []}
    for k in range(1, COUNT + 1):
        mine = owner == k
        for name, weight in (("image", np.ones_like(far)), ("eye", angle)):
            share = np.sum((far * weight)[mine]) / np.sum((whole * weight)[mine])
            made[name].append(round(1e6 * float(share)))
    return made


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the column, its places, the camera, the light and the shots."""
    eye, tree = camera(), column().hierarchy
    words = [places(), SIZE_PX, [str(shot) for shot in SHOTS], str(LIGHT), eye.eye.tolist()]
    arrays = tree.parent, tree.position, tree.P, tree.R, eye.forward, np.array(eye.tan_half)
    return scene_digest(words, arrays)
