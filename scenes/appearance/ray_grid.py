"""Intersection of rays with the sticks and triangles of objects, by a grid of boxes about each.

Every box of a grid lists the shapes that reach into it. A ray goes from box to box (Amanatides &
Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987) until the nearest shape
that it has met is nearer than the next box. Triangles are met as by T. Möller & B. Trumbore,
"Fast, minimum storage ray/triangle intersection" (Journal of Graphics Tools 2(1), 1997).
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lod.kernels import njit
from lod.shapes import StickTable
from scenes.sticks.prototype import Shapes

BOX_M = 0.25  # side of a box [m]
NOTHING = np.inf  # distance of the first shape along a ray that meets none


class Grids(NamedTuple):
    """Grids of objects, laid end to end, each with the shapes that reach into its boxes.

    shapes  (k, 10) of a stick start (3), end (3) and two radii [m], the squared radius [m²] of the
            ball about all of it, and 0; of a triangle three corners (9) [m], and 1
    low     (o, 3) lowest corner of each object's grid [m]
    boxes   (o, 3) number of its boxes along x, y and z
    number  (o,) number of its first box
    first   (b + 1,) the shapes of box b are those at rows[first[b] : first[b + 1]]
    rows    rows of ``shapes``
    """

    shapes: np.ndarray
    low: np.ndarray
    boxes: np.ndarray
    number: np.ndarray
    first: np.ndarray
    rows: np.ndarray


def make_grids(objects: Sequence[StickTable | Shapes]) -> Grids:
    """Make the grids of objects, each with sticks, and triangles after them, of its own."""
    shapes, lows, boxes, firsts, rows = [], [], [], [np.zeros(1, np.int64)], []
    before, listed = 0, 0
    for each in objects:
        own = _rows(each)
        low, count, first, within = _make_grid(own)
        shapes.append(own)
        lows.append(low)
        boxes.append(count)
        firsts.append(first[1:] + listed)
        rows.append(within + before)
        before, listed = before + len(own), listed + len(within)
    counts = np.array([len(each) for each in firsts[1:]])
    return Grids(
        np.concatenate(shapes),
        np.array(lows),
        np.array(boxes),
        np.cumsum(counts) - counts,
        np.concatenate(firsts),
        np.concatenate(rows),
    )


def _rows(one: StickTable | Shapes) -> np.ndarray:
    table = one if isinstance(one, StickTable) else one.sticks
    radii = table.start_radius, table.end_radius
    length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
    ball = (length / 2 + np.maximum(*radii)) ** 2
    sticks = np.column_stack((table.start, table.end, *radii, ball, np.zeros(len(table))))
    if isinstance(one, StickTable):
        return sticks
    flat = np.column_stack((one.corners.reshape(-1, 9), np.ones(len(one.corners))))
    return np.concatenate((sticks, flat))


@njit(cache=True)
def _make_grid(shapes):  # type: ignore[no-untyped-def]
    """Make a grid of shapes: lowest corner (3,), boxes (3,), first row of each box, rows."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    bounds = np.empty((len(shapes), 2, 3))
    for i in range(len(shapes)):
        s = shapes[i]
        r = 0.0 if s[9] else max(s[6], s[7])
        for c in range(3):
            third = s[6 + c] if s[9] else s[c]
            bounds[i, 0, c] = min(s[c], s[3 + c], third) - r
            bounds[i, 1, c] = max(s[c], s[3 + c], third) + r
            low[c], high[c] = min(low[c], bounds[i, 0, c]), max(high[c], bounds[i, 1, c])
    boxes = np.empty(3, np.int64)
    for c in range(3):
        boxes[c] = max(1, math.ceil((high[c] - low[c]) / BOX_M))
    nx, ny, nz = boxes
    first, rows = np.zeros(nx * ny * nz + 1, np.int64), np.empty(0, np.int64)
    at = first
    for turn in range(2):
        for i in range(len(shapes)):
            begin = np.minimum(((bounds[i, 0] - low) / BOX_M).astype(np.int64), boxes - 1)
            end = np.minimum(((bounds[i, 1] - low) / BOX_M).astype(np.int64), boxes - 1)
            for x in range(begin[0], end[0] + 1):
                for y in range(begin[1], end[1] + 1):
                    for z in range(begin[2], end[2] + 1):
                        px = low[0] + (x + 0.5) * BOX_M
                        py = low[1] + (y + 0.5) * BOX_M
                        pz = low[2] + (z + 0.5) * BOX_M
                        if not _may_reach(shapes[i], px, py, pz):
                            continue
                        place = (x * ny + y) * nz + z
                        if turn == 0:
                            first[place + 1] += 1
                        else:
                            rows[at[place]] = i
                            at[place] += 1
        if turn == 0:
            first = np.cumsum(first)
            at, rows = first[:-1].copy(), np.empty(first[-1], np.int64)
    return low, boxes, first, rows


