"""The counts that the law of §4.1 predicts, with its prefactor, derived without the pruner.

Objects of density K [1/m²] stand isotropically on the ground. On flat ground, the eye h above a
part's origin, a part is displayed from a disc of area π(D² − h²), D its limit distance.

On hills, in a field of view or a finite world there are no full discs. The number displayed is
compound Poisson whatever the ground (Campbell's theorem; Kingman, "Poisson Processes", 1993, §3.2):
its mean is K∫n dA and its variance K∫n² dA, where n(q) is the number of parts displayed of an
object that stands at q, averaged over its headings. The integral is taken on the nodes of a
quadrature, and every part of the object there is tested by itself: no pruner, no traversal of the
tree.
"""

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from lod.eye import CONTRAST_CLASSES
from lod.hierarchy import Hierarchy
from lod.kernels import map_chunks, njit
from lod.metric import Metric
from lod.view import View
from lod.viewing import Defocus, ViewingConditions, WeightedDistance, defocus_width

LIMITS: dict[str, Callable[[Reals, Reals, float], Reals]] = {
    "blake": lambda P, R, m: (P + R) / m,
    "contrast_weighted": lambda P, R, m: (P + R) / m,
    "bounded": lambda P, R, m: P / m + R,
    "solid_angle": lambda P, R, m: P / m,
    "full": lambda P, R, m: np.full(len(P), np.inf),
}
"""Limit distances in clear air of the built-in metrics that have a law, apart from those that the
pruner uses (``lod.metric``): a prediction must not rest on what it tests."""


def chained_limits(
    hierarchy: Hierarchy, metric: Metric, m: float, conditions: ViewingConditions | None = None
) -> np.ndarray:
    """Compute the limit distance of every part, (n,) [m], for the metrics that have a law.

    A part is displayed while its own test and those of every part above it pass, in whatever pose:
    D = max(0, min over ancestors j of (D_j − length of the chain of separations from j down)).
    Through air, lens and eye, D_j is the farthest d of which W(d) is within its limit in clear air.
    Raises KeyError for a metric that measures depth along the axis of view: it has no law.
    """
    alone = _own_limits(hierarchy, slice(None), metric, m, conditions)
    limit, chain, above = alone.copy(), np.zeros(len(alone)), np.arange(len(alone))
    while (above > 0).any():
        chain = chain + np.where(above > 0, hierarchy.separation[above], 0.0)
        above = np.where(above > 0, hierarchy.parent[above], 0)
        limit = np.minimum(limit, alone[above] - chain)
    return np.maximum(limit, 0.0)


def limits_seen(hierarchy: Hierarchy, view: View, m: float) -> np.ndarray:
    """Compute the limit distances of a view's parts at a detail angle m [rad], (n,) [m].

    Of two eyes what either can see is displayed: the distance from their middle is up to half a
    baseline greater.
    """
    limits = chained_limits(hierarchy, view.metric, m, view.conditions)
    limits[limits > 0] += view.camera.baseline_m / 2
    return limits


def max_ground_distance(hierarchies: tuple[Hierarchy, ...], view: View) -> float:
    """Compute the greatest horizontal distance of an object that has a part displayed [m]."""
    greatest = 0.0
    for each in hierarchies:
        whole = _own_limits(each, slice(1), view.metric, view.m, view.conditions)[0]
        offset = float(np.hypot(*each.position[0, :2]))
        greatest = max(greatest, max(0.0, float(whole)) + view.camera.baseline_m / 2 + offset)
    return greatest


