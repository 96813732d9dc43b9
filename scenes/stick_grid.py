"""Straight lines through sticks, by a grid of boxes: a plot that repeats without end in x and y.

Every box lists the sticks that reach into it; a line goes from box to box (Amanatides & Woo, "A
fast voxel traversal algorithm for ray tracing", Eurographics 1987) until what it has met is nearer
than the next.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Ints, Points, Reals
from scenes.stick_table import StickTable

BOX_M = 0.5
"""Side of a box, about."""

NOTHING = np.inf
"""Distance along a line that meets no stick."""


class Grid(NamedTuple):
    """Sticks by the boxes that they reach into.

    sticks  (k, 8) start, end, and the two radii; low, high of all of them [m]
    side    of the plot [m]; boxes (3,) along x, y and z; box (3,) sides of one [m]
    first   (boxes + 1,): sticks of box b are rows[first[b] : first[b + 1]], each with the shift
            (m, 2), whole plots, that brings it there
    """

    sticks: np.ndarray
    low: float
    high: float
    side: float
    boxes: np.ndarray
    box: np.ndarray
    first: np.ndarray
    rows: np.ndarray
    shift: np.ndarray


def grid_of(table: StickTable, side: float) -> Grid:
    """The grid of a plot of that side [m]; sticks may reach over its edge."""
    sticks = np.column_stack((table.start, table.end, table.start_radius, table.end_radius))
    r = np.maximum(table.start_radius, table.end_radius)
    low = float((np.minimum(table.start[:, 2], table.end[:, 2]) - r).min())
    high = float((np.maximum(table.start[:, 2], table.end[:, 2]) + r).max())
    across = max(1, round(side / BOX_M))
    boxes = np.array((across, across, max(1, math.ceil((high - low) / BOX_M))))
    box = np.array((side / across, side / across, (high - low) / boxes[2]))
    return Grid(sticks, low, high, side, boxes, box, *_listed(sticks, low, boxes, box))


def first_met(grid: Grid, origin: Points, direction: Points) -> tuple[Reals, Ints, Points]:
    """What each line from an origin outside all sticks meets first, (n, 3) both: how far off (n,),
    NOTHING where none, the stick's row (−1), and the outward normal there (0)."""
    return _first_met(grid, origin, direction)


@njit(cache=True)
def _listed(sticks, low, boxes, box):  # type: ignore[no-untyped-def]
    nx, ny, nz = boxes
    first = np.zeros(nx * ny * nz + 1, np.int64)
    rows, shift = np.empty(0, np.int64), np.empty((0, 2))
    at, half = first, 0.5 * math.sqrt((box * box).sum())
    for turn in range(2):
        for i in range(len(sticks)):
            a, b, r = sticks[i, :3], sticks[i, 3:6], max(sticks[i, 6], sticks[i, 7])
            lo, hi = np.minimum(a, b) - r, np.maximum(a, b) + r
            axis = b - a
            square = max((axis * axis).sum(), 1e-12)
            for x in range(math.floor(lo[0] / box[0]), math.floor(hi[0] / box[0]) + 1):
                for y in range(math.floor(lo[1] / box[1]), math.floor(hi[1] / box[1]) + 1):
                    bottom = max(math.floor((lo[2] - low) / box[2]), 0)
                    top = min(math.floor((hi[2] - low) / box[2]), nz - 1)
                    for z in range(bottom, top + 1):
                        px, py = (x + 0.5) * box[0] - a[0], (y + 0.5) * box[1] - a[1]
                        pz = low + (z + 0.5) * box[2] - a[2]
                        t = (px * axis[0] + py * axis[1] + pz * axis[2]) / square
                        t = min(max(t, 0.0), 1.0)
                        dx, dy, dz = px - t * axis[0], py - t * axis[1], pz - t * axis[2]
                        if dx * dx + dy * dy + dz * dz > (r + half) ** 2:
                            continue
                        wx, wy = x // nx, y // ny
                        place = ((x - wx * nx) * ny + y - wy * ny) * nz + z
                        if turn == 0:
                            first[place + 1] += 1
                        else:
                            k = at[place]
                            rows[k], shift[k, 0], shift[k, 1] = i, -wx, -wy
                            at[place] += 1
        if turn == 0:
            first = np.cumsum(first)
            at = first[:-1].copy()
            rows, shift = np.empty(first[-1], np.int64), np.empty((first[-1], 2))
    return first, rows, shift