@njit(cache=True)
def _may_reach(s, x, y, z):  # type: ignore[no-untyped-def]
    """Whether a shape may reach into the box about a point, which the box about it touches."""
    half = 0.5 * BOX_M * math.sqrt(3.0)
    px, py, pz = x - s[0], y - s[1], z - s[2]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    if s[9]:
        nx, ny, nz = _across(s)
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        return abs(px * nx + py * ny + pz * nz) <= half * size
    square = max(ax * ax + ay * ay + az * az, 1e-12)
    t = min(max((px * ax + py * ay + pz * az) / square, 0.0), 1.0)
    dx, dy, dz = px - t * ax, py - t * ay, pz - t * az
    return dx * dx + dy * dy + dz * dz <= (max(s[6], s[7]) + half) ** 2


@njit(cache=True)
def intersect_ray(grids, which, origin, v, before):  # type: ignore[no-untyped-def]
    """Compute the distance to the first shape of an object along one ray, and its row.

    They are NOTHING and −1 if the ray meets none within the distance ``before``.
    """
    ox, oy, oz = origin
    vx, vy, vz = v
    lx, ly, lz = grids.low[which, 0], grids.low[which, 1], grids.low[which, 2]
    nx, ny, nz = grids.boxes[which, 0], grids.boxes[which, 1], grids.boxes[which, 2]
    begin, end = _clip(ox, vx, lx, lx + nx * BOX_M, 0.0, before)
    begin, end = _clip(oy, vy, ly, ly + ny * BOX_M, begin, end)
    begin, end = _clip(oz, vz, lz, lz + nz * BOX_M, begin, end)
    nearest, row = before, -1
    x, next_x, step_x = _first_box(ox + begin * vx - lx, vx, nx, begin)
    y, next_y, step_y = _first_box(oy + begin * vy - ly, vy, ny, begin)
    z, next_z, step_z = _first_box(oz + begin * vz - lz, vz, nz, begin)
    while begin < end:
        begin = min(next_x, next_y, next_z)
        place = grids.number[which] + (x * ny + y) * nz + z
        for k in range(grids.first[place], grids.first[place + 1]):
            t = _entry(grids.shapes[grids.rows[k]], ox, oy, oz, v)
            if 0.0 < t < nearest:
                nearest, row = t, grids.rows[k]
        if nearest <= begin:
            break
        if begin == next_x:
            x += 1 if vx > 0 else -1
            next_x += step_x
        elif begin == next_y:
            y += 1 if vy > 0 else -1
            next_y += step_y
        else:
            z += 1 if vz > 0 else -1
            next_z += step_z
        if not (0 <= x < nx and 0 <= y < ny and 0 <= z < nz):
            break
    return (nearest, row) if row >= 0 else (NOTHING, -1)


@njit(cache=True, inline="always")
def _clip(o, v, low, high, begin, end):  # type: ignore[no-untyped-def]
    """Clip the interval from begin to end of a ray to where one coordinate is from low to high."""
    if v != 0.0:
        one, two = (low - o) / v, (high - o) / v
        return max(begin, min(one, two)), min(end, max(one, two))
    return begin, end if low <= o <= high else -1.0


@njit(cache=True, inline="always")
def _first_box(at, v, count, begin):  # type: ignore[no-untyped-def]
    """Start the traversal along one axis, for a ray that is at a point at distance ``begin``.

    Returns the box of the point, the distance at which the next box begins, and the length of the
    ray within each box.
    """
    box = min(max(math.floor(at / BOX_M), 0), count - 1)
    if v == 0.0:
        return box, math.inf, math.inf
    return box, begin + ((box + (1 if v > 0 else 0)) * BOX_M - at) / v, BOX_M / abs(v)


@njit(cache=True, inline="always")
def _entry(s, x, y, z, v):  # type: ignore[no-untyped-def]
    """Distance along a ray from (x, y, z) at which it meets a shape; infinite if it never does."""
    return _triangle_entry(s, x, y, z, v) if s[9] else _stick_entry(s, x, y, z, v)


@njit(cache=True, inline="always")
def _across(s):  # type: ignore[no-untyped-def]
    """Normal of a triangle, as long as twice its area."""
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    bx, by, bz = s[6] - s[0], s[7] - s[1], s[8] - s[2]
    return ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx


