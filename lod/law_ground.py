"""The law where no disc is whole: hills, a field of view, a coarser detail out of it, a window.

The number displayed is compound Poisson whatever the ground (Campbell's theorem; Kingman, "Poisson
Processes", 1993, §3.2): its mean is K∫n dA and its variance K∫n² dA, where n(q) is the number of parts
displayed of an object that stands at q, averaged over its headings. The integral is taken on one point
per cell of a polar net, with cells equal in log r, and every part of the object there is tested by
itself: no pruner, no walk down the tree.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lod.arrays import freeze
from lod.hierarchy import Hierarchy
from lod.law import chained_limits
from lod.view import View

_INNER_M = 0.25
"""Radius of the one disc about the eye that is not divided further."""


@dataclass(frozen=True, eq=False)
class Net:
    """Points of ground about the eye, one in each cell of a polar net.

    xy (n, 2) relative to the frame's corner [m]; area (n,) of the cell [m²]; turn (n,) heading [rad]
    """

    xy: np.ndarray
    area: np.ndarray
    turn: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, xy=np.float64, area=np.float64, turn=np.float64)


def polar_net(eye: np.ndarray, reach_m: float, rings: int, spokes: int) -> Net:
    """A net over the disc of radius ``reach_m`` about the eye; the place in each cell is drawn once."""
    chance = np.random.default_rng((rings, spokes))
    edges = np.geomspace(_INNER_M, max(reach_m, 2 * _INNER_M), rings)
    edges = np.concatenate(([0.0], edges))
    inner, outer = np.square(edges[:-1])[:, None], np.square(edges[1:])[:, None]
    shape = (rings, spokes)
    radius = np.sqrt(inner + chance.random(shape) * (outer - inner))
    angle = 2 * np.pi * (np.arange(spokes) + chance.random(shape)) / spokes
    xy = eye[:2] + np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=-1).reshape(
        -1, 2
    )
    area = np.broadcast_to(np.pi * (outer - inner) / spokes, shape).ravel()
    return Net(xy, area, 2 * np.pi * chance.random(rings * spokes))


@dataclass(frozen=True)
class Moments:
    """Mean and variance per unit density [m²]: of objects, of parts, and of parts level by level."""

    objects: float
    objects_variance: float
    parts: float
    parts_variance: float
    parts_by_level: tuple[float, ...]


def reach_of(hierarchies: tuple[Hierarchy, ...], view: View) -> float:
    """Farthest in plan that an object of these can stand and have a part displayed [m]."""
    return max(
        float(chained_limits(h, view.metric.name, view.m)[0] + np.hypot(*h.position[0, :2]))
        for h in hierarchies
    )


def moments(
    hierarchies: tuple[Hierarchy, ...], view: View, net: Net, ground: np.ndarray
) -> Moments:
    """Integrals of n and n² over the net, (n,) heights of ``ground`` [m], for equally likely kinds.

    Cells of the net outside a window are given area 0 by the caller.
    """
    levels = 1 + max(int(h.level.max()) for h in hierarchies)
    total = np.zeros(4)
    by_level = np.zeros(levels)
    for hierarchy in hierarchies:
        inside = chained_limits(hierarchy, view.metric.name, view.m)
        outside = chained_limits(hierarchy, view.metric.name, view.m_offscreen)
        tables = (hierarchy.position, hierarchy.B, hierarchy.level)
        sums, level_sums = _integrate(
            *tables, inside, outside, net.xy, net.area, net.turn, ground, *_frustum(view), levels
        )
        total += sums / len(hierarchies)
        by_level += level_sums / len(hierarchies)
    objects, objects_variance, parts, parts_variance = total.tolist()
    return Moments(objects, objects_variance, parts, parts_variance, tuple(by_level.tolist()))


def _frustum(view: View) -> tuple[np.ndarray, np.ndarray, bool]:
    """The eye, the inward unit normals of the pyramid's planes, (5, 3), and whether to look around."""
    camera = view.camera
    tan_x, tan_y = camera.tan_half
    planes = [camera.forward]
    for axis, tangent in ((camera.right, tan_x), (camera.up, tan_y)):
        for sign in (1.0, -1.0):
            planes.append((camera.forward * tangent + sign * axis) / math.hypot(1.0, tangent))
    return camera.eye, np.array(planes), view.look_around


@njit(cache=True)
def _integrate(  # type: ignore[no-untyped-def]
    position,
    bound,
    level,
    inside,
    outside,
    xy,
    area,
    turn,
    ground,
    eye,
    planes,
    look_around,
    levels,
):
    total = np.zeros(4)
    by_level = np.zeros(levels)
    for q in range(len(area)):
        if area[q] == 0.0:
            continue
        c, s = math.cos(turn[q]), math.sin(turn[q])
        shown, whole_shown = 0, 0
        for i in range(len(bound)):
            x = xy[q, 0] + c * position[i, 0] - s * position[i, 1] - eye[0]
            y = xy[q, 1] + s * position[i, 0] + c * position[i, 1] - eye[1]
            z = ground[q] + position[i, 2] - eye[2]
            seen = True
            if not look_around:
                for plane in planes:
                    seen &= plane[0] * x + plane[1] * y + plane[2] * z > -bound[i]
            limit = inside[i] if seen else outside[i]
            if x * x + y * y + z * z < limit * limit:
                shown += 1
                whole_shown += i == 0
                by_level[level[i]] += area[q]
        total[0] += area[q] * whole_shown
        total[2] += area[q] * shown
        total[3] += area[q] * shown * shown
    total[1] = total[0]
    return total, by_level
