"""Occlusion of the ground by nearer ground: a floating horizon, column by column.

Directions in view are divided into columns, and each is followed outward: how high has the ground
reached so far, seen from the eye (Wright 1973, "A two-space solution to the hidden line problem for
plotting functions of two variables"; for tiles of terrain, Stewart 1998, "Hierarchical visibility
in terrains")? A tile is hidden where it ends below that all along its width. Then nothing of it is
seen, and it needs no more detail than what is out of view.

Between columns the ground may lie lower: the height that waves too short for the columns rarely
exceed is subtracted, so columns are narrow. The mesh may differ from the relief by as much as its
detail allows, and a margin covers that.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Points
from lod.view import View
from scenes.terrain.relief import Relief

COLUMN_PX = 6.0
"""Width of a column at the picture's centre [px]."""

GROWTH = 1.04
"""Ratio of the distances of a column's samples that follow each other."""

_NEAREST_M = 4.0
_LEAST_AHEAD = 0.1
"""Least cosine on the map between the middle of the picture and its corners.

Below it the eye looks up or down too steeply for columns.
"""


class Columns(NamedTuple):
    """Elevation of the ground's horizon by direction and distance on the map.

    axes (2, 2)  unit vectors on the map, ahead and to the right
    first, step  angle to the right of the first column, and between columns [rad]
    ranges (k,)  distances on the map, ascending [m]
    rise (c, k)  largest tangent of elevation of the ground no farther than each range
    """

    axes: np.ndarray
    first: float
    step: float
    ranges: np.ndarray
    rise: np.ndarray


@dataclass(frozen=True, eq=False)
class Horizon:
    """The horizon of a view; a tile must end below it by a tangent of ``margin`` to be hidden."""

    columns: Columns
    margin: float

    def hides(self, view: View, low: Points, high: Points) -> np.ndarray:
        """Whether the ground hides each box, from its corner ``low`` to ``high`` (n, 3), (n,)."""
        return _hidden(low, high, view.camera.eye, self.columns, self.margin)


def horizon(relief: Relief, view: View, reach: float) -> Horizon | None:
    """The horizon of a view out to ``reach`` [m], or None where there is none.

    There is none on flat ground, for an eye that looks steeply up or down or all round, and for
    the metrics that do not cull by it.
    """
    span = _span(view)
    if relief.amplitude == 0 or span is None:
        return None
    axes, first, last = span
    step = COLUMN_PX * view.camera.pixel_angle
    count = math.ceil((last - first) / step) + 1
    ranges = _NEAREST_M * GROWTH ** np.arange(math.ceil(math.log(reach, GROWTH)))
    angle = first + step * np.arange(count)
    direction = np.outer(np.cos(angle), axes[0]) + np.outer(np.sin(angle), axes[1])
    # Samples side by side follow each other, so that they share the lattice cells of long waves.
    xy = view.camera.eye[:2] + direction * ranges[:, None, None]
    shortest = 4 * step * ranges
    smooth = relief.low_pass_height(
        view.camera.corner, xy.reshape(-1, 2), np.repeat(shortest, count)
    )
    lowest = smooth.reshape(-1, count).T - relief.likely_below(shortest)
    rise = (lowest - view.camera.eye[2]) / ranges
    rise = np.maximum.accumulate(rise, axis=1)
    return Horizon(Columns(axes, first, step, ranges, rise), view.m_offscreen)


def _span(view: View) -> tuple[np.ndarray, float, float] | None:
    """Axes on the map, and least and largest angle to the right of anything in view [rad]."""
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


def outside_picture(
    view: View, low: Points, high: Points, moved: Points | None = None
) -> np.ndarray:
    """Whether each box is outside the picture by more than the margin of detail, (n,).

    Boxes are tested against each plane of the frustum, which is closer than their spheres: flat
    boxes fill little of those. With ``moved`` (n, 3), all must be outside that a box passes over
    as it is moved so far [m].
    """
    camera = view.camera
    if view.look_around or view.metric.along_axis or not view.metric.finite:
        return np.zeros(len(low), bool)
    inward = [
        (tangent * camera.forward + side * axis) / math.hypot(1.0, tangent)
        for axis, tangent in zip((camera.right, camera.up), camera.tan_half, strict=True)
        for side in (-1, 1)
    ]
    ways = np.zeros_like(low) if moved is None else moved
    return np.asarray(_outside(low, high, ways, camera.eye, np.array(inward), view.m_offscreen))


@njit(cache=True)
def _outside(low, high, ways, eye, inward, margin):  # type: ignore[no-untyped-def]
    """Whether boxes lie beyond a plane through the eye, by a margin times their distance, before
    and after they are moved, (n,)."""
    outside = np.zeros(len(low), np.bool_)
    for i in range(len(low)):
        square = 0.0
        for k in range(3):
            square += (min(max(eye[k], low[i, k]), high[i, k]) - eye[k]) ** 2
        beyond = -margin * math.sqrt(square)
        for plane in inward:
            deepest, deeper = 0.0, 0.0
            for k in range(3):
                deepest += ((high if plane[k] >= 0.0 else low)[i, k] - eye[k]) * plane[k]
                deeper += ways[i, k] * plane[k]
            outside[i] |= deepest + max(deeper, 0.0) < beyond
    return outside


@njit(cache=True)
def _hidden(low, high, eye, columns, margin):  # type: ignore[no-untyped-def]
    """Whether boxes end below the horizon of all columns that they span, (n,)."""
    axes, first, step, ranges, rise = columns
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
