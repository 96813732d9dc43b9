"""Intersection of rays with the sticks of objects, by a grid of boxes about each object.

Every box of a grid lists the sticks that reach into it. A ray goes from box to box (Amanatides &
Woo, "A fast voxel traversal algorithm for ray tracing", Eurographics 1987) until the nearest stick
that it has met is nearer than the next box.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.stick_table import StickTable

BOX_M = 0.25
"""Side of a box [m]."""

NOTHING = np.inf
"""Distance of the first stick along a ray that meets none."""


class Grids(NamedTuple):
    """Grids of objects, laid end to end, each with the sticks that reach into its boxes.

    sticks  (k, 9) start (3), end (3) and two radii [m], and the squared radius [m²] of the ball
            about the whole stick
    low     (o, 3) lowest corner of each object's grid [m]
    boxes   (o, 3) number of its boxes along x, y and z
    number  (o,) number of its first box
    first   (b + 1,) the sticks of box b are those at rows[first[b] : first[b + 1]]
    rows    rows of ``sticks``
    """

    sticks: np.ndarray
    low: np.ndarray
    boxes: np.ndarray
    number: np.ndarray
    first: np.ndarray
    rows: np.ndarray


def make_grids(tables: Sequence[StickTable]) -> Grids:
    """Make the grids of objects, each with a table of sticks of its own."""
    sticks, lows, boxes, firsts, rows = [], [], [], [np.zeros(1, np.int64)], []
    before, listed = 0, 0
    for table in tables:
        radii = table.start_radius, table.end_radius
        length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
        ball = (length / 2 + np.maximum(*radii)) ** 2
        ends = np.column_stack((table.start, table.end, *radii, ball))
        low, count, first, within = _make_grid(ends)
        sticks.append(ends)
        lows.append(low)
        boxes.append(count)
        firsts.append(first[1:] + listed)
        rows.append(within + before)
        before, listed = before + len(ends), listed + len(within)
    counts = np.array([len(each) for each in firsts[1:]])
    return Grids(
        np.concatenate(sticks),
        np.array(lows),
        np.array(boxes),
        np.cumsum(counts) - counts,
        np.concatenate(firsts),
        np.concatenate(rows),
    )


@njit(cache=True)
def _make_grid(sticks):  # type: ignore[no-untyped-def]
    """Make a grid of sticks: lowest corner (3,), boxes (3,), first row of each box, rows."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for s in sticks:
        r = max(s[6], s[7])
        for c in range(3):
            low[c] = min(low[c], s[c] - r, s[3 + c] - r)
            high[c] = max(high[c], s[c] + r, s[3 + c] + r)
    boxes = np.empty(3, np.int64)
    for c in range(3):
        boxes[c] = max(1, math.ceil((high[c] - low[c]) / BOX_M))
    nx, ny, nz = boxes
    first, rows = np.zeros(nx * ny * nz + 1, np.int64), np.empty(0, np.int64)
    at, half = first, 0.5 * BOX_M * math.sqrt(3.0)
    for turn in range(2):
        for i in range(len(sticks)):
            a, b, r = sticks[i, :3], sticks[i, 3:6], max(sticks[i, 6], sticks[i, 7])
            begin = np.minimum(((np.minimum(a, b) - r - low) / BOX_M).astype(np.int64), boxes - 1)
            end = np.minimum(((np.maximum(a, b) + r - low) / BOX_M).astype(np.int64), boxes - 1)
            axis = b - a
            square = max((axis * axis).sum(), 1e-12)
            for x in range(begin[0], end[0] + 1):
                for y in range(begin[1], end[1] + 1):
                    for z in range(begin[2], end[2] + 1):
                        px = low[0] + (x + 0.5) * BOX_M - a[0]
                        py = low[1] + (y + 0.5) * BOX_M - a[1]
                        pz = low[2] + (z + 0.5) * BOX_M - a[2]
                        t = (px * axis[0] + py * axis[1] + pz * axis[2]) / square
                        t = min(max(t, 0.0), 1.0)
                        dx, dy, dz = px - t * axis[0], py - t * axis[1], pz - t * axis[2]
                        if dx * dx + dy * dy + dz * dz > (r + half) ** 2:
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
def intersect_ray(grids, which, origin, v, before):  # type: ignore[no-untyped-def]
    """Compute the distance to the first stick of an object along one ray, and its row.

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
            t = _stick_entry(grids.sticks[grids.rows[k]], ox, oy, oz, v)
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
def normal_at(s, point):  # type: ignore[no-untyped-def]
    """Compute the outward unit normal (3,) of a stick at a point (3,) of its surface."""
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
