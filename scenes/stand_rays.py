"""Straight lines through an endless stand of sticks: a square plot that repeats in x and y.

Lines along one direction are told apart by where they meet the level ground, so a direction's
sticks are listed by the squares of the plot that their shadows along it fall on. Nothing is nearer
than that to an acceleration structure, and it needs none: whatever repeats is looked up modulo the
plot's side.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from scenes.stick_table import StickTable

SQUARES = 64
"""Along a side of the plot."""

NOTHING = -1.0
"""Distance along a line that meets no stick."""


class Shadows(NamedTuple):
    """Sticks by where their shadows along one direction (3,) fall; those of square k are
    rows[first[k] : first[k + 1]], each moved by ``shift`` (m, 2) [m] to be that copy."""

    direction: np.ndarray
    side: float
    first: np.ndarray
    rows: np.ndarray
    shift: np.ndarray


def shadows_along(table: StickTable, side: float, direction: np.ndarray) -> Shadows:
    """Lists for lines along a unit vector that points up, out of the ground."""
    columns = table.start, table.end, table.start_radius, table.end_radius
    first, rows, shift = _listed(*columns, side, direction)
    return Shadows(direction, side, first, rows, shift)


def first_met(
    table: StickTable, shadows: Shadows, origin: np.ndarray, after: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What lines through ``origin`` (n, 3) meet farthest along the direction, from ``after`` [m]
    on: how far from the origin (n,), NOTHING where none, the stick's row and the normal there."""
    columns = table.start, table.end, table.start_radius, table.end_radius
    return _met(*columns, *shadows, origin, after)


@njit(cache=True)
def _listed(start, end, r0, r1, side, v):  # type: ignore[no-untyped-def]
    cell, flat = side / SQUARES, math.hypot(v[0], v[1])
    hx, hy = (v[0] / flat, v[1] / flat) if flat > 1e-9 else (1.0, 0.0)
    count = np.zeros(SQUARES * SQUARES + 1, np.int64)
    rows, shift = np.empty(0, np.int64), np.empty((0, 2))
    at = count
    for turn in range(2):
        mark = np.full(SQUARES * SQUARES, -1)
        for i in range(len(r0)):
            r = max(r0[i], r1[i])
            reach = r / v[2]  # of a sphere's shadow along the direction; r across it
            ax, ay = (
                start[i, 0] - start[i, 2] * v[0] / v[2],
                start[i, 1] - start[i, 2] * v[1] / v[2],
            )
            bx, by = end[i, 0] - end[i, 2] * v[0] / v[2], end[i, 1] - end[i, 2] * v[1] / v[2]
            n = 1 + int(math.hypot(bx - ax, by - ay) / cell)
            m = 1 + int(2 * reach / cell)
            pad = r + 0.5 * cell
            for j in range(n + 1):
                for k in range(m + 1):
                    along = reach * (2.0 * k / m - 1.0)
                    x = ax + (bx - ax) * j / n + along * hx
                    y = ay + (by - ay) * j / n + along * hy
                    x0, x1 = math.floor((x - pad) / cell), math.floor((x + pad) / cell)
                    y0, y1 = math.floor((y - pad) / cell), math.floor((y + pad) / cell)
                    for cy in range(y0, y1 + 1):
                        for cx in range(x0, x1 + 1):
                            wx, wy = cx // SQUARES, cy // SQUARES
                            square = (cy - wy * SQUARES) * SQUARES + cx - wx * SQUARES
                            if mark[square] == i * 64 + (wx & 7) * 8 + (wy & 7):
                                continue
                            mark[square] = i * 64 + (wx & 7) * 8 + (wy & 7)
                            if turn == 0:
                                count[square + 1] += 1
                            else:
                                rows[at[square]] = i
                                shift[at[square], 0] = -wx * side
                                shift[at[square], 1] = -wy * side
                                at[square] += 1
        if turn == 0:
            count = np.cumsum(count)
            at = count[:-1].copy()
            rows, shift = np.empty(count[-1], np.int64), np.empty((count[-1], 2))
    return count, rows, shift


