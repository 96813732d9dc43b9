"""Leonardo's colonnade: equal columns in a row parallel to the picture plane (§2.1).

Columns further to the side are further from the eye and subtend less of its view, yet their images
on the plane grow. One render shows both, and so it shows what each metric's cut does.

Cuts by true distance and by depth are compared. Each seed is a render with noise of its own; the
pruned and the unpruned picture of a seed share it, so that where nothing is pruned they are equal.
Errors are mean |difference of luminance| over a column's pixels, weighted alike or by the solid
angle that each subtends at the eye.
"""

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache, partial

import numpy as np
from jaxtyping import Float64

from bench.experiment import Case
from bench.plots import Curve, Panel, Plot, figure
from bench.records.records import Column, Point, Record, columns, where
from bench.statistics.estimates import Estimate, two_sided_mean
from lod.air import CLEAR
from lod.camera import Camera, Corner, camera_from_heading
from lod.pruner import Representation, prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Light, Quality, display
from scenes.ground.mesh import Terrain
from scenes.models.stone import RADIUS_M, column
from scenes.plugins import metric_by_name
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.sticks.prototype import LUMINANCE

COUNT, SPACING_M, DEPTH_M = 13, 4.0, 12.0
FOV_DEG, SIZE_PX, EYE_M = 132.0, (960, 216), 2.6
LIGHT = Light(sun_azimuth_deg=200.0, sun_elevation_deg=40.0)
FINEST = 1e-9  # detail at which nothing is pruned [px]

Picture = Float64[np.ndarray, "height width"]

Shot = tuple[str, float]
"""One way to prune: a member of the metric family and its detail threshold τ [px]."""


@lru_cache(maxsize=1)
def colonnade() -> tuple[Placed, ...]:
    """Place columns on flat ground, from left to right."""
    return tuple(
        Placed(f"column {k}", column(), x, DEPTH_M, 0.0, _ground()) for k, x in enumerate(places())
    )


@lru_cache(maxsize=1)
def _ground() -> Terrain:
    return Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=0.8, reach=200.0)


def places() -> list[float]:
    """Return how far to the right of the view's axis each column stands [m]."""
    return [(k - (COUNT - 1) / 2) * SPACING_M for k in range(COUNT)]


def camera() -> Camera:
    """Make a level camera that looks at the middle of the row."""
    return camera_from_heading(
        Corner(0, 0), np.array((0.0, 0.0, EYE_M)), 0.0, 0.0, FOV_DEG, SIZE_PX
    )


def cut(shot: Shot) -> tuple[list[DisplayedRepresentation], list[int]]:
    """Prune the columns and the ground: what is displayed, and how many parts each column shows."""
    view = View(camera(), metric_by_name(shot[0]), shot[1])
    made, parts = [], []
    everything: tuple[Representation, ...] = (*colonnade(), _ground())
    for each in everything:
        found = prune(each, view)
        made.append(display(each, found, view))
        parts.append(len(found))
    return made, parts[:-1]


def picture(shot: Shot, quality: Quality) -> tuple[Picture, np.ndarray]:
    """Render luminance, and the number of the column in each pixel: from 1, and 0 for none."""
    visible, _ = cut(shot)
    frame = render_frame(FrameInput(camera(), tuple(visible), CLEAR, LIGHT, quality))
    number = np.where(frame.object <= COUNT, frame.object, 0)
    return frame.rgb.astype(np.float64) @ LUMINANCE, number.astype(np.int64)


def pixel_solid_angle() -> Picture:
    """Return the solid angle of each pixel of a flat film [sr]: A·cos³ ÷ the plane's distance²."""
    eye = camera()
    step = 2 * eye.tan_half[0] / eye.width
    x = ((np.arange(eye.width) + 0.5) - eye.width / 2) * step
    y = ((np.arange(eye.height) + 0.5) - eye.height / 2) * step
    return step**2 / (1 + x[None] ** 2 + y[:, None] ** 2) ** 1.5


def image_width(x: float) -> float:
    """Return the width of the image of a shaft of RADIUS_M at a place, on a plane at distance 1."""
    towards, half = math.atan2(x, DEPTH_M), math.asin(RADIUS_M / math.hypot(x, DEPTH_M))
    return math.tan(towards + half) - math.tan(towards - half)


SHOTS = ("blake", 3.0), ("blake", 8.0), ("depth", 3.0), ("depth", 8.0), ("depth", 12.0)
"""Both metrics at 3 px and at 8 px, and depth with about as many parts as blake at 8 px."""

_SPP = 16


def cases(seeds: int) -> list[Case]:
    """Return so many renders, and the case that counts parts."""
    return [*(partial(_measure_errors, k, choose()) for k in range(seeds)), partial(_measure_parts)]


