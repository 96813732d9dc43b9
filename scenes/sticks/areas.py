"""Areas of silhouettes along directions [m²]: of a stick, of several together, of flat triangles.

A stick is the convex hull of two spheres, radii r₀ and r₁, a distance L apart. Along a direction
at an angle φ to its axis it looks like the convex hull of two discs whose centres are l = L·sin φ
apart. Where neither disc holds the other, both outer tangents touch, and with sin a = (r₀ − r₁)/l
the outline is two sectors of π ± 2a and, between each tangent and the axis, a trapezoid of height
l·cos a:

    A(l) = r₀²·(π/2 + a) + r₁²·(π/2 − a) + (r₀ + r₁)·l·cos a,         else A = π·max(r₀, r₁)².

It grows with l, so it is largest across the axis, l = L. The stick is convex, so by Cauchy's
theorem (Cauchy 1832; Santaló, "Integral Geometry and Geometric Probability", 1976, ch. 13) its
mean over all directions is a quarter of its surface, two caps and a frustum with sin α = (r₀ −
r₁)/L:

    S = 2π·r₀²·(1 + sin α) + 2π·r₁²·(1 − sin α) + π·(r₀ + r₁)·L·cos²α.

Several sticks hide one another. For the area of the union of their outlines rows are sampled and
lengths are exact: the outlines are cut by evenly spaced parallel rows; in each row the union of the
intervals is measured exactly, and the area is the sum over rows times their spacing (Cavalieri;
midpoint rule). Rows are a fraction of the sticks' own radius apart, less fine where many sticks
average out, which keeps the error of a composite well under 0.5 %.

What of an object depends on the direction of view: shares of area and tones, by tables.

A few smooth shapes that stand for hidden parts cover and shine otherwise than those parts do: the
gaps between a conifer's flat boughs open and close with the elevation of the eye, the parts shade
one another, and an eye between a tree and the sun sees less of that shade than one that looks
toward the sun. Tables that ``scenes.appearance`` fits correct it: which share of their area
(``lod.pruner``) shapes show, and which multiple of their albedo they have. Area is the same from
below as from above; light from below is taken for that from the side.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import product

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals
from lod.errors import InputError
from lod.kernels import njit
from lod.pruner import radius_factor
from lod.shapes import MeshTable, StickTable

FINE, COARSE = 12.0, 5.0
"""Rows per (area-weighted) mean radius of one stick; falls with √count, to a twelfth of it."""

MOST_ROWS = 4096

Directions = Float64[np.ndarray, "d 3"]

DIRECTIONS = 64  # directions over which composites are measured: about 10° apart from any other
SEARCHED = 48  # directions from the best of which the largest area is searched


@lru_cache(maxsize=16)
def directions(count: int = DIRECTIONS) -> Directions:
    """Spread unit vectors evenly over a half sphere: an outline has no front and back.

    A Fibonacci lattice (Swinbank & Purser, "Fibonacci grids", QJRMS 132, 2006), cut to z > 0.
    """
    k = np.arange(count) + 0.5
    z = k / count
    turn = 2 * np.pi * k * (np.sqrt(5) - 1) / 2
    level = np.sqrt(1 - z * z)
    spread = np.stack((level * np.cos(turn), level * np.sin(turn), z), axis=1)
    spread.setflags(write=False)
    return spread


def outline_area(r0: Reals, r1: Reals, apart: Reals) -> Reals:
    """A(l) of the formula above: the convex hull of two discs with centres ``apart`` [m²]."""
    difference = r0 - r1
    slim = np.abs(difference) < apart
    sine = np.where(slim, difference / np.where(slim, apart, 1.0), 0.0)
    a = np.arcsin(sine)
    caps = r0 * r0 * (np.pi / 2 + a) + r1 * r1 * (np.pi / 2 - a)
    hull = caps + (r0 + r1) * apart * np.sqrt(1 - sine * sine)
    return np.where(slim, hull, np.pi * np.maximum(r0, r1) ** 2)


def largest_outline_areas(table: StickTable) -> Reals:
    """Return each stick's largest outline over all directions, (k,) [m²]."""
    return outline_area(table.start_radius, table.end_radius, _lengths(table))


