"""Tiles of the ground: their limit distances, what nearer ground hides, and patches to be drawn.

**Patches.** A patch is a quarter of a tile. Patches form a linear quadtree: sorted by Morton code,
each covers an interval of codes (Gargantini 1982, "An effective way to represent quadtrees"). Where
neighbours differ too much the coarser patch is split (restricted quadtrees: Von Herzen & Barr 1987,
"Accurate triangulations of deformed, intersecting surfaces").

**Limits.** For a tile of spacing s, where the eye sees ground of mean inclination t
(``seen_tilt``):

    P  √(s·(h + (2/π)²·t·s)), h the RMS of its octave, or of ridged relief the height of its crests
    R  the height that the still shorter octaves, left to the tile's own parts, rarely exceed

``docs/ground.md`` says why. R is no hard bound: all crests of all octaves in one place would make
one 2 to 3 times as high, which costs steep ground three times the triangles for no better a
skyline. All are the bumps' own, not the tile's, so the cut does not depend on how many quads a tile
has.

**Occlusion** by nearer ground is a floating horizon, column by column. Directions in view are
divided into columns, and each is followed outward: how high has the ground reached so far, seen
from the eye (Wright 1973, "A two-space solution to the hidden line problem for plotting functions
of two variables"; for tiles of terrain, Stewart 1998, "Hierarchical visibility in terrains")? A
tile is hidden where it ends below that all along its width. Then nothing of it is seen, and it
needs no more detail than what is out of view.

Between columns the ground may lie lower: the height that waves too short for the columns rarely
exceed is subtracted, so columns are narrow. The mesh may differ from the relief by as much as its
detail allows, and a margin covers that.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Int64

from lod.arrays import Ints, Points, Reals, freeze
from lod.kernels import njit
from lod.metric import blake, seen_by_contrast
from lod.view import View
from lod.viewing import perceptual_limits
from scenes.ground.relief import Relief
from scenes.ground.shading import seen_slopes
from scenes.sticks.prototype import GROUND_CONTRAST

SIDES = ((0, -1), (1, 0), (0, 1), (-1, 0))
"""Steps to the neighbour across each side: south, east, north, west."""

QUARTERS = np.array(((0, 0), (1, 0), (0, 1), (1, 1)))
"""Places of the quarters of a square, counted in their own sides."""

Squares = tuple[Int64[np.ndarray, " q"], Int64[np.ndarray, " q"], Int64[np.ndarray, " q"]]
"""Level, x and y of squares of a quadtree, x and y counted in their own sides."""


@dataclass(frozen=True, eq=False)
class Patches:
    """Disjoint squares of a quadtree, in order of their Morton codes.

    depth (n,)  halvings from a root tile's side
    x, y (n,)   place, in sides of the patch itself
    owner (n,)  row of the tile that draws the patch
    deepest     depth of the squares that codes number
    """

    depth: np.ndarray
    x: np.ndarray
    y: np.ndarray
    owner: np.ndarray
    deepest: int

    def __post_init__(self) -> None:
        order = np.argsort(self.code(self.x, self.y), kind="stable")
        for name in ("depth", "x", "y", "owner"):
            object.__setattr__(self, name, getattr(self, name)[order])
        freeze(self, depth=np.int64, x=np.int64, y=np.int64, owner=np.int64)

    def __len__(self) -> int:
        return len(self.depth)

    def code(self, x: Ints, y: Ints) -> Ints:
        """Morton codes, at the deepest level, of squares (x, y) of the patches' own sizes."""
        fine = self.deepest - self.depth
        return morton(x << fine, y << fine)


def morton(x: Ints, y: Ints) -> Ints:
    """Morton codes: the bits of x and y in turns, x lowest (Morton 1966)."""
    return _spread(x) | (_spread(y) << 1)


def _spread(v: Ints) -> Ints:
    for shift, mask in (
        (16, 0x0000FFFF0000FFFF),
        (8, 0x00FF00FF00FF00FF),
        (4, 0x0F0F0F0F0F0F0F0F),
        (2, 0x3333333333333333),
        (1, 0x5555555555555555),
    ):
        v = (v | (v << shift)) & mask
    return v


