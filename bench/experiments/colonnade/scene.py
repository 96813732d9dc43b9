"""What does Leonardo's colonnade hold? Equal columns in a row parallel to the picture plane (§2.1).

Columns further to the side are further from the eye and subtend less of its view, yet their images
on the plane grow. One render shows both, and so it shows what each metric's cut does.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.air import CLEAR
from lod.camera import Camera, Corner, camera_from_heading
from lod.pruner import Representation, prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Quality, display
from scenes.ground.terrain import Terrain
from scenes.models.stone import RADIUS_M, column
from scenes.plugins import metric_by_name
from scenes.render.render import render_frame
from scenes.sticks.prototype import LUMINANCE
from scenes.world.light import Light

COUNT, SPACING_M, DEPTH_M = 13, 4.0, 12.0
FOV_DEG, SIZE_PX, EYE_M = 132.0, (960, 216), 2.6
LIGHT = Light(sun_azimuth_deg=200.0, sun_elevation_deg=40.0)
FINEST = 1e-9
"""Detail at which nothing is pruned [px]."""


Picture = Float64[np.ndarray, "height width"]


@dataclass(frozen=True)
class Shot:
    """One way to prune: a member of the metric family and its detail threshold τ [px]."""

    metric: str
    detail: float


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
    view = View(camera(), metric_by_name(shot.metric), shot.detail)
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
