"""Visible area of each shape of an object from far off, with shapes hidden behind others.

Rays in a square grid, all in one direction, each see the stick or triangle that they meet first. A
stick looks like the convex hull of two discs (``scenes.sticks.areas``), which is the union of all
discs between them: a point p at x along the axis from the first, in units of the disc's distance l,
and h aside, is inside if it is inside the disc at t = clamp(x − h·tan a), sin a = (r₁ − r₀)/l,
where the outline is tangent. Samples fall evenly, so that areas are unbiased, and their error is
that of as many points as the shape covers.

Leaf appearances are held against views of the whole object in full detail, which are spread over
elevations and azimuths. An outline is the same from the other side, so that views from above stand
for those from below.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from lod.arrays import Reals
from lod.kernels import map_chunks, njit
from lod.shapes import StickTable
from scenes.sticks.areas import ELEVATIONS_DEG, along, frame_across
from scenes.sticks.prototype import Shapes


def visible_areas(
    shown: StickTable | Shapes, directions: Float64[np.ndarray, "d 3"], spacing: float
) -> Float64[np.ndarray, "d k"]:
    """Compute the area of each shape that an eye far off in each direction sees, (d, k) [m²].

    ``spacing`` of the rays [m].
    """
    areas = np.empty((len(directions), len(shown)))
    for row, direction in enumerate(directions):
        seen = _first_met(*_columns(shown), np.ascontiguousarray(direction), spacing, -1)
        areas[row] = np.bincount(seen[seen >= 0], minlength=len(shown)) * spacing**2
    return areas


def first_met(
    shown: StickTable | Shapes, direction: Float64[np.ndarray, "3"], spacing: float, reach: int
) -> Int64[np.ndarray, "rows columns"]:
    """Find the row of the shape that each ray of a grid meets first, −1 where it meets none.

    The grid reaches ``reach`` rays to each side of the origin of the object's frame; ``spacing`` of
    the rays [m].
    """
    return _first_met(*_columns(shown), np.ascontiguousarray(direction), spacing, reach)


def _columns(shown: StickTable | Shapes) -> tuple[np.ndarray, ...]:
    if isinstance(shown, StickTable):
        shown = Shapes.of(shown)
    table = shown.sticks
    return table.start, table.end, table.start_radius, table.end_radius, shown.corners


@njit(cache=True, nogil=True)
def _first_met(start, end, r0, r1, corners, direction, spacing, reach):  # type: ignore[no-untyped-def]
    across, up = frame_across(direction)
    x0, y0, z0 = along(start, across), along(start, up), along(start, direction)
    x1, y1, z1 = along(end, across), along(end, up), along(end, direction)
    flat = np.empty((len(corners), 3, 3))
    for c in range(3):
        points = np.ascontiguousarray(corners[:, c])
        flat[:, c, 0], flat[:, c, 1] = along(points, across), along(points, up)
        flat[:, c, 2] = along(points, direction)
    low_x, low_y, wide, high = -reach, -reach, 2 * reach, 2 * reach
    if reach < 0:  # as far as the sticks reach
        low_x, wide = _columns_across(x0, x1, r0, r1, flat[:, :, 0], spacing)
        low_y, high = _columns_across(y0, y1, r0, r1, flat[:, :, 1], spacing)
    nearest, seen = np.full((high, wide), -np.inf), np.full((high, wide), -1)
    for k in range(len(r0)):
        disc0 = x0[k] / spacing - low_x, y0[k] / spacing - low_y, z0[k], r0[k] / spacing
        disc1 = x1[k] / spacing - low_x, y1[k] / spacing - low_y, z1[k], r1[k] / spacing
        _draw(k, disc0, disc1, spacing, nearest, seen)
    shift = np.array((low_x, low_y, 0.0))
    for f in range(len(flat)):
        scaled = flat[f] * np.array((1 / spacing, 1 / spacing, 1.0)) - shift
        _draw_triangle(len(r0) + f, scaled, nearest, seen)
    return seen


@njit(cache=True)
def _columns_across(a, b, r0, r1, flat, spacing):  # type: ignore[no-untyped-def]
    """First of the columns of rays that meet anything, along one axis, and their number."""
    low, high = math.inf, -math.inf
    for k in range(len(a)):
        low, high = min(low, a[k] - r0[k], b[k] - r1[k]), max(high, a[k] + r0[k], b[k] + r1[k])
    for f in range(len(flat)):
        low, high = min(low, flat[f].min()), max(high, flat[f].max())
    first = math.floor(low / spacing)
    return first, math.ceil(high / spacing) - first


@njit(cache=True)
def _draw_triangle(k, corners, nearest, seen):  # type: ignore[no-untyped-def]
    """Draw one triangle, (3, 3) in squares across and up and in metres toward the eye."""
    a, b, c = corners
    area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    if area == 0.0:
        return
    rows, columns = seen.shape
    bottom, top = min(a[1], b[1], c[1]), max(a[1], b[1], c[1])
    left, right = min(a[0], b[0], c[0]), max(a[0], b[0], c[0])
    for row in range(max(math.ceil(bottom - 0.5), 0), min(math.floor(top + 0.5), rows)):
        for column in range(max(math.ceil(left - 0.5), 0), min(math.floor(right + 0.5), columns)):
            px, py = column + 0.5 - a[0], row + 0.5 - a[1]
            u = (px * (c[1] - a[1]) - py * (c[0] - a[0])) / area
            v = (py * (b[0] - a[0]) - px * (b[1] - a[1])) / area
            if u >= 0.0 and v >= 0.0 and u + v <= 1.0:
                z = a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2])
                if z > nearest[row, column]:
                    nearest[row, column], seen[row, column] = z, k


@njit(cache=True)
def _draw(k, disc0, disc1, spacing, nearest, seen):  # type: ignore[no-untyped-def]
    """Draw one stick over those drawn before; rays go through the middles of the squares."""
    ax, ay, az, ra = disc0
    bx, by, bz, rb = disc1
    ux, uy = bx - ax, by - ay
    apart = math.hypot(ux, uy)
    slim = apart > abs(rb - ra)
    tangent = 0.0
    if slim:
        ux, uy = ux / apart, uy / apart
        tangent = (rb - ra) / math.sqrt(apart * apart - (rb - ra) ** 2)
    low_x, high_x = min(ax - ra, bx - rb), max(ax + ra, bx + rb)
    low_y, high_y = min(ay - ra, by - rb), max(ay + ra, by + rb)
    rows, columns = seen.shape
    for row in range(max(math.ceil(low_y - 0.5), 0), min(math.floor(high_y + 0.5), rows)):
        for column in range(max(math.ceil(low_x - 0.5), 0), min(math.floor(high_x + 0.5), columns)):
            px, py = column + 0.5 - ax, row + 0.5 - ay
            if slim:
                x, h = px * ux + py * uy, abs(py * ux - px * uy)
                t = min(max((x + h * tangent) / apart, 0.0), 1.0)
                aside = (x - t * apart) ** 2 + h * h
            else:
                t = 0.0 if ra >= rb else 1.0
                aside = (px - t * (bx - ax)) ** 2 + (py - t * (by - ay)) ** 2
            radius = ra + t * (rb - ra)
            if aside <= radius * radius:
                z = az + t * (bz - az) + math.sqrt(radius * radius - aside) * spacing
                if z > nearest[row, column]:
                    nearest[row, column], seen[row, column] = z, k


AZIMUTHS = 8  # views from each of ELEVATIONS_DEG, turned from one elevation to the next
RAYS = 200  # rays across the object's largest extent

_TURN_DEG = 38.2


@dataclass(frozen=True, eq=False)
class CrownViews:
    """An object in full detail, seen from all sides.

    toward (e, a, 3)  unit vectors to the eye, for each elevation
    weight (e,)       share of all directions that each elevation stands for
    spacing           of the rays [m]
    covers (e,)       area that the object covers from each elevation, over azimuths [m²]
    seen (k,)         area that is seen of each of its shapes, over all directions [m²]
    """

    toward: Float64[np.ndarray, "e a 3"]
    weight: Float64[np.ndarray, " e"]
    spacing: float
    covers: Float64[np.ndarray, " e"]
    seen: Float64[np.ndarray, " k"]

    def covered(self, shown: Shapes, elevation: int) -> float:
        """Measure the area that shapes cover from one elevation, over azimuths [m²]."""
        areas = visible_areas(shown, self.toward[elevation], self.spacing)
        return float(areas.sum()) / AZIMUTHS


def look_at(whole: Shapes) -> CrownViews:
    """Look at an object in full detail."""
    points, radii = whole.spheres
    extent = float((points.max(axis=0) - points.min(axis=0)).max())
    spacing = max(extent, 2 * float(radii.max())) / RAYS
    views = []
    for k, elevation_deg in enumerate(ELEVATIONS_DEG):
        turn = np.radians(_TURN_DEG * k + 360.0 / AZIMUTHS * np.arange(AZIMUTHS))
        e = np.radians(elevation_deg)
        up = np.full(AZIMUTHS, np.sin(e))
        views.append(np.stack((np.cos(e) * np.cos(turn), np.cos(e) * np.sin(turn), up), axis=1))
    toward = np.array(views)
    # Shares of a half sphere that are nearest to each elevation.
    edges = np.radians(np.array(ELEVATIONS_DEG))
    middles = np.concatenate(([0.0], (edges[1:] + edges[:-1]) / 2, [np.pi / 2]))
    areas, weight = seen_areas(whole, toward, spacing), np.diff(np.sin(middles))
    return CrownViews(toward, weight, spacing, areas.sum(axis=1), weight @ areas)


def seen_areas(
    shown: Shapes, toward: Float64[np.ndarray, "e a 3"], spacing: float
) -> Float64[np.ndarray, "e k"]:
    """Measure the area that is seen of each shape from each elevation, (e, k)."""

    def run(first: int, last: int) -> list[Reals]:
        return [visible_areas(shown, views, spacing).mean(axis=0) for views in toward[first:last]]

    return np.array([each for some in map_chunks(run, len(toward), 1) for each in some])