@njit(cache=True)
def _met(start, end, r0, r1, v, side, first, rows, shift, origin, after):  # type: ignore[no-untyped-def]
    n = len(origin)
    far, which, normal = np.full(n, NOTHING), np.full(n, -1), np.zeros((n, 3))
    o, axis = np.empty(3), np.empty(3)
    for i in range(n):
        gx = origin[i, 0] - origin[i, 2] * v[0] / v[2]
        gy = origin[i, 1] - origin[i, 2] * v[1] / v[2]
        # The origin's own copy of the plot, whatever others its line goes through.
        wx, wy = math.floor(gx / side), math.floor(gy / side)
        cx = min(int((gx / side - wx) * SQUARES), SQUARES - 1)
        cy = min(int((gy / side - wy) * SQUARES), SQUARES - 1)
        square = cy * SQUARES + cx
        for k in range(first[square], first[square + 1]):
            s = rows[k]
            o[0] = origin[i, 0] - wx * side - shift[k, 0] - start[s, 0]
            o[1] = origin[i, 1] - wy * side - shift[k, 1] - start[s, 1]
            o[2] = origin[i, 2] - start[s, 2]
            for c in range(3):
                axis[c] = end[s, c] - start[s, c]
            t = _leaves(o, v, axis, r0[s], r1[s])
            if t > after and t > far[i]:
                far[i], which[i] = t, s
                normal[i] = _normal(o + t * v, axis, r0[s], r1[s])
    return far, which, normal


@njit(cache=True)
def _leaves(o, v, axis, r0, r1):  # type: ignore[no-untyped-def]
    """How far along a line, from ``o`` relative to the start, it leaves a stick; −1e30 if never.

    A stick is convex, so that is the farthest of where it leaves either sphere and the frustum:
    ρ²·(1 − s²) = (r₀ − s·y)², s = (r₀ − r₁)/L, ρ from the axis and y along it.
    """
    length = math.sqrt(axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2)
    best = max(_leaves_sphere(o, v, r0), _leaves_sphere(o - axis, v, r1))
    s = (r0 - r1) / length if length > 0 else 2.0
    if abs(s) >= 1:
        return best
    y = (o[0] * axis[0] + o[1] * axis[1] + o[2] * axis[2]) / length
    yd = (v[0] * axis[0] + v[1] * axis[1] + v[2] * axis[2]) / length
    ov = o[0] * v[0] + o[1] * v[1] + o[2] * v[2]
    oo = o[0] ** 2 + o[1] ** 2 + o[2] ** 2
    a = (1 - s * s) * (1 - yd * yd) - s * s * yd * yd
    b = (1 - s * s) * (ov - y * yd) + s * yd * (r0 - s * y)
    c = (1 - s * s) * (oo - y * y) - (r0 - s * y) ** 2
    disc = b * b - a * c
    if disc <= 0 or abs(a) < 1e-12:
        return best
    for sign in (-1.0, 1.0):
        t = (-b + sign * math.sqrt(disc)) / a
        if r0 * s <= y + t * yd <= length + r1 * s:
            best = max(best, t)
    return best


@njit(cache=True)
def _leaves_sphere(o, v, r):  # type: ignore[no-untyped-def]
    b = o[0] * v[0] + o[1] * v[1] + o[2] * v[2]
    disc = b * b - (o[0] ** 2 + o[1] ** 2 + o[2] ** 2) + r * r
    return -b + math.sqrt(disc) if disc > 0 else -1e30


@njit(cache=True)
def _normal(p, axis, r0, r1):  # type: ignore[no-untyped-def]
    """Outward unit normal of a stick at a point of it, relative to its start."""
    ll = axis[0] ** 2 + axis[1] ** 2 + axis[2] ** 2
    length = math.sqrt(ll)
    t = 0.0
    s = (r0 - r1) / length if length > 0 else 2.0
    if abs(s) < 1:
        y = (p[0] * axis[0] + p[1] * axis[1] + p[2] * axis[2]) / length
        across = math.sqrt(max(p[0] ** 2 + p[1] ** 2 + p[2] ** 2 - y * y, 0.0))
        t = min(max((y - across * s / math.sqrt(1 - s * s)) / length, 0.0), 1.0)
    elif r1 > r0:
        t = 1.0
    n = p - t * axis
    return n / math.sqrt(n[0] ** 2 + n[1] ** 2 + n[2] ** 2)
