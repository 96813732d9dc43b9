"""How far points can be from a joint in any pose that the limits allow: an upper bound.

Points x of a jointed chain form a set S; |x| is at most max over directions u of h(u) = max of u·x,
the set's support function (Rockafellar, "Convex Analysis", 1970, §13). Down the chain it obeys

    h_parent(u) = max over children of  u·offset + max over allowed R of h_child(Rᵀu),

and R = Rz·Ry·Rx takes three maxima over one angle each, so that no combination of angles is ever
listed. Two steps keep it an upper bound, both with an error of second order only:

* h is kept on the points (1, s, t) of a cube's faces. It is convex, so interpolating bilinearly
never gives less than its value (Jensen).
* An arc between two angles δ apart lies within the two points of those angles moved out from the
axis by 1/cos(δ/2), so that a few angles stand for all between them.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Ints, Points, Reals, frozen
from scenes.rig.rig import Rig

CELLS = 24
"""Cells along the edge of the cube."""

STEP_DEG = 7.5
"""Largest step between angles."""


def reach_bound(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound the distance from a joint to the far side of spheres on other joints [m].

    joints (k,), points (k, 3) [m], radii (k,) [m]: the spheres, in the frames of their joints
        (−1 = the object's frame)
    """
    if not len(joints):
        return 0.0
    below = _is_under(rig, joint)[joints + 1]
    bound = (
        _bound_below(rig, joint, joints[below], points[below], radii[below]) if below.any() else 0.0
    )
    for row in np.flatnonzero(~below):
        one = slice(int(row), int(row) + 1)
        bound = max(bound, _bound_across(rig, joint, joints[one], points[one], radii[one]))
    return bound * (1 + 1e-12)  # rounding, too, stays below it