def uncovered_quarters(level: Ints, x: Ints, y: Ints) -> Patches:
    """Patches of the displayed tiles: every quarter of a tile that no displayed tile covers."""
    squares = quarters(level, x, y)
    free = ~np.isin(_name(*squares), _name(level, x, y))
    owner = np.repeat(np.arange(len(level)), 4)
    depth, x, y = (column[free] for column in squares)
    return Patches(depth, x, y, owner[free], int(level.max()) + 1)


def quarters(level: Ints, x: Ints, y: Ints) -> Squares:
    """Level, x and y of the four quarters of each square, four rows for each."""
    quarter_x, quarter_y = 2 * x[:, None] + QUARTERS[:, 0], 2 * y[:, None] + QUARTERS[:, 1]
    return np.repeat(level + 1, 4), quarter_x.ravel(), quarter_y.ravel()


def _name(level: Ints, x: Ints, y: Ints) -> Ints:
    """Number of each square among those of all levels."""
    return (morton(x, y) << 6) | level


def balance(patches: Patches, most: int) -> tuple[Patches, Int64[np.ndarray, "n 4"]]:
    """Patches split until neighbours differ by at most ``most`` halvings, and by how many they do.

    The second result (n, 4) is how many halvings coarser the neighbour across each of SIDES is, at
    least 0.
    """
    while True:
        neighbour, coarser = _neighbours(patches)
        split = np.unique(neighbour[coarser > most])
        if not len(split):
            return patches, coarser
        patches = _split(patches, split)


def _neighbours(patches: Patches) -> tuple[Int64[np.ndarray, "n 4"], Int64[np.ndarray, "n 4"]]:
    """Row of the neighbour across each of SIDES, and how many halvings coarser it is, (n, 4)."""
    first = patches.code(patches.x, patches.y)
    beyond = first + (np.int64(1) << (2 * (patches.deepest - patches.depth)))
    rows, coarser = (np.zeros((len(patches), 4), np.int64) for _ in range(2))
    for side, (dx, dy) in enumerate(SIDES):
        x, y = patches.x + dx, patches.y + dy
        inside = (x >= 0) & (y >= 0)
        code = patches.code(np.maximum(x, 0), np.maximum(y, 0))
        row = np.maximum(np.searchsorted(first, code, side="right") - 1, 0)
        inside &= (first[row] <= code) & (code < beyond[row])
        rows[:, side] = row
        coarser[:, side] = np.where(inside, np.maximum(patches.depth - patches.depth[row], 0), 0)
    return rows, coarser


def _split(patches: Patches, rows: Ints) -> Patches:
    kept = np.ones(len(patches), bool)
    kept[rows] = False
    old = patches.depth, patches.x, patches.y, patches.owner
    depth, x, y, owner = (column[rows] for column in old)
    new = *quarters(depth, x, y), np.repeat(owner, 4)
    depth, x, y, owner = (np.concatenate((a[kept], b)) for a, b in zip(old, new, strict=True))
    return Patches(depth, x, y, owner, patches.deepest)


FULL_DETAIL_PX = 0.5
"""Detail of the ground where the metric is ``full`` [px].

That metric displays everything, and all the relief out to the reach is more than memory can hold:
the ground is then cut by ``blake`` at half a pixel, whatever the detail of the view.
"""

SUN_RAD = math.radians(0.533)
"""Angular diameter of the sun [rad].

Ground out of view is seen only by its shadow, which the sun's disc blurs by this angle as seen from
where it falls, so that no finer detail shows.
"""

UNLIT = 4.0
"""How many times coarser ground out of view is whose shadow does not fall into view either.

It is seen by the light that it sends to other ground alone.
"""

_SHADE = (2 / math.pi) ** 2
_ROUNDS = 30


def priorities(relief: Relief, spacings: Reals, tilt: Reals) -> Reals:
    """Priority P of the tiles of each level, from their spacing and the tilt seen, (l,) [m]."""
    width = _wavelengths(relief, spacings) / 2
    rms = np.array([relief.rms_between(w, 2 * w) for w in (2 * width).tolist()])
    return np.asarray(np.sqrt(width * (relief.bump * rms + _SHADE * tilt * width)))


def ranges(relief: Relief, spacings: Reals) -> Reals:
    """Range R of the tiles of each level, from the spacing of their mesh, (l,) [m]."""
    return relief.likely_below(_wavelengths(relief, spacings))