@njit(cache=True)
def _first_met(grid, origin, direction):  # type: ignore[no-untyped-def]
    n = len(origin)
    far, which, normal = np.full(n, NOTHING), np.full(n, -1), np.zeros((n, 3))
    for i in range(n):
        far[i], which[i], normal[i, 0], normal[i, 1], normal[i, 2] = meet(
            grid, origin[i], direction[i]
        )
    return far, which, normal


@njit(cache=True)
def meet(grid, origin, v):  # type: ignore[no-untyped-def]
    """How far one line goes until it meets a stick, which, and the normal there."""
    # From where the line comes in between the lowest and the highest of all sticks.
    begin, end = 0.0, math.inf
    if v[2] != 0.0:
        one, two = (grid.low - origin[2]) / v[2], (grid.high - origin[2]) / v[2]
        begin, end = max(begin, min(one, two)), max(one, two)
    elif not grid.low <= origin[2] <= grid.high:
        end = -1.0
    nearest, which, wx, wy = NOTHING, -1, 0.0, 0.0
    nx, ny, nz = grid.boxes
    cell, step = np.empty(3, np.int64), np.empty(3, np.int64)
    next_t, delta = np.empty(3), np.empty(3)
    for c in range(3):
        at = origin[c] + begin * v[c] - (grid.low if c == 2 else 0.0)
        cell[c] = math.floor(at / grid.box[c])
        if c == 2:
            cell[c] = min(max(cell[c], 0), nz - 1)
        step[c] = 1 if v[c] > 0 else -1
        if v[c] != 0.0:
            edge = (cell[c] + (1 if v[c] > 0 else 0)) * grid.box[c]
            next_t[c], delta[c] = begin + (edge - at) / v[c], grid.box[c] / abs(v[c])
        else:
            next_t[c], delta[c] = math.inf, math.inf
    while begin < end:
        axis = 0 if next_t[0] < next_t[1] else 1
        axis = 2 if next_t[2] < next_t[axis] else axis
        leave = next_t[axis]
        px, py = cell[0] // nx, cell[1] // ny
        place = ((cell[0] - px * nx) * ny + cell[1] - py * ny) * nz + cell[2]
        for k in range(grid.first[place], grid.first[place + 1]):
            dx, dy = (px + grid.shift[k, 0]) * grid.side, (py + grid.shift[k, 1]) * grid.side
            t = _enters(grid.sticks[grid.rows[k]], origin[0] - dx, origin[1] - dy, origin[2], v)
            if 0.0 < t < nearest:
                nearest, which, wx, wy = t, grid.rows[k], dx, dy
        if nearest <= leave or leave >= end:
            break
        begin = leave
        cell[axis] += step[axis]
        next_t[axis] += delta[axis]
        if axis == 2 and not 0 <= cell[2] < nz:
            break
    if which < 0:
        return NOTHING, -1, 0.0, 0.0, 0.0
    s = grid.sticks[which]
    x, y = origin[0] + nearest * v[0] - wx, origin[1] + nearest * v[1] - wy
    a, b, c = _normal(s, x, y, origin[2] + nearest * v[2])
    return nearest, which, a, b, c


@njit(cache=True)
def _enters(s, x, y, z, v):  # type: ignore[no-untyped-def]
    """How far along a line from (x, y, z) it enters a stick; infinite if it never does.

    The nearest of where it enters either sphere and the frustum between them:
    ρ²·(1 − s²) = (r₀ − s·h)², s = (r₀ − r₁)/L, ρ from the axis and h along it.
    """
    ox, oy, oz = x - s[0], y - s[1], z - s[2]
    ax, ay, az = s[3] - s[0], s[4] - s[1], s[5] - s[2]
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
def _normal(s, x, y, z):  # type: ignore[no-untyped-def]
    """Outward unit normal of a stick at a point of it."""
    px, py, pz = x - s[0], y - s[1], z - s[2]
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
    return nx / size, ny / size, nz / size