@njit(cache=True)
def _triangle_entry(s, x, y, z, v):  # type: ignore[no-untyped-def]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    bx, by, bz = s[6] - s[0], s[7] - s[1], s[8] - s[2]
    nx, ny, nz = _across(s)
    facing = -(nx * v[0] + ny * v[1] + nz * v[2])
    if facing == 0.0:
        return math.inf
    px, py, pz = x - s[0], y - s[1], z - s[2]
    cx, cy, cz = py * v[2] - pz * v[1], pz * v[0] - px * v[2], px * v[1] - py * v[0]
    one = (bx * cx + by * cy + bz * cz) / facing
    two = -(ax * cx + ay * cy + az * cz) / facing
    if one < 0.0 or two < 0.0 or one + two > 1.0:
        return math.inf
    t = (nx * px + ny * py + nz * pz) / facing
    return t if t > 0.0 else math.inf


@njit(cache=True)
def _stick_entry(s, x, y, z, v):  # type: ignore[no-untyped-def]
    """Distance along a ray from (x, y, z) at which it enters a stick; infinite if it never does.

    It is the least of the distances at which the ray enters either sphere and the frustum between
    them: ρ²·(1 − s²) = (r₀ − s·h)², s = (r₀ − r₁)/L, with ρ from the axis and h along it.
    """
    ox, oy, oz = x - s[0], y - s[1], z - s[2]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    # Most rays miss the ball about the whole stick.
    mx, my, mz = ox - 0.5 * ax, oy - 0.5 * ay, oz - 0.5 * az
    mv = mx * v[0] + my * v[1] + mz * v[2]
    if mx * mx + my * my + mz * mz - mv * mv > s[8]:
        return math.inf
    r0, r1 = s[6], s[7]
    length2 = ax * ax + ay * ay + az * az
    ov = ox * v[0] + oy * v[1] + oz * v[2]
    oo = ox * ox + oy * oy + oz * oz
    av, ao = ax * v[0] + ay * v[1] + az * v[2], ax * ox + ay * oy + az * oz
    best = _sphere_entry(ov, oo, r0)
    best = min(best, _sphere_entry(ov - av, oo - 2 * ao + length2, r1))
    k = r0 - r1
    if length2 <= k * k:
        return best
    length = math.sqrt(length2)
    sine = k / length
    h, hd = ao / length, av / length
    a = (1 - sine * sine) - hd * hd
    b = (1 - sine * sine) * ov - h * hd + sine * hd * r0
    c = (1 - sine * sine) * oo - h * h - r0 * r0 + 2 * r0 * sine * h
    if abs(a) < 1e-12:
        return best
    disc = b * b - a * c
    if disc <= 0:
        return best
    root = math.sqrt(disc)
    for t in ((-b - root) / a, (-b + root) / a):
        at = h + t * hd
        if r0 * sine <= at <= length + r1 * sine and t < best and t > 0:
            best = t
    return best


@njit(cache=True)
def _sphere_entry(ov, oo, r):  # type: ignore[no-untyped-def]
    """Distance at which a ray enters a sphere; ov, oo: o·v and o·o, with o from its centre."""
    disc = ov * ov - oo + r * r
    if disc <= 0:
        return math.inf
    t = -ov - math.sqrt(disc)
    return t if t > 0 else math.inf


@njit(cache=True)
def normal_at(s, point, v):  # type: ignore[no-untyped-def]
    """Compute the unit normal (3,) of a shape at a point (3,) that a ray along v (3) meets.

    That of a stick is outward, and that of a triangle on the side from which the ray comes.
    """
    if s[9]:
        nx, ny, nz = _across(s)
        size = math.sqrt(nx * nx + ny * ny + nz * nz)
        size = math.copysign(size, -(nx * v[0] + ny * v[1] + nz * v[2]))
        return np.array((nx / size, ny / size, nz / size))
    px, py, pz = point[0] - s[0], point[1] - s[1], point[2] - s[2]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    length = math.sqrt(ax * ax + ay * ay + az * az)
    t = 0.0
    sine = (s[6] - s[7]) / length if length > 0 else 2.0
    if abs(sine) < 1:
        h = (px * ax + py * ay + pz * az) / length
        across = math.sqrt(max(px * px + py * py + pz * pz - h * h, 0.0))
        t = min(max((h - across * sine / math.sqrt(1 - sine * sine)) / length, 0.0), 1.0)
    elif s[7] > s[6]:
        t = 1.0
    nx, ny, nz = px - t * ax, py - t * ay, pz - t * az
    size = math.sqrt(nx * nx + ny * ny + nz * nz)
    return np.array((nx / size, ny / size, nz / size))