def _own_limits(
    hierarchy: Hierarchy,
    rows: slice,
    metric: Metric,
    m: float,
    conditions: ViewingConditions | None,
) -> Reals:
    """Distances to which the own tests of these parts pass, those of their wholes aside, (n,)."""
    if metric.along_axis:
        raise KeyError(metric.name)
    # A metric of another package is known by its own formula alone.
    formula = LIMITS.get(metric.name, metric.limit)
    clear = formula(hierarchy.P[rows], hierarchy.R[rows], m)
    if metric.by_contrast:
        beta = conditions.extinction if conditions else 0.0
        clear = _weighted_by_contrast(clear, hierarchy.contrast_to_whole[rows], beta)
    if conditions is None or not metric.finite:
        return clear
    seen, contrast = np.empty_like(clear), hierarchy.contrast[rows]
    for row in np.unique(contrast):
        of_class = contrast == row
        seen[of_class] = _reached(conditions.weighted(CONTRAST_CLASSES[row], m), clear[of_class])
    if conditions.defocus is None:
        return seen
    theta = conditions.widths.effective
    return np.minimum(seen, _farthest_sharp(clear, conditions.defocus, theta))


def _weighted_by_contrast(clear: Reals, contrast: Reals, extinction: float) -> Reals:
    """Distance up to which d stays below contrast·exp(−βd)·D_c, by bisection, (n,) [m]."""
    near, far = np.zeros_like(clear), contrast * clear
    for _ in range(60):  # down to the last bits of a float64
        middle = (near + far) / 2
        passes = middle < contrast * np.exp(-extinction * middle) * clear
        near, far = np.where(passes, middle, near), np.where(passes, far, middle)
    return far


def _reached(W: WeightedDistance, clear: Reals) -> Reals:
    """Greatest d with W(d) ≤ these limits, (n,) [m], by false position.

    It is the Illinois method (Dowell & Jarratt, "A modified regula falsi method for computing the
    root of an equation", BIT 11:168, 1971); W(d) ≥ d brackets every root.
    """
    found, exact = np.minimum(clear, W.vanishing_distance), 1e-14
    missed = W.weight(found) - clear
    rows = np.flatnonzero(missed > exact * clear)
    near, far, below, above = np.zeros(len(rows)), found[rows], -clear[rows], missed[rows]
    for _ in range(200):  # more steps than any ever took
        if not len(rows):
            break
        at = far - above * (far - near) / (above - below)
        missed = W.weight(at) - clear[rows]
        found[rows] = at
        short = missed <= 0
        # The end that stays counts half from now on, so that the next step passes the root.
        below, above = np.where(short, missed, below / 2), np.where(short, above / 2, missed)
        near, far = np.where(short, at, near), np.where(short, far, at)
        open_ = np.abs(missed) > exact * clear[rows]
        rows, near, far = rows[open_], near[open_], far[open_]
        below, above = below[open_], above[open_]
    return found


def _farthest_sharp(clear: Reals, defocus: Defocus, theta: float) -> Reals:
    """Distance up to which τ·θ_eff(d)·d stays within τ·θ·D_c, by bisection, (n,) [m].

    It begins where a part is sharpest for its distance; what is too small there is nowhere seen.
    """
    start = max(defocus.sharpest_m(theta), 1e-9)
    near, far = np.full_like(clear, start), np.maximum(clear, start)

    def blurred(d: Reals) -> Reals:
        return np.hypot(theta, defocus_width(defocus, d)) / theta * d

    never = blurred(near) >= clear
    for _ in range(60):  # down to the last bits of a float64
        middle = (near + far) / 2
        within = blurred(middle) <= clear
        near, far = np.where(within, middle, near), np.where(within, far, middle)
    return np.where(never, 0.0, far)


