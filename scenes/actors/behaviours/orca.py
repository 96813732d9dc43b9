"""Collision avoidance: the velocity nearest to a wanted one that keeps clear of all others.

Optimal reciprocal collision avoidance (ORCA): van den Berg, Guy, Lin & Manocha, "Reciprocal n-body
collision avoidance", Robotics Research (ISRR) 2011. Every other one leaves a half-plane of
velocities, from which each of the two takes half of the change. The best of what all leave is a
linear program in two dimensions, solved line by line; where nothing is left, the velocity is taken
that violates the half-planes by the least.
"""

import math

import numpy as np
from numba import njit

from lod.arrays import frozen

_PARALLEL = 1e-9


def orca_velocity(
    own: tuple[float, float, float, float],
    wanted: tuple[float, float],
    others: np.ndarray,
    horizon_s: float,
    step_s: float,
    fastest: float,
) -> tuple[float, float]:
    """Compute the velocity to take [m/s].

    own      place and velocity; wanted: velocity that it would take by itself
    others   (k, 5) place [m], velocity [m/s], and distance to be kept to each [m]
    horizon_s  time for which it keeps clear; step_s: time to get clear of whom it overlaps
    fastest  greatest speed
    """
    table = frozen(np.asarray(others, np.float64).reshape(-1, 5), np.float64)
    return _velocity(own, wanted, table, horizon_s, step_s, fastest)


@njit(cache=True)
def _velocity(own, wanted, others, horizon, step, fastest):  # type: ignore[no-untyped-def]
    x, y, vx, vy = own
    wx, wy = wanted
    n = len(others)
    lines = np.empty((n, 4))
    for k in range(n):
        px, py = others[k, 0] - x, others[k, 1] - y
        ux, uy, dx, dy = _half_plane(
            px, py, vx - others[k, 2], vy - others[k, 3], others[k, 4], horizon, step
        )
        lines[k, 0], lines[k, 1] = vx + 0.5 * ux, vy + 0.5 * uy
        lines[k, 2], lines[k, 3] = dx, dy
    failed, rx, ry = _program_2(lines, n, fastest, wx, wy, False)
    if failed < n:
        rx, ry = _program_3(lines, n, failed, fastest, rx, ry)
    return rx, ry


@njit(cache=True)
def _half_plane(px, py, vx, vy, radius, horizon, step):  # type: ignore[no-untyped-def]
    """Find the least change u of the relative velocity that avoids another, and the line's way."""
    square = px * px + py * py
    near = square <= radius * radius
    per_s = 1.0 / (step if near else horizon)
    wx, wy = vx - per_s * px, vy - per_s * py
    w = math.sqrt(wx * wx + wy * wy)
    along = wx * px + wy * py
    if near or (along < 0 and along * along > radius * radius * w * w):
        if w < 1e-12:
            wx, wy, w = -px, -py, max(math.sqrt(square), 1e-12)
            ex, ey, w = wx / w, wy / w, 0.0
        else:
            ex, ey = wx / w, wy / w
        shift = radius * per_s - w
        return shift * ex, shift * ey, ey, -ex
    leg = math.sqrt(square - radius * radius)
    if px * wy - py * wx > 0:
        dx, dy = (px * leg - py * radius) / square, (px * radius + py * leg) / square
    else:
        dx, dy = -(px * leg + py * radius) / square, -(-px * radius + py * leg) / square
    ahead = vx * dx + vy * dy
    return ahead * dx - vx, ahead * dy - vy, dx, dy


@njit(cache=True)
def _program_1(lines, k, radius, ox, oy, as_direction):  # type: ignore[no-untyped-def]
    """Find the best velocity on line k that the lines before it and the speed allow."""
    px, py, dx, dy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
    along = px * dx + py * dy
    inside = along * along + radius * radius - px * px - py * py
    if inside < 0:
        return False, 0.0, 0.0
    low, high = -along - math.sqrt(inside), -along + math.sqrt(inside)
    for i in range(k):
        cross = dx * lines[i, 3] - dy * lines[i, 2]
        over = lines[i, 2] * (py - lines[i, 1]) - lines[i, 3] * (px - lines[i, 0])
        if abs(cross) <= _PARALLEL:
            if over < 0:
                return False, 0.0, 0.0
            continue
        t = over / cross
        if cross >= 0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False, 0.0, 0.0
    if as_direction:
        t = high if ox * dx + oy * dy > 0 else low
    else:
        t = min(max(dx * (ox - px) + dy * (oy - py), low), high)
    return True, px + t * dx, py + t * dy


@njit(cache=True)
def _program_2(lines, n, radius, ox, oy, as_direction):  # type: ignore[no-untyped-def]
    """Find the velocity nearest to (ox, oy); the first line that leaves nothing, or n."""
    length = math.sqrt(ox * ox + oy * oy)
    rx, ry = ox, oy
    if as_direction or length > radius:
        rx, ry = ox * radius / max(length, 1e-12), oy * radius / max(length, 1e-12)
    for k in range(n):
        beyond = lines[k, 2] * (lines[k, 1] - ry) - lines[k, 3] * (lines[k, 0] - rx)
        if beyond > 0:
            found, x, y = _program_1(lines, k, radius, ox, oy, as_direction)
            if not found:
                return k, rx, ry
            rx, ry = x, y
    return n, rx, ry


@njit(cache=True)
def _program_3(lines, n, first, radius, rx, ry):  # type: ignore[no-untyped-def]
    """Find the velocity that violates the lines by the least, from the first that leaves none."""
    worst = 0.0
    for k in range(first, n):
        px, py, dx, dy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
        if dx * (py - ry) - dy * (px - rx) <= worst:
            continue
        between, m = np.empty((k, 4)), 0
        for i in range(k):
            cross = dx * lines[i, 3] - dy * lines[i, 2]
            if abs(cross) <= _PARALLEL:
                if dx * lines[i, 2] + dy * lines[i, 3] > 0:
                    continue
                between[m, 0], between[m, 1] = (px + lines[i, 0]) / 2, (py + lines[i, 1]) / 2
            else:
                over = lines[i, 2] * (py - lines[i, 1]) - lines[i, 3] * (px - lines[i, 0])
                between[m, 0], between[m, 1] = px + over / cross * dx, py + over / cross * dy
            ex, ey = lines[i, 2] - dx, lines[i, 3] - dy
            length = max(math.sqrt(ex * ex + ey * ey), 1e-12)
            between[m, 2], between[m, 3] = ex / length, ey / length
            m += 1
        failed, x, y = _program_2(between, m, radius, -dy, dx, True)
        if failed == m:
            rx, ry = x, y
        worst = dx * (py - ry) - dy * (px - rx)
    return rx, ry