def mean_outline_areas(table: StickTable) -> Reals:
    """Return each stick's mean outline over all directions, S/4, (k,) [m²]."""
    r0, r1, length = table.start_radius, table.end_radius, _lengths(table)
    slim = np.abs(r0 - r1) < length
    sine = np.where(slim, (r0 - r1) / np.where(slim, length, 1.0), 0.0)
    caps = 2 * np.pi * (r0 * r0 * (1 + sine) + r1 * r1 * (1 - sine))
    frustum = np.pi * (r0 + r1) * length * (1 - sine * sine)
    return np.where(slim, caps + frustum, 4 * np.pi * np.maximum(r0, r1) ** 2) / 4


def largest_area(table: StickTable) -> Reals:
    """Measure the largest area that each part's sticks cover together, (n,) [m²].

    It is 0 for a part without sticks, in closed form for a part of one stick, and else searched
    from the best of SEARCHED directions.
    """

    def searched(some: StickTable) -> Reals:
        around = directions(SEARCHED)
        areas = areas_of_parts(some, around)
        columns = (some.start, some.end, some.start_radius, some.end_radius)
        best = np.ascontiguousarray(around[areas.argmax(axis=1)])
        return np.asarray(_climb(some.first, *columns, best, areas.max(axis=1)))

    return _exact_where_single(table, searched, largest_outline_areas)


def mean_area(table: StickTable, spread: Directions | None = None, fineness: float = FINE) -> Reals:
    """Measure the mean over directions of the area that each part's sticks cover, (n,) [m²]."""
    spread = directions() if spread is None else spread
    return _exact_where_single(
        table, lambda some: areas_of_parts(some, spread, fineness).mean(axis=1), mean_outline_areas
    )


def _exact_where_single(
    table: StickTable,
    measured: Callable[[StickTable], Reals],
    closed_form: Callable[[StickTable], Reals],
) -> Reals:
    """Areas of parts, (n,): of one stick in closed form, of several measured, else 0."""
    areas, count = np.zeros(len(table.count)), table.count
    single, several = np.flatnonzero(count == 1), np.flatnonzero(count > 1)
    areas[single] = closed_form(table)[table.first[single]]
    if len(several):
        areas[several] = measured(table.of_parts(count > 1))
    return areas


def _lengths(table: StickTable) -> Reals:
    axis = table.end - table.start
    return np.sqrt((axis * axis).sum(axis=1))


MOST_TRIANGLES = 12  # most triangles of one part; the work doubles with each


