"""The law without full discs: hills, a field of view, offscreen detail, a finite world.

The number displayed is compound Poisson whatever the ground (Campbell's theorem; Kingman, "Poisson
Processes", 1993, §3.2): its mean is K∫n dA and its variance K∫n² dA, where n(q) is the number of
parts displayed of an object that stands at q, averaged over its headings. The integral is taken on
one point per cell of a polar net, with cells equal in log r, and every part of the object there is
tested by itself: no pruner, no traversal of the tree.
"""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

from lod.arrays import ArrayData, FloatArray
from lod.law.flat_ground import chained_limits
from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View

_INNER_M = 0.25
"""Radius of the one disc about the eye that is not divided further."""


@dataclass(frozen=True, eq=False)
class PolarQuadrature(ArrayData):
    """Quadrature nodes on the ground around the eye, one in each cell of a polar grid.

    xy    (n, 2) position relative to the frame's corner [m]
    area  (n,) area of the cell [m²]
    turn  (n,) heading of the object that is tested there [rad]
    """

    xy: FloatArray
    area: FloatArray
    turn: FloatArray


def polar_quadrature(eye: np.ndarray, reach_m: float, rings: int, spokes: int) -> PolarQuadrature:
    """Build the quadrature over the disc of radius ``reach_m`` about the eye.

    The node of each cell is random, with a seed that depends on ``rings`` and ``spokes`` only.
    """
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
    return PolarQuadrature(xy, area, 2 * np.pi * chance.random(rings * spokes))


@dataclass(frozen=True)
class CountMoments:
    """Mean and variance per unit density [m²]: of objects, of parts, and of parts level by
    level.
    """

    objects: float
    objects_variance: float
    parts: float
    parts_variance: float
    parts_by_level: tuple[float, ...]


def max_ground_distance(hierarchies: tuple[Hierarchy, ...], view: View) -> float:
    """Compute the greatest horizontal distance of an object that has a part displayed [m]."""
    return max(
        float(
            chained_limits(h, view.metric, view.m, view.conditions)[0]
            + np.hypot(*h.position[0, :2])
        )
        for h in hierarchies
    )


def count_moments(
    hierarchies: tuple[Hierarchy, ...], view: View, net: PolarQuadrature, ground: np.ndarray
) -> CountMoments:
    """Integrate n and n² over the nodes, for equally likely kinds of objects.

    ``ground`` holds the heights at the nodes, (n,) [m]. Kinds take turns
    along each ring. The caller gives area 0 to cells outside a finite world.
    """
    levels = 1 + max(int(h.level.max()) for h in hierarchies)
    total, by_level = np.zeros(4), np.zeros(levels)
    for turn, hierarchy in enumerate(hierarchies):
        rows = slice(turn, None, len(hierarchies))
        where = net.xy[rows], net.area[rows] * len(hierarchies), net.turn[rows], ground[rows]
        sums, level_sums = _integrate(
            _parts_by_distance(hierarchy, view), where, _frustum(view), levels
        )
        total += sums
        by_level += level_sums
    objects, objects_variance, parts, parts_variance = (total / len(hierarchies)).tolist()
    shares = tuple((by_level / len(hierarchies)).tolist())
    return CountMoments(objects, objects_variance, parts, parts_variance, shares)


def _parts_by_distance(hierarchy: Hierarchy, view: View) -> tuple[np.ndarray, ...]:
    """Columns of the parts, those first that are displayed at the greatest horizontal distance."""
    inside = chained_limits(hierarchy, view.metric, view.m, view.conditions)
    outside = chained_limits(hierarchy, view.metric, view.m_offscreen, view.conditions)
    outside = np.minimum(inside, outside)  # nothing is kept only because it is out of view
    farthest = inside + np.hypot(hierarchy.position[:, 0], hierarchy.position[:, 1])
    order = np.argsort(-farthest, kind="stable")
    tables = (hierarchy.position, hierarchy.B, hierarchy.level, inside, outside, farthest)
    return *(table[order] for table in tables), order == 0


def _frustum(view: View) -> tuple[np.ndarray, np.ndarray, bool]:
    """The eye, the inward unit normals of the pyramid's planes, (5, 3), and whether to look
    around.
    """
    camera = view.camera
    if view.look_around:
        return camera.eye, np.zeros((0, 3)), True
    tan_x, tan_y = camera.tan_half
    planes = [camera.forward]
    for axis, tangent in ((camera.right, tan_x), (camera.up, tan_y)):
        for sign in (1.0, -1.0):
            planes.append((camera.forward * tangent + sign * axis) / math.hypot(1.0, tangent))
    return camera.eye, np.array(planes), view.look_around


@njit(cache=True)
def _integrate(falling, where, frustum, levels):  # type: ignore[no-untyped-def]
    """Sums of area·(objects, objects², parts, parts²) displayed, and area·parts of each level."""
    position, bound, level, inside, outside, farthest, is_whole = falling
    xy, area, turn, ground = where
    eye, planes, look_around = frustum
    total = np.zeros(4)
    by_level = np.zeros(levels)
    for q in range(len(area)):
        if area[q] == 0.0:
            continue
        c, s = math.cos(turn[q]), math.sin(turn[q])
        in_plan = math.hypot(xy[q, 0] - eye[0], xy[q, 1] - eye[1])
        parts, wholes = 0, 0
        for i in range(len(bound)):
            if in_plan > farthest[i]:
                break
            x = xy[q, 0] + c * position[i, 0] - s * position[i, 1] - eye[0]
            y = xy[q, 1] + s * position[i, 0] + c * position[i, 1] - eye[1]
            z = ground[q] + position[i, 2] - eye[2]
            seen = look_around or _in_view(planes, x, y, z, bound[i])
            limit = inside[i] if seen else outside[i]
            if x * x + y * y + z * z < limit * limit:
                parts += 1
                wholes += is_whole[i]
                by_level[level[i]] += area[q]
        total[:2] += area[q] * wholes
        total[2] += area[q] * parts
        total[3] += area[q] * parts * parts
    return total, by_level


@njit(cache=True)
def _in_view(planes, x, y, z, bound):  # type: ignore[no-untyped-def]
    """Whether a ball about a point relative to the eye is not wholly outside of any plane."""
    for plane in planes:
        if plane[0] * x + plane[1] * y + plane[2] * z <= -bound:
            return False
    return True