def _bound_across(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound it for a sphere that does not ride on ``joint``, by the nearest joint of both [m]."""
    if joint >= 0 and rig.parent[joint] == -1 and joints[0] == -1:
        corners = np.stack(np.meshgrid(*zip(rig.shift_low, rig.shift_high, strict=True)), axis=-1)
        away = points[0] - rig.offset[joint] - corners.reshape(-1, 3)
        return float(np.linalg.norm(away, axis=1).max() + radii[0])
    common = joint
    while not _is_under(rig, common)[joints[0] + 1]:
        common = int(rig.parent[common])
    there = _bound_below(rig, common, joints, points, radii)
    return there + _bound_below(rig, common, np.array([joint]), np.zeros((1, 3)), np.zeros(1))


def _is_under(rig: Rig, joint: int) -> np.ndarray:
    """Tell whether joints −1, 0, 1, … ride on ``joint``, (j + 1,)."""
    under = np.zeros(len(rig) + 1, bool)
    under[joint + 1] = True
    for row, parent in enumerate(rig.parent):
        under[row + 1] |= under[parent + 1]
    return under


def _bound_below(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound it for spheres that ride on ``joint``, or on joints below it [m]."""
    if joint == -1:
        moves = np.maximum(np.abs(rig.shift_low), np.abs(rig.shift_high))
        radii = radii + np.where(joints >= 0, np.linalg.norm(moves), 0.0)
    while joints[0] != joint and not points.any() and (joints == joints[0]).all():
        # Its own turn leaves a joint's origin where it is.
        points = np.broadcast_to(rig.offset[joints[0]], points.shape)
        joints = np.full_like(joints, rig.parent[joints[0]])
    if (joints == joint).all():
        return float((np.linalg.norm(points, axis=1) + radii).max())
    low, high = (frozen(np.radians(limit), np.float64) for limit in (rig.low, rig.high))
    tree = _Joints(rig.parent, rig.offset, low, high)
    places = frozen(points, np.float64), frozen(radii, np.float64)
    spheres = _Spheres(frozen(joints, np.int64), *places)
    largest = _support(tree, joint, spheres, CELLS, math.radians(STEP_DEG))
    # The nearest direction that h is known in is at most half a cell's diagonal away.
    return float(largest / math.cos(math.atan(math.sqrt(2) / CELLS)))


class _Joints(NamedTuple):
    """Columns of a rig: parents, offsets [m], least and greatest angles [rad]."""

    parent: np.ndarray
    offset: np.ndarray
    low: np.ndarray
    high: np.ndarray


class _Spheres(NamedTuple):
    """Spheres in the frames of joints: centres (k, 3) and radii (k,) [m]."""

    joints: np.ndarray
    points: np.ndarray
    radii: np.ndarray


@njit(cache=True)
def _support(tree, root, spheres, cells, step):  # type: ignore[no-untyped-def]
    """Compute the largest h(u)/|u| over the grid, of all spheres as seen from joint ``root``."""
    parent, offset, low, high = tree
    joints, points, radii = spheres
    grid = _directions(cells)
    size = len(grid)
    tables = np.full((len(parent) + 1, size), -np.inf)
    loaded = np.zeros(len(parent) + 1, np.bool_)
    for k in range(len(joints)):
        loaded[joints[k] + 1] = True
        for g in range(size):
            x, y, z = grid[g]
            reach = x * points[k, 0] + y * points[k, 1] + z * points[k, 2]
            reach += radii[k] * math.sqrt(x * x + y * y + z * z)
            tables[joints[k] + 1, g] = max(tables[joints[k] + 1, g], reach)
    for j in range(len(parent) - 1, root, -1):
        if not loaded[j + 1]:
            continue
        h = tables[j + 1]
        for axis in range(3):
            h = _sweep(h, grid, cells, axis, low[j, axis], high[j, axis], step)
        up = parent[j] + 1
        loaded[up] = True
        for g in range(size):
            x, y, z = grid[g]
            shifted = x * offset[j, 0] + y * offset[j, 1] + z * offset[j, 2] + h[g]
            tables[up, g] = max(tables[up, g], shifted)
    largest = 0.0
    for g in range(size):
        x, y, z = grid[g]
        largest = max(largest, tables[root + 1, g] / math.sqrt(x * x + y * y + z * z))
    return largest


@njit(cache=True)
def _sweep(h, grid, cells, axis, low, high, step):  # type: ignore[no-untyped-def]
    """Compute the support function of the set turned about an axis by every angle of a range."""
    steps = math.ceil((high - low) / step)
    if steps == 0 and low == 0.0:
        return h
    between = (high - low) / steps if steps else 0.0
    out = 1.0 / math.cos(between / 2)
    swept = np.full(len(grid), -np.inf)
    b, c = (axis + 1) % 3, (axis + 2) % 3
    for i in range(steps + 1):
        cos, sin = math.cos(low + i * between) * out, math.sin(low + i * between) * out
        for g in range(len(grid)):
            u, v, w = grid[g, axis], grid[g, b], grid[g, c]
            reach = _interpolated(h, cells, axis, u, cos * v + sin * w, cos * w - sin * v)
            swept[g] = max(swept[g], reach)
    return swept


@njit(cache=True, inline="always")
def _interpolated(h, cells, axis, u, v, w):  # type: ignore[no-untyped-def]
    """Bound h in a direction, bilinearly on the face of the cube that it points through.

    u, v, w: components of the direction along ``axis`` and the two axes that follow it
    """
    if abs(v) > abs(u) and abs(v) >= abs(w):
        axis, u, v, w = axis + 1, v, w, u
    elif abs(w) > abs(u):
        axis, u, v, w = axis + 2, w, u, v
    m = abs(u)
    half = 0.5 * cells / m
    s, t = v * half + 0.5 * cells, w * half + 0.5 * cells
    i, k = min(int(s), cells - 1), min(int(t), cells - 1)
    s, t = s - i, t - k
    face = 2 * (axis if axis < 3 else axis - 3) + (1 if u < 0 else 0)
    at = (face * (cells + 1) + i) * (cells + 1) + k
    low = h[at] * (1 - t) + h[at + 1] * t
    high = h[at + cells + 1] * (1 - t) + h[at + cells + 2] * t
    return m * (low * (1 - s) + high * s)


@njit(cache=True)
def _directions(cells):  # type: ignore[no-untyped-def]
    """Make the grid points on the six faces of the cube of half side 1, (6·(cells + 1)², 3)."""
    grid = np.empty((6 * (cells + 1) ** 2, 3))
    at = 0
    for face in range(6):
        axis, sign = face // 2, 1.0 - 2.0 * (face % 2)
        for i in range(cells + 1):
            for k in range(cells + 1):
                grid[at, axis] = sign
                grid[at, (axis + 1) % 3] = 2.0 * i / cells - 1.0
                grid[at, (axis + 2) % 3] = 2.0 * k / cells - 1.0
                at += 1
    return grid