def largest_flat_areas(meshes: MeshTable) -> Reals:
    """Measure the largest area over directions that the mesh of each part covers, (n,) [m²].

    None of its triangles hides another. Triangles with normals a [m²], as long as their areas are
    large, then cover Σ |a·d| along the unit vector d, which is the support function of a zonotope.
    It is largest along the farthest corner Σ ±a, and all choices of signs are tried. A part without
    a mesh covers nothing.

    Raises InputError for a part of more than MOST_TRIANGLES.
    """
    corners = meshes.vertices[meshes.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    largest = np.zeros(len(meshes.count))
    for triangles in np.unique(meshes.count[meshes.count > 0]):
        if triangles > MOST_TRIANGLES:
            raise InputError(
                "mesh", f"{triangles} triangles", f"at most {MOST_TRIANGLES} to a part"
            )
        parts = np.flatnonzero(meshes.count == triangles)
        rows = meshes.first_face[parts][:, None] + np.arange(triangles)
        signs = np.array([(1.0, *each) for each in product((1.0, -1.0), repeat=triangles - 1)])
        zonotope = np.einsum("sk,pkx->psx", signs, normals[rows])
        largest[parts] = np.linalg.norm(zonotope, axis=2).max(axis=1)
    return largest


def areas_of_parts(
    table: StickTable, directions: Float64[np.ndarray, "d 3"], fineness: float = FINE
) -> Float64[np.ndarray, "n d"]:
    """Compute the area of the union of each part's sticks along each direction, (n, d) [m²]."""
    columns = (table.start, table.end, table.start_radius, table.end_radius)
    return _areas(table.first, *columns, np.ascontiguousarray(directions), fineness)


@njit(cache=True)
def _areas(first, start, end, r0, r1, directions, fineness):  # type: ignore[no-untyped-def]
    n = len(first) - 1
    areas = np.zeros((n, len(directions)))
    for j in range(len(directions)):
        across, up = frame_across(directions[j])
        x0, y0 = along(start, across), along(start, up)
        x1, y1 = along(end, across), along(end, up)
        for i in range(n):
            a, b = first[i], first[i + 1]
            if b > a:
                disc0, disc1 = (x0[a:b], y0[a:b], r0[a:b]), (x1[a:b], y1[a:b], r1[a:b])
                areas[i, j] = _union_area(*disc0, *disc1, fineness)
    return areas


@njit(cache=True)
def _climb(first, start, end, r0, r1, best, largest):  # type: ignore[no-untyped-def]
    """From the best direction of each part to better ones about it, on rings that shrink."""
    for i in range(len(first) - 1):
        a, b = first[i], first[i + 1]
        if b - a < 2:
            continue
        for tilt in (0.2, 0.12, 0.06, 0.03):
            middle = best[i].copy()
            across, up = frame_across(middle)
            for k in range(6):
                turn = k * math.pi / 3
                aside = math.cos(turn) * across + math.sin(turn) * up
                direction = math.cos(tilt) * middle + math.sin(tilt) * aside
                x, y = frame_across(direction)
                disc0 = along(start[a:b], x), along(start[a:b], y), r0[a:b]
                disc1 = along(end[a:b], x), along(end[a:b], y), r1[a:b]
                area = _union_area(*disc0, *disc1, FINE)
                if area > largest[i]:
                    largest[i] = area
                    best[i, 0], best[i, 1], best[i, 2] = direction
    return largest


@njit(cache=True)
def along(points, axis):  # type: ignore[no-untyped-def]
    """Compute how far points (n, 3) are along a unit vector, (n,) [m]."""
    out = np.empty(len(points))
    for i in range(len(points)):
        out[i] = points[i, 0] * axis[0] + points[i, 1] * axis[1] + points[i, 2] * axis[2]
    return out


@njit(cache=True)
def _union_area(x0, y0, r0, x1, y1, r1, fineness):  # type: ignore[no-untyped-def]
    low, spacing, rows = _rows(x0, y0, r0, x1, y1, r1, fineness)
    begin = np.zeros(rows + 1, np.int64)
    for i in range(len(r0)):  # how many outlines cross each row
        a, b = _row_range(y0[i], r0[i], y1[i], r1[i], low, spacing, rows)
        for row in range(a, b):
            begin[row + 1] += 1
    for row in range(rows):
        begin[row + 1] += begin[row]
    left, right = np.empty(begin[-1]), np.empty(begin[-1])
    slot = begin[:-1].copy()
    sides = np.empty((2, 4))
    for i in range(len(r0)):
        slim = _tangents(x0[i], y0[i], r0[i], x1[i], y1[i], r1[i], sides)
        a, b = _row_range(y0[i], r0[i], y1[i], r1[i], low, spacing, rows)
        for row in range(a, b):
            y, k = low + (row + 0.5) * spacing, slot[row]
            lo, hi = _disc_span(y, x0[i], y0[i], r0[i], x1[i], y1[i], r1[i])
            lo, hi = _widened(y, lo, hi, sides) if slim else (lo, hi)
            # A row that only just meets an outline may miss it by rounding.
            left[k], right[k] = (lo, hi) if lo <= hi else (x0[i], x0[i])
            slot[row] = k + 1
    covered = 0.0
    for row in range(rows):
        covered += _union_length(left, right, begin[row], begin[row + 1])
    return covered * spacing


@njit(cache=True)
def frame_across(direction):  # type: ignore[no-untyped-def]
    """Compute two unit vectors across a unit direction (Duff et al., JCGT 6(1), 2017)."""
    x, y, z = direction
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    across = np.array((1.0 + sign * x * x * a, sign * b, -sign * x))
    up = np.array((b, sign + y * y * a, -y))
    return across, up


@njit(cache=True)
def _rows(x0, y0, r0, x1, y1, r1, fineness):  # type: ignore[no-untyped-def]
    low, high, weight, radius = np.inf, -np.inf, 0.0, 0.0
    for i in range(len(r0)):
        low = min(low, y0[i] - r0[i], y1[i] - r1[i])
        high = max(high, y0[i] + r0[i], y1[i] + r1[i])
        r = 0.5 * (r0[i] + r1[i])
        area = r * (math.hypot(x1[i] - x0[i], y1[i] - y0[i]) + r)
        weight += area
        radius += area * r
    per_radius = fineness * max(1.0 / 12.0, 1.0 / math.sqrt(len(r0)))
    rows = math.ceil((high - low) / (radius / weight) * per_radius)
    rows = min(max(rows, 1), MOST_ROWS)
    return low, (high - low) / rows, rows


@njit(cache=True, inline="always")
def _row_range(y0, r0, y1, r1, low, spacing, rows):  # type: ignore[no-untyped-def]
    """First row whose middle lies inside the outline, and the one after the last."""
    bottom, top = min(y0 - r0, y1 - r1), max(y0 + r0, y1 + r1)
    first = max(0, math.ceil((bottom - low) / spacing - 0.5))
    last = min(rows, math.ceil((top - low) / spacing - 0.5))
    return first, max(first, last)


@njit(cache=True, inline="always")
def _tangents(x0, y0, r0, x1, y1, r1, sides):  # type: ignore[no-untyped-def]
    """Whether the discs have outer tangents; each as lowest y, highest y, x at y = 0, dx/dy."""
    ex, ey = x1 - x0, y1 - y0
    apart2, difference = ex * ex + ey * ey, r0 - r1
    if apart2 <= difference * difference:
        return False
    cosine = math.sqrt(apart2 - difference * difference) / apart2
    sine = difference / apart2
    for k in range(2):
        side = cosine if k else -cosine
        nx, ny = sine * ex - side * ey, sine * ey + side * ex
        xa, ya = x0 + r0 * nx, y0 + r0 * ny
        xb, yb = x1 + r1 * nx, y1 + r1 * ny
        slope = (xb - xa) / (yb - ya) if yb != ya else 0.0
        sides[k, 0], sides[k, 1] = min(ya, yb), max(ya, yb)
        sides[k, 2], sides[k, 3] = xa - slope * ya, slope
    return True


@njit(cache=True, inline="always")
def _disc_span(y, x0, y0, r0, x1, y1, r1):  # type: ignore[no-untyped-def]
    """Span of the row at height y across two discs; empty (∞, −∞) where it meets neither."""
    left, right = np.inf, -np.inf
    square = r0 * r0 - (y - y0) * (y - y0)
    if square >= 0.0:
        half = math.sqrt(square)
        left, right = x0 - half, x0 + half
    square = r1 * r1 - (y - y1) * (y - y1)
    if square >= 0.0:
        half = math.sqrt(square)
        left, right = min(left, x1 - half), max(right, x1 + half)
    return left, right


@njit(cache=True, inline="always")
def _widened(y, left, right, sides):  # type: ignore[no-untyped-def]
    """The span with the points where the row crosses the two tangents."""
    for k in range(2):
        if sides[k, 0] < y < sides[k, 1]:
            x = sides[k, 2] + y * sides[k, 3]
            left, right = min(left, x), max(right, x)
    return left, right


@njit(cache=True)
def _union_length(left, right, a, b):  # type: ignore[no-untyped-def]
    """Length of the union of the intervals a to b; sorts both kinds of end in place."""
    if b - a < 2:
        return right[a] - left[a] if b > a else 0.0
    left[a:b].sort()
    right[a:b].sort()
    # Sweep: the k-th end closes a piece of the union when only k intervals begin before it.
    length, begun = 0.0, left[a]
    for k in range(a, b - 1):
        if right[k] < left[k + 1]:
            length += right[k] - begun
            begun = left[k + 1]
    return length + right[b - 1] - begun


ELEVATIONS_DEG = tuple(range(0, 91, 15))
"""Elevations of the eye at which a table by elevation has its entries."""

AZIMUTHS_DEG = tuple(range(0, 181, 30))
"""Azimuths between eye and sun at which a table by azimuth has its entries."""


@njit(cache=True)
def elevation_index(sin_elevation):  # type: ignore[no-untyped-def]
    """Compute the fractional index of an elevation among ELEVATIONS_DEG, from its sine, 0 to 1."""
    return math.asin(min(sin_elevation, 1.0)) / math.radians(ELEVATIONS_DEG[1])


@njit(cache=True)
def azimuth_index(cos_azimuth):  # type: ignore[no-untyped-def]
    """Compute the fractional index of an azimuth among AZIMUTHS_DEG, from its cosine.

    It is −1 for NaN, which asks for the mean over all azimuths.
    """
    if math.isnan(cos_azimuth):
        return -1.0
    return math.acos(min(max(cos_azimuth, -1.0), 1.0)) / math.radians(AZIMUTHS_DEG[1])


@njit(cache=True)
def tone_steps_at(table, high, around):  # type: ignore[no-untyped-def]
    """Compute the entry of a table of ``ViewDependence.tone_steps``, (h, t + 1).

    ``high`` and ``around`` are what ``elevation_index`` and ``azimuth_index`` compute.
    """
    low = min(int(high), len(table) - 2)
    below, above = _around(table[low], around), _around(table[low + 1], around)
    return below + (high - low) * (above - below)


@njit(cache=True)
def _around(row, index):  # type: ignore[no-untyped-def]
    """Entry of a row of such a table: its last column holds the mean over all azimuths."""
    azimuths = len(row) - 1
    return interpolate(row[:azimuths], index) if index >= 0.0 else row[azimuths]


@njit(cache=True)
def interpolate(row, index):  # type: ignore[no-untyped-def]
    """Compute the entry of a row of a table at a fractional index: linear in the angle."""
    low = min(int(index), len(row) - 2)
    return row[low] + (index - low) * (row[low + 1] - row[low])


TONE_STEP = 0.95  # ratio of the albedo of each tone of a colour to that of the next lighter one

_SHAPE = len(ELEVATIONS_DEG), len(AZIMUTHS_DEG) + 1


@dataclass(frozen=True, eq=False)
class ViewDependence(ArrayData):
    """The tables of an object's leaf appearances, and which stick uses which; by default none does.

    table_row (k,)     row of the tables below for each stick of a leaf appearance, −1 for none
    area_share (c, h)  share of their area that sticks show at ELEVATIONS_DEG, 0 to 1
    tone (c, h, t + 1) multiple of their albedo at ELEVATIONS_DEG and AZIMUTHS_DEG; the last column
                       holds the mean over all azimuths
    """

    table_row: IntArray = field(default_factory=lambda: np.zeros(0))
    area_share: FloatArray = field(default_factory=lambda: np.zeros((0, _SHAPE[0])))
    tone: FloatArray = field(default_factory=lambda: np.zeros((0, *_SHAPE)))

    @staticmethod
    def of_area(table_row: Ints, area_share: np.ndarray) -> "ViewDependence":
        """Make the view dependence of shapes whose albedo is the same from everywhere."""
        return ViewDependence(table_row, area_share, np.ones((len(area_share), *_SHAPE)))

    @staticmethod
    def concatenate(parts: Sequence["ViewDependence"], sticks: Sequence[int]) -> "ViewDependence":
        """Lay the tables of several stick tables, of so many ``sticks`` each, end to end."""
        first = np.cumsum([0] + [len(each.area_share) for each in parts])[:-1]
        rows = [each.rows(count) for each, count in zip(parts, sticks, strict=True)]
        moved = [np.where(row >= 0, row + f, -1) for row, f in zip(rows, first, strict=True)]
        tables = (np.concatenate([getattr(p, n) for p in parts]) for n in ("area_share", "tone"))
        return ViewDependence(np.concatenate(moved), *tables)

    def rows(self, sticks: int) -> Ints:
        """``table_row`` of a table of so many sticks, (sticks,), also where no stick uses one."""
        return self.table_row if len(self.table_row) else np.full(sticks, -1)

    @cached_property
    def brightest(self) -> Reals:
        """Return the greatest multiple of their albedo that sticks of each table have, (c,)."""
        return self.tone.max(axis=(1, 2), initial=0.0)

    @cached_property
    def tone_steps(self) -> Float64[np.ndarray, "c h t"]:
        """Return how many steps of TONE_STEP sticks darken by from their brightest tone."""
        return np.log(self.tone / self.brightest[:, None, None]) / math.log(TONE_STEP)


def with_area_share(table: StickTable, share: Reals | float) -> StickTable:
    """Thin sticks to a share of their area, one for each (k,) or one for all."""
    share = np.broadcast_to(share, len(table)).astype(np.float64)
    length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
    return table.thickened(_radius_factors(table.start_radius, table.end_radius, length, share))


def area_shares_at(views: ViewDependence, rows: Ints, sin_elevation: float) -> Reals:
    """Compute which share of their area sticks show at an elevation of the eye, (k,).

    ``rows`` (k,) are as in ``ViewDependence.table_row``.
    """
    index = elevation_index(sin_elevation)
    shares: Reals = np.append([interpolate(row, index) for row in views.area_share], 1.0)[rows]
    return shares


def largest_area_in_view(table: StickTable, views: ViewDependence) -> Reals:
    """Measure the largest area that the sticks of each part cover over all directions, (n,) [m²].

    Each stick has the share of its area that it shows from there.
    """
    dependent, changing = np.zeros(len(table.count), np.bool_), (views.area_share != 1).any(axis=1)
    dependent[table.owner[np.append(changing, False)[views.rows(len(table))]]] = True
    if not dependent.any():
        return largest_area(table)
    largest = np.empty(len(dependent))
    largest[~dependent] = largest_area(table.of_parts(~dependent))
    some, rows = table.of_parts(dependent), views.rows(len(table))[dependent[table.owner]]
    areas = []
    for view in directions():
        shown = with_area_share(some, area_shares_at(views, rows, view[2]))
        areas.append(areas_of_parts(shown, view[None])[:, 0])
    largest[dependent] = np.max(areas, axis=0)
    return largest


@njit(cache=True)
def _radius_factors(r0, r1, length, share):  # type: ignore[no-untyped-def]
    factors = np.empty(len(r0))
    for k in range(len(r0)):
        factors[k] = radius_factor(r0[k], r1[k], length[k], share[k])
    return factors


def with_tone_steps(
    tint: Ints, tints: np.ndarray, views: ViewDependence
) -> tuple[Ints, Float64[np.ndarray, "t 3"]]:
    """Give sticks whose brightness depends on the view tints in a longer palette.

    Sticks have a row of a palette for a colour, and no brightness of their own. So each colour of a
    stick whose brightness depends on the view is followed by as many darker tones as it can need.
    Returns their tints (k,) and that palette: all tones of a stick, from the lightest to the
    darkest, follow the tint that it is given.
    """
    steps = np.ceil(views.tone_steps.max(axis=(1, 2), initial=0.0)).astype(np.int64)
    dependent = views.table_row >= 0
    pairs, pair = np.unique(
        np.stack((views.table_row[dependent], tint[dependent])), axis=1, return_inverse=True
    )
    blocks = [
        np.minimum(
            views.brightest[row] * tints[colour] * TONE_STEP ** np.arange(steps[row] + 1)[:, None],
            1.0,
        )
        for row, colour in pairs.T
    ]
    first = len(tints) + np.cumsum([0] + [len(block) for block in blocks])[:-1]
    toned = tint.copy()
    toned[dependent] = first[pair.reshape(-1)]
    return toned, np.concatenate((tints, *blocks))
