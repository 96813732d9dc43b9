"""Intersection of rays with the sticks of objects, by a grid of boxes about each object.

Every box lists the sticks that reach into it; a line goes from box to box (Amanatides & Woo, "A
fast voxel traversal algorithm for ray tracing", Eurographics 1987) until what it has met is nearer
than the next.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.stick_table import StickTable

BOX_M = 0.25
"""Side of a box."""

NOTHING = np.inf
"""Distance along a line that meets no stick."""


class Grids(NamedTuple):
    """Sticks of objects o, laid end to end, by the boxes that they reach into.

    sticks  (k, 9) start, end, and the two radii [m]; and of the ball about both ends, its radius
            squared
    low     (o, 3) corner of each object's grid [m]; boxes (o, 3) along x, y and z
    number  (o,) of each object's first box; of box b are the sticks rows[first[b] : first[b + 1]]
    """

    sticks: np.ndarray
    low: np.ndarray
    boxes: np.ndarray
    number: np.ndarray
    first: np.ndarray
    rows: np.ndarray


def grids_of(tables: Sequence[StickTable]) -> Grids:
    """The grids of objects, each with a table of its own."""
    sticks, lows, boxes, firsts, rows = [], [], [], [np.zeros(1, np.int64)], []
    before, listed = 0, 0
    for table in tables:
        radii = table.start_radius, table.end_radius
        length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
        ball = (length / 2 + np.maximum(*radii)) ** 2
        ends = np.column_stack((table.start, table.end, *radii, ball))
        low, count, first, within = _listed(ends)
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


def first_met(
    grids: Grids, which: int, origin: Points, direction: Points
) -> tuple[Reals, Ints, Points]:
    """What each line from an origin outside all sticks meets first of one object, (n, 3) both: how
    far off (n,), NOTHING where none, the stick's row (−1), and the outward normal there (0)."""
    return _first_met(grids, which, origin, direction)


@njit(cache=True)
def _listed(sticks):  # type: ignore[no-untyped-def]
    """Corner and boxes of a grid (3,) each, where the rows of each box begin, and the rows."""
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
def _first_met(grids, which, origin, direction):  # type: ignore[no-untyped-def]
    n = len(origin)
    far, row, normal = np.full(n, NOTHING), np.full(n, -1), np.zeros((n, 3))
    for i in range(n):
        o, v = origin[i], direction[i]
        far[i], row[i] = meet(grids, which, (o[0], o[1], o[2]), (v[0], v[1], v[2]), NOTHING)
        if row[i] >= 0:
            normal[i] = normal_at(grids.sticks[row[i]], origin[i] + far[i] * direction[i])
    return far, row, normal


@njit(cache=True)
def meet(grids, which, origin, v, before):  # type: ignore[no-untyped-def]
    """How far one line goes until it meets a stick of an object, and which stick; NOTHING and −1 if
    it meets none within ``before``."""
    ox, oy, oz = origin
    vx, vy, vz = v
    lx, ly, lz = grids.low[which, 0], grids.low[which, 1], grids.low[which, 2]
    nx, ny, nz = grids.boxes[which, 0], grids.boxes[which, 1], grids.boxes[which, 2]
    begin, end = _between(ox, vx, lx, lx + nx * BOX_M, 0.0, before)
    begin, end = _between(oy, vy, ly, ly + ny * BOX_M, begin, end)
    begin, end = _between(oz, vz, lz, lz + nz * BOX_M, begin, end)
    nearest, row = before, -1
    x, next_x, step_x = _boxed(ox + begin * vx - lx, vx, nx, begin)
    y, next_y, step_y = _boxed(oy + begin * vy - ly, vy, ny, begin)
    z, next_z, step_z = _boxed(oz + begin * vz - lz, vz, nz, begin)
    while begin < end:
        begin = min(next_x, next_y, next_z)
        place = grids.number[which] + (x * ny + y) * nz + z
        for k in range(grids.first[place], grids.first[place + 1]):
            t = _enters(grids.sticks[grids.rows[k]], ox, oy, oz, v)
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
def _between(o, v, low, high, begin, end):  # type: ignore[no-untyped-def]
    """The part of a line, from begin to end, where one coordinate is from low to high."""
    if v != 0.0:
        one, two = (low - o) / v, (high - o) / v
        return max(begin, min(one, two)), min(end, max(one, two))
    return begin, end if low <= o <= high else -1.0


@njit(cache=True, inline="always")
def _boxed(at, v, count, begin):  # type: ignore[no-untyped-def]
    """Along one axis the box of a point, how far along a line that is there at ``begin`` the next
    box begins, and how far it goes through each."""
    box = min(max(math.floor(at / BOX_M), 0), count - 1)
    if v == 0.0:
        return box, math.inf, math.inf
    return box, begin + ((box + (1 if v > 0 else 0)) * BOX_M - at) / v, BOX_M / abs(v)


@njit(cache=True)
def _enters(s, x, y, z, v):  # type: ignore[no-untyped-def]
    """How far along a line from (x, y, z) it enters a stick; infinite if it never does.

    The nearest of where it enters either sphere and the frustum between them:
    ρ²·(1 − s²) = (r₀ − s·h)², s = (r₀ − r₁)/L, ρ from the axis and h along it.
    """
    ox, oy, oz = x - s[0], y - s[1], z - s[2]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
    # Most lines pass the ball about all of it.
    mx, my, mz = ox - 0.5 * ax, oy - 0.5 * ay, oz - 0.5 * az
    mv = mx * v[0] + my * v[1] + mz * v[2]
    if mx * mx + my * my + mz * mz - mv * mv > s[8]:
        return math.inf
    r0, r1 = s[6], s[7]
    length2 = ax * ax + ay * ay + az * az
    ov = ox * v[0] + oy * v[1] + oz * v[2]
    oo = ox * ox + oy * oy + oz * oz
    # Nothing of it is within reach of the line's foot.
    av, ao = ax * v[0] + ay * v[1] + az * v[2], ax * ox + ay * oy + az * oz
    best = _enters_sphere(ov, oo, r0)
    best = min(best, _enters_sphere(ov - av, oo - 2 * ao + length2, r1))
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
            # On the way in, not out: the sign of the normal along the line.
            best = t
    return best


@njit(cache=True)
def _enters_sphere(ov, oo, r):  # type: ignore[no-untyped-def]
    disc = ov * ov - oo + r * r
    if disc <= 0:
        return math.inf
    t = -ov - math.sqrt(disc)
    return t if t > 0 else math.inf


@njit(cache=True)
def normal_at(s, point):  # type: ignore[no-untyped-def]
    """Outward unit normal (3,) of a stick at a point of it."""
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
