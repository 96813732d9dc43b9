"""What of the ground is hidden behind nearer ground: a floating horizon, column by column.

Directions in view are parted into columns, and each is followed outward: how high has the ground
reached so far, seen from the eye (Wright 1973, "A two-space solution to the hidden line problem for
plotting functions of two variables"; for tiles of terrain, Stewart 1998, "Hierarchical visibility
in terrains")? A tile is hidden where it ends below that all along its width. Then nothing of it is
seen, and it needs no more detail than what is out of view.

Between columns the ground may lie lower: what is too short for them is taken off, by as much as it
rarely exceeds. What is drawn may differ from the relief by as much as its detail allows, which is
asked for as a margin.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lod.arrays import Points, freeze
from lod.pruning.view import View
from scenes.terrain.relief import Relief

COLUMN_PX = 12.0
"""Width of a column at the picture's centre [px]."""

GROWTH = 1.08
"""Times each sample of a column is further from the eye than the one before."""

_NEAREST_M = 4.0
_LEAST_AHEAD = 0.1
"""Cosine between the middle of the picture and its corners, on the map, below which there are no
columns: the eye looks up or down too steeply."""


@dataclass(frozen=True, eq=False)
class Horizon:
    """How high the ground has risen, by direction and distance on the map.

    axes (2, 2)   unit vectors on the map, ahead and to the right
    first, step   angle to the right of the first column, and between columns [rad]
    ranges (k,)   distances on the map, growing [m]
    rise (c, k)   greatest tangent above the eye's level of the ground no farther than that
    margin        tangent by which a tile must end below it
    """

    axes: np.ndarray
    first: float
    step: float
    ranges: np.ndarray
    rise: np.ndarray
    margin: float

    def __post_init__(self) -> None:
        freeze(self, axes=np.float64, ranges=np.float64, rise=np.float64)

    def hides(self, view: View, low: Points, high: Points) -> np.ndarray:
        """Whether each box, from the corner ``low`` to ``high`` (n, 3), is hidden, (n,)."""
        columns = self.first, self.step, self.ranges, self.rise, self.margin
        return _hidden(low, high, view.camera.eye, self.axes, *columns)


def horizon(relief: Relief, view: View, reach: float) -> Horizon | None:
    """The horizon of a view, out to ``reach`` [m]; None where nothing can be told from it."""
    span = _span(view)
    if relief.amplitude == 0 or span is None:
        return None
    axes, first, last = span
    step = COLUMN_PX * view.camera.pixel_angle
    count = math.ceil((last - first) / step) + 1
    ranges = _NEAREST_M * GROWTH ** np.arange(math.ceil(math.log(reach, GROWTH)))
    angle = first + step * np.arange(count)
    direction = np.outer(np.cos(angle), axes[0]) + np.outer(np.sin(angle), axes[1])
    # Columns side by side, which share what is known of long waves.
    xy = view.camera.eye[:2] + direction * ranges[:, None, None]
    shortest = 4 * step * ranges
    smooth = relief.low_pass_height(
        view.camera.corner, xy.reshape(-1, 2), np.repeat(shortest, count)
    )
    lowest = smooth.reshape(-1, count).T - relief.likely_below(shortest)
    rise = (lowest - view.camera.eye[2]) / ranges
    rise = np.maximum.accumulate(rise, axis=1)
    return Horizon(axes, first, step, ranges, rise, view.m_offscreen)


def _span(view: View) -> tuple[np.ndarray, float, float] | None:
    """Axes on the map, and the angles to the right between which all in view lies [rad]."""
    camera = view.camera
    if view.look_around or view.metric.along_axis or not view.metric.finite:
        return None
    ahead = camera.forward[:2] / (np.hypot(*camera.forward[:2]) or 1.0)
    axes = np.stack((ahead, (ahead[1], -ahead[0])))
    tan_x, tan_y = camera.tan_half
    corners = [
        camera.forward + x * tan_x * camera.right + y * tan_y * camera.up
        for x in (-1, 1)
        for y in (-1, 1)
    ]
    flat = np.array(corners)[:, :2] @ axes.T
    if np.any(flat[:, 0] <= _LEAST_AHEAD * np.linalg.norm(corners, axis=1)):
        return None
    angle = np.arctan2(flat[:, 1], flat[:, 0])
    return axes, float(angle.min()), float(angle.max())


def outside_picture(view: View, low: Points, high: Points) -> np.ndarray:
    """Whether each box is beside the picture, by more than what is hidden may be off, (n,).

    Plane by plane: closer than a sphere about it tells, which low hills below the eye fill.
    """
    camera = view.camera
    if view.look_around or view.metric.along_axis or not view.metric.finite:
        return np.zeros(len(low), bool)
    inward = [
        (tangent * camera.forward + side * axis) / math.hypot(1.0, tangent)
        for axis, tangent in zip((camera.right, camera.up), camera.tan_half, strict=True)
        for side in (-1, 1)
    ]
    return np.asarray(_outside(low, high, camera.eye, np.array(inward), view.m_offscreen))


@njit(cache=True)
def _outside(low, high, eye, inward, margin):  # type: ignore[no-untyped-def]
    outside = np.zeros(len(low), np.bool_)
    for i in range(len(low)):
        square = 0.0
        for k in range(3):
            square += (min(max(eye[k], low[i, k]), high[i, k]) - eye[k]) ** 2
        beyond = -margin * math.sqrt(square)
        for plane in inward:
            deepest = 0.0
            for k in range(3):
                deepest += ((high if plane[k] >= 0.0 else low)[i, k] - eye[k]) * plane[k]
            outside[i] |= deepest < beyond
    return outside


@njit(cache=True)
def _hidden(low, high, eye, axes, first, step, ranges, rise, margin):  # type: ignore[no-untyped-def]
    hidden = np.zeros(len(low), np.bool_)
    last = first + step * (len(rise) - 1)
    for i in range(len(low)):
        least, most, farthest, ahead = np.inf, -np.inf, 0.0, True
        for c in range(4):
            x = (low[i, 0] if c & 1 else high[i, 0]) - eye[0]
            y = (low[i, 1] if c & 2 else high[i, 1]) - eye[1]
            along, aside = axes[0, 0] * x + axes[0, 1] * y, axes[1, 0] * x + axes[1, 1] * y
            angle, ahead = np.arctan2(aside, along), ahead and along > 0.0
            least, most = min(least, angle), max(most, angle)
            farthest = max(farthest, np.hypot(x, y))
        x = min(max(eye[0], low[i, 0]), high[i, 0]) - eye[0]
        y = min(max(eye[1], low[i, 1]), high[i, 1]) - eye[1]
        nearest = np.hypot(x, y)
        reached = np.searchsorted(ranges, nearest, side="right") - 1
        if reached < 0 or not ahead or most < first or least > last:
            continue
        top = high[i, 2] - eye[2]
        top = top / nearest if top > 0.0 else top / farthest
        from_column = max(0, int(np.floor((least - first) / step)))
        to_column = min(len(rise) - 1, int(np.ceil((most - first) / step)))
        hidden[i] = True
        for c in range(from_column, to_column + 1):
            if rise[c, reached] < top + margin:
                hidden[i] = False
                break
    return hidden