def disc_areas(D: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Compute the area of ground from which a part is displayed, π·max(0, D² − h²), (n,) [m²]."""
    return np.pi * np.maximum(np.square(D) - np.square(h), 0.0)


def expected_count(K: float, areas: np.ndarray) -> float:
    """Compute the expected number of parts displayed, K·Σ areas; of objects, given wholes only."""
    return K * float(np.sum(areas))


def count_variance(K: float, areas: np.ndarray) -> float:
    """Compute the variance of the number displayed, K·ΣᵢΣⱼ min(areaᵢ, areaⱼ): compound Poisson.

    Parts of one object come together: the discs are concentric, so those of i and j overlap in the
    smaller one. With areas sorted downwards, ΣΣ min = Σ (2k + 1)·area_k, k = 0, 1, …
    """
    down = np.sort(np.asarray(areas, np.float64))[::-1]
    return K * float(np.sum((2 * np.arange(len(down)) + 1) * down))


@dataclass(frozen=True, eq=False)
class GroundQuadrature(ArrayData):
    """Quadrature nodes on the ground around the eye, at which objects are tested.

    Kinds of objects take turns: of k kinds the i-th is tested at the nodes i, i + k, i + 2k, …

    xy    (n, 2) position relative to the frame's corner [m]
    area  (n,) area that stands for the node; that of each kind's nodes is a k-th of its disc's [m²]
    turn  (n,) heading of the object that is tested there [rad]
    """

    xy: FloatArray
    area: FloatArray
    turn: FloatArray


def ground_nodes(
    hierarchies: tuple[Hierarchy, ...], view: View, nodes: int, farthest_m: float = math.inf
) -> GroundQuadrature:
    """Lay about so many nodes over the discs in which objects of these kinds may be displayed.

    Every kind has as many nodes in its own disc, none of which reaches beyond ``farthest_m``.
    """
    farthest = [min(max_ground_distance((h,), view), farthest_m) for h in hierarchies]
    return spread_nodes(np.array(farthest), view, nodes)


def spread_nodes(
    farthest_m: Reals, view: View, nodes: int, by_area: float = 0.7
) -> GroundQuadrature:
    """Lay about so many nodes over discs about the eye, one for each kind of objects.

    One kind after the other they follow Roberts's sequence R₂ ("The unreasonable effectiveness of
    quasirandom sequences", 2018) in the plane of the shares that radius and angle are chosen by,
    and multiples of √2 by heading. A share ``by_area`` of them stands in a ring for its area and
    the rest for its logarithmic width, since the rim of each disc decides how many objects there
    are and every octave of distance has parts of its own; half of them stand where the camera
    looks.
    """
    kinds = len(farthest_m)
    of_kind = max(nodes // kinds, 1)
    place = np.arange(kinds * of_kind).reshape(kinds, of_kind).T.ravel()
    plastic = 1.32471795724474602596  # the root of x³ = x + 1
    steps = 1 / plastic, 1 / plastic**2, math.sqrt(2.0)
    shares = (0.5 + np.multiply.outer(place, steps)) % 1.0
    reach = np.tile(farthest_m, of_kind)
    inner = 0.25  # radius of the one disc about the eye that is not divided further [m]
    first_ring = inner / max(float(reach.max()), 2 * inner)
    radius, spread = _radii(shares[:, 0], first_ring, by_area)
    # Half of the nodes are spread over the whole turn, half over the sector that is in view.
    heading, half = _seen_sector(view)
    seen = 0.5 + 0.5 * half / np.pi
    width = np.where(shares[:, 1] < seen, 2 * half / seen, 4 * np.pi)  # d angle ÷ d share
    angle = heading + half + (shares[:, 1] - seen) * width
    around = (radius * reach)[:, None] * np.stack((np.cos(angle), np.sin(angle)), axis=-1)
    area = spread * np.square(reach) * width / len(reach)
    return GroundQuadrature(view.camera.eye[:2] + around, area, 2 * np.pi * shares[:, 2])


def _radii(share: Reals, inner: float, by_area: float, rings: int = 1024) -> tuple[Reals, Reals]:
    """Radii in a unit disc that have these shares of the nodes within, and r·dr ÷ d share there.

    inner  radius of the disc that is the first of the rings, in each of which nodes are even
    """
    edges = np.concatenate(([0.0], np.geomspace(inner, 1.0, rings)))
    within = by_area * np.square(edges) + (1 - by_area) * np.linspace(0.0, 1.0, len(edges))
    ring = np.searchsorted(within[1:-1], share, side="right")
    spread = (np.diff(np.square(edges)) / np.diff(within))[ring]
    squared = np.square(edges[ring]) + (share - within[ring]) * spread
    return np.sqrt(squared), spread / 2


def _seen_sector(view: View) -> tuple[float, float]:
    """Heading of the view and half the angle of ground that may be in the picture [rad].

    It is the whole turn where the picture may hold the nadir or the zenith.
    """
    camera = view.camera
    forward, steep = camera.forward, abs(float(camera.forward[2])) * camera.corner_secant >= 1
    if view.look_around or camera.panorama or steep:
        return 0.0, math.pi
    tan_x, tan_y = camera.tan_half
    across, upward = tan_x * camera.right, tan_y * camera.up
    corners = np.array([forward + x * across + y * upward for x in (-1, 1) for y in (-1, 1)])
    ahead = corners[:, :2] @ forward[:2]
    aside = corners[:, 1] * forward[0] - corners[:, 0] * forward[1]
    half = float(np.abs(np.arctan2(aside, ahead)).max())
    return math.atan2(forward[1], forward[0]), half


@dataclass(frozen=True)
class CountMoments:
    """Mean and variance per unit density [m²], of objects and parts; mean of parts by level."""

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
    kinds, levels = len(hierarchies), 1 + max(int(h.level.max()) for h in hierarchies)
    camera, planes = view.camera, []  # inward unit normals of the pyramid's
    if not view.look_around:
        planes.append(camera.forward)
        for axis, tangent in zip((camera.right, camera.up), camera.tan_half, strict=True):
            for sign in (1.0, -1.0):
                planes.append((camera.forward * tangent + sign * axis) / math.hypot(1.0, tangent))
    frustum = camera.eye, np.array(planes).reshape(-1, 3), view.look_around

    def integral(kind: int) -> tuple[np.ndarray, np.ndarray]:
        rows = slice(kind, None, kinds)
        where = net.xy[rows], net.area[rows] * kinds, net.turn[rows], ground[rows]
        hierarchy = hierarchies[kind]
        inside = limits_seen(hierarchy, view, view.m)
        # Nothing is kept only because it is out of view, and nothing there of what thins out.
        outside = np.minimum(inside, limits_seen(hierarchy, view, view.m_offscreen))
        if hierarchy.is_thinned and view.metric.finite:
            outside = np.zeros_like(inside)
        falling = (_FallingLimits.of(each, hierarchy.level, levels) for each in (inside, outside))
        bound = hierarchy.B + view.camera.baseline_m / 2
        parts = hierarchy.position, bound, hierarchy.level, inside, *falling
        return _integrate(parts, where, frustum, levels)

    chunks = map_chunks(lambda first, last: [*map(integral, range(first, last))], kinds, 1)
    total, by_level = np.zeros(4), np.zeros(levels)
    for sums, level_sums in itertools.chain.from_iterable(chunks):
        total += sums
        by_level += level_sums
    objects, objects_variance, parts, parts_variance = (total / kinds).tolist()
    shares = tuple((by_level / kinds).tolist())
    return CountMoments(objects, objects_variance, parts, parts_variance, shares)


class _FallingLimits(NamedTuple):
    """Parts of one hierarchy, the farthest limit distance first.

    limit (n,) [m]; row (n,) of the part in the hierarchy
    until (n + 1, levels) how many parts of each level stand before each place
    """

    limit: np.ndarray
    row: np.ndarray
    until: np.ndarray

    @staticmethod
    def of(limit: np.ndarray, level: np.ndarray, levels: int) -> "_FallingLimits":
        row = np.argsort(-limit, kind="stable")
        until = np.zeros((len(row) + 1, levels), np.int64)
        np.cumsum(level[row, None] == np.arange(levels), axis=0, out=until[1:])
        return _FallingLimits(limit[row], row, until)


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
    away += 1e-6  # more than distances to parts are ever rounded by
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
    x, y, z, c, s = node
    return (
        x + c * position[0] - s * position[1],
        y + s * position[0] + c * position[1],
        z + position[2],
    )


@njit(cache=True)
def _places_above(falling, value):  # type: ignore[no-untyped-def]
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
    for plane in planes:
        if plane[0] * x + plane[1] * y + plane[2] * z <= -bound:
            return False
    return True