def seen_tilt(relief: Relief, spacings: Reals, elevation: Reals) -> Reals:
    """Mean inclination of ground towards the eye that sees it, by the area seen, (l,), at most 1.

    It is the mean of the area across the line of sight over that on the map, about as many of
    which turn their face away as waves of four spacings and more make (Smith 1967).

    elevation (l,)  tangent of the elevation at which the eye stands over it
    """
    shortest = 2 * _wavelengths(relief, spacings)
    variance = relief.slope_variances.sum() - relief.left_out_slope_variance(shortest)
    variance = np.maximum(variance, 0.0)
    level = np.zeros((len(spacings), 2))
    to_eye = np.column_stack((np.ones(len(spacings)), level[:, 0], elevation))
    slopes, _ = seen_slopes(level, variance, np.ones(len(spacings)), to_eye)
    return np.minimum(elevation - slopes[:, 0], 1.0)


def limits(
    relief: Relief, spacings: Reals, view: View, detail: float = 1.0
) -> tuple[Reals, Reals, Reals, Reals]:
    """Limit distances of the tiles of each level, (l,) each [m].

    They are those in view, hidden in it, out of it, and out of it with their shadows. They do not
    increase with the level, and are infinite for the first one. Air and eye shorten them as they do
    every part's, by the ground's own class of contrast. ``detail`` is τ in view as a share of the
    view's.
    """
    if view.metric.finite:
        limit, m, m_hidden = view.metric.limit, detail * view.m, view.m_offscreen
    else:
        limit, m = blake, FULL_DETAIL_PX * view.camera.pixel_angle
        m_hidden = m / view.offscreen_detail
    m_outside = max(m_hidden, SUN_RAD)
    angles = m, m_hidden, m_outside, UNLIT * m_outside
    R, unseen = ranges(relief, spacings), priorities(relief, spacings, np.zeros(len(spacings)))

    found = np.stack([limit(unseen, R, angle) for angle in angles])
    if relief.amplitude > 0:
        eye = view.camera.eye
        height = max(float(eye[2] - relief.height(view.camera.corner, eye[None, :2])[0]), 0.0)
        # Distances at which ground just as far away has its limit: the tilt falls as they rise.
        for _ in range(_ROUNDS):
            tilt = seen_tilt(relief, spacings, height / np.maximum(found[0], 1e-9))
            found[0] = np.sqrt(found[0] * limit(priorities(relief, spacings, tilt), R, m))
    if view.metric.by_contrast and view.conditions is not None:
        found = seen_by_contrast(found, 1.0, view.conditions.extinction)
    if view.conditions is not None and view.metric.finite:
        contrast = np.full(len(R), GROUND_CONTRAST)
        pairs = zip(found, angles, strict=True)
        found = np.stack(
            [perceptual_limits(view.conditions, D, contrast, angle) for D, angle in pairs]
        )
    found[2:] *= not view.metric.along_axis
    found[:, 0] = np.inf
    inside, hidden, outside, unlit = map(view.for_both_eyes, np.minimum.accumulate(found, axis=1))
    return inside, hidden, outside, unlit


def _wavelengths(relief: Relief, spacings: Reals) -> Reals:
    return np.minimum(2 * spacings, relief.wavelength)


COLUMN_PX = 6.0  # width of a column at the picture's centre [px]
GROWTH = 1.04  # ratio of the distances of a column's samples that follow each other

_NEAREST_M = 4.0
_LEAST_AHEAD = 0.1
"""Least cosine on the map between the middle of the picture and its corners.

Below it the eye looks up or down too steeply for columns.
"""


class Horizon(NamedTuple):
    """Elevation of the ground's horizon by direction and distance on the map, column by column.

    axes (2, 2)  unit vectors on the map, ahead and to the right
    first, step  angle to the right of the first column, and between columns [rad]
    ranges (k,)  distances on the map, ascending [m]
    rise (c, k)  largest tangent of elevation of the ground no farther than each range
    margin       tangent by which a tile must end below it to be hidden
    """

    axes: np.ndarray
    first: float
    step: float
    ranges: np.ndarray
    rise: np.ndarray
    margin: float


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
    return Horizon(axes, first, step, ranges, rise, view.m_offscreen)


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
def below_horizon(low, high, eye, horizon):  # type: ignore[no-untyped-def]
    """Tell whether boxes from ``low`` to ``high`` (n, 3) end below the horizon all along, (n,)."""
    axes, first, step, ranges, rise, margin = horizon
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
