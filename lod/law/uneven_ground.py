"""The law without full discs: hills, a field of view, offscreen detail, a finite world.

The number displayed is compound Poisson whatever the ground (Campbell's theorem; Kingman, "Poisson
Processes", 1993, §3.2): its mean is K∫n dA and its variance K∫n² dA, where n(q) is the number of
parts displayed of an object that stands at q, averaged over its headings. The integral is taken on
the nodes of a quadrature (``lod.law.ground_quadrature``), and every part of the object there is
tested by itself: no pruner, no traversal of the tree.
"""

import itertools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from lod.law.flat_ground import limits_seen
from lod.law.ground_quadrature import GroundQuadrature
from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from lod.threads import map_chunks

_ROUNDING_M = 1e-6
"""More than distances to parts are ever rounded by [m]."""


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


def count_moments(
    hierarchies: tuple[Hierarchy, ...], view: View, net: GroundQuadrature, ground: np.ndarray
) -> CountMoments:
    """Integrate n and n² over the nodes, for equally likely kinds of objects.

    ``ground`` holds the heights at the nodes, (n,) [m]. The caller gives area 0 to nodes outside a
    finite world.
    """
    levels = 1 + max(int(h.level.max()) for h in hierarchies)
    frustum = _frustum(view)

    def integral(turn: int) -> tuple[np.ndarray, np.ndarray]:
        rows = slice(turn, None, len(hierarchies))
        where = net.xy[rows], net.area[rows] * len(hierarchies), net.turn[rows], ground[rows]
        return _integrate(_parts(hierarchies[turn], view, levels), where, frustum, levels)

    kinds = len(hierarchies)
    chunks = map_chunks(lambda first, last: [*map(integral, range(first, last))], kinds, 1)
    total, by_level = np.zeros(4), np.zeros(levels)
    for sums, level_sums in itertools.chain.from_iterable(chunks):
        total += sums
        by_level += level_sums
    objects, objects_variance, parts, parts_variance = (total / len(hierarchies)).tolist()
    shares = tuple((by_level / len(hierarchies)).tolist())
    return CountMoments(objects, objects_variance, parts, parts_variance, shares)


class _FallingLimits(NamedTuple):
    """Parts of one hierarchy, the farthest limit distance first.

    limit (n,) [m]; row (n,) of the part in the hierarchy
    until (n + 1, levels) how many parts of each level stand before each place
    """

    limit: np.ndarray
    row: np.ndarray
    until: np.ndarray


def _falling(limit: np.ndarray, level: np.ndarray, levels: int) -> _FallingLimits:
    row = np.argsort(-limit, kind="stable")
    until = np.zeros((len(row) + 1, levels), np.int64)
    np.cumsum(level[row, None] == np.arange(levels), axis=0, out=until[1:])
    return _FallingLimits(limit[row], row, until)


def _parts(hierarchy: Hierarchy, view: View, levels: int) -> tuple[Any, ...]:
    """Columns of the parts, and their limits in view and out of it, falling."""
    inside = limits_seen(hierarchy, view, view.m)
    outside = limits_seen(hierarchy, view, view.m_offscreen)
    outside = np.minimum(inside, outside)  # nothing is kept only because it is out of view
    reach = hierarchy.B + view.camera.baseline_m / 2
    columns = hierarchy.position, reach, hierarchy.level, inside
    return *columns, *(_falling(limit, hierarchy.level, levels) for limit in (inside, outside))


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


@njit(cache=True, nogil=True)
def _integrate(parts, where, frustum, levels):  # type: ignore[no-untyped-def]
    """Sums of area·(objects, objects², parts, parts²) displayed, and area·parts of each level."""
    position, bound, level, inside, in_view, out_of_view = parts
    xy, area, turn, ground = where
    eye, planes, look_around = frustum
    total, by_level = np.zeros(4), np.zeros(levels)
    shown = np.zeros(levels, np.int64)
    away, holds = 0.0, 0.0  # radii about the whole's origin: of all origins, of all bounds
    for i in range(len(bound)):
        apart = 0.0
        for k in range(3):
            apart += (position[i, k] - position[0, k]) ** 2
        away, holds = max(away, math.sqrt(apart)), max(holds, math.sqrt(apart) + bound[i])
    away += _ROUNDING_M
    for q in range(len(area)):
        if area[q] == 0.0:
            continue
        c, s = math.cos(turn[q]), math.sin(turn[q])
        node = xy[q, 0] - eye[0], xy[q, 1] - eye[1], ground[q] - eye[2], c, s
        x, y, z = _placed(node, position[0])
        far = math.sqrt(x * x + y * y + z * z)
        side = 1 if look_around else _side(planes, x, y, z, holds)
        falling = in_view if side > 0 else out_of_view
        # Up to `first` all is near enough, wherever in the object; beyond `last` nothing is.
        first = _places_above(falling.limit, far + away)
        last = len(bound) if side == 0 else _places_above(falling.limit, far - away)
        for k in range(levels):
            shown[k] = falling.until[first, k]
        wholes = 1 if first > 0 else 0  # none has a farther limit than the whole, which is first
        for place in range(first, last):
            i = falling.row[place]
            limit = falling.limit[place]
            if side == 0 and inside[i] <= far - away:
                continue
            x, y, z = _placed(node, position[i])
            squared = x * x + y * y + z * z
            if side == 0 and squared >= limit * limit and _in_view(planes, x, y, z, bound[i]):
                limit = inside[i]
            if squared < limit * limit:
                shown[level[i]] += 1
                wholes += i == 0
        count = 0
        for k in range(levels):
            count += shown[k]
            by_level[k] += area[q] * shown[k]
        total[:2] += area[q] * wholes
        total[2] += area[q] * count
        total[3] += area[q] * count * count
    return total, by_level


@njit(cache=True)
def _placed(node, position):  # type: ignore[no-untyped-def]
    """Where a point of an object is that stands at a node, relative to the eye [m]."""
    x, y, z, c, s = node
    return (
        x + c * position[0] - s * position[1],
        y + s * position[0] + c * position[1],
        z + position[2],
    )


@njit(cache=True)
def _places_above(falling, value):  # type: ignore[no-untyped-def]
    """How many of some falling numbers are above a value."""
    low, high = 0, len(falling)
    while low < high:
        middle = (low + high) // 2
        if falling[middle] > value:
            low = middle + 1
        else:
            high = middle
    return low


@njit(cache=True)
def _side(planes, x, y, z, bound):  # type: ignore[no-untyped-def]
    """Whether a ball is wholly inside of all planes (1), outside of one (-1), or neither (0)."""
    side = 1
    for plane in planes:
        ahead = plane[0] * x + plane[1] * y + plane[2] * z
        if ahead <= -bound:
            return -1
        if ahead < bound:
            side = 0
    return side


@njit(cache=True)
def _in_view(planes, x, y, z, bound):  # type: ignore[no-untyped-def]
    """Whether a ball about a point relative to the eye is not wholly outside of any plane."""
    for plane in planes:
        if plane[0] * x + plane[1] * y + plane[2] * z <= -bound:
            return False
    return True