def _measure_parts(seed: int) -> list[Point]:
    return [
        Point(_named(shot, k), samples=columns({"parts": [parts]}))
        for shot in SHOTS
        for k, parts in enumerate(cut(shot)[1])
    ]


def _measure_errors(number: int, variant: str, seed: int) -> list[Point]:
    quality = Quality(variant, _SPP, seed + number, 4)
    whole, owner = picture(("blake", FINEST), quality)
    seen, points = sizes(owner), []
    for shot in SHOTS:
        wrong = errors(picture(shot, quality)[0], whole, owner)
        for k in range(COUNT):
            sized = columns({name: [row[k]] for name, row in seen.items()})
            errors_ = (Column("error_ppm", [row[k]], {"weight": w}) for w, row in wrong.items())
            points.append(Point(_named(shot, k), samples=(*sized, *errors_)))
    return points


def _named(shot: Shot, column: int) -> dict[str, object]:
    place = {"column": column, "aside": places()[column]}
    return {"topic": "colonnade", "metric": shot[0], "detail": shot[1], **place}


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


BLAKE, DEPTH = ("blake", 8.0), ("depth", 12.0)
"""The metric and the detail of both cuts that are compared: they display about as many parts."""

MIDDLE, OUTER = COUNT // 2, (0, COUNT - 1)  # numbers of the middle column, and of both ends


def columns_of(points: Sequence[Point], shot: Shot) -> list[Point]:
    """Return the points of the columns of one cut, from left to right."""
    return where(points, metric=shot[0], detail=shot[1])


def over_middle(row: Sequence[Point], name: str) -> Estimate:
    """Estimate the outermost columns' value ÷ the middle one's, over renders."""
    outer = np.mean([row[k].values(name) for k in OUTER], axis=0)
    return two_sided_mean(outer / row[MIDDLE].values(name))


def parts_over_middle(row: Sequence[Point]) -> float:
    """Return the mean parts of the outermost columns ÷ those of the middle one."""
    outer = np.mean([row[k].column("parts")[0] for k in OUTER])
    return float(outer / row[MIDDLE].column("parts")[0])


def parts_in(row: Sequence[Point]) -> float:
    """Return the parts of all columns of one cut."""
    return float(sum(point.column("parts")[0] for point in row))


def mean_error(row: Sequence[Point], weight: str) -> np.ndarray:
    """Return the error of all columns together, by render, weighted ``eye`` or ``image``."""
    size = "solid_angle_usr" if weight == "eye" else "pixels"
    error = np.array([point.values("error_ppm", weight=weight) for point in row])
    return np.average(error, axis=0, weights=np.array([p.values(size) for p in row]))


def plots(record: Record) -> Iterator[Plot]:
    """Draw sizes, then errors at 8 px by both metrics and by depth with as many parts."""
    points, axis = record.points, "place of the column, to the right of the axis (m)"
    row = columns_of(points, BLAKE)
    x = [point.case["aside"] for point in row]
    law = [image_width(each) / image_width(0.0) for each in x]
    drawn = []
    for label, name in (
        ("width of the image", "shaft_mpx"),
        ("area of the image", "pixels"),
        ("solid angle", "solid_angle_usr"),
    ):
        sizes = np.array([point.values(name).mean() for point in row])
        line = (x, law) if name == "shaft_mpx" else ([], [])
        shares = (sizes / sizes[MIDDLE]).tolist()
        drawn.append(Curve(label, x, shares, line=line))
    wide, solid = drawn[0].y[-1], drawn[2].y[-1]
    axes, scale = (axis, "÷ that of the middle column"), ("linear", "log")
    panels = [Panel("Size", axes, drawn, scale)]
    drawn = []
    for metric, detail in (BLAKE, ("depth", 8.0), DEPTH):
        row = columns_of(points, (metric, detail))
        found = [point.values("error_ppm", weight="image").mean() / 1e6 for point in row]
        label = f"{metric}, {detail:g} px: {parts_in(row):.0f} parts"
        drawn.append(Curve(label, x, np.maximum(found, 1e-4).tolist()))
    panels.append(Panel("Error in the image", (axis, "share of the luminance"), drawn, scale))
    title = (
        f"To the side a column's image grows to {wide:.2f} of the middle one's width, and the "
        f"solid angle it subtends shrinks to {solid:.2f}"
    )
    caption = (
        "Equal columns in a row parallel to the picture plane, 12 m from the eye. Dashed: the "
        "width that perspective gives a shaft. Error: mean difference of luminance between the "
        "pruned and the unpruned picture, over the pixels of each column."
    )
    yield figure("colonnade", title, caption, panels)
