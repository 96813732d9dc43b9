"""Rays through an endless stand: a Poisson process of objects that are turned at random.

The land is divided into square cells. The number of objects in a cell, their places, prototypes and
azimuths are functions of the cell and of the number of the stand, so that nothing is stored and
stands of different numbers are independent.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Reals
from lod.shapes import StickTable
from scenes.appearance.ray_grid import NOTHING, Grids, intersect_ray, make_grids, normal_at
from scenes.noise import lattice_bits, unit_float

_SEED = np.uint64(0x57A4D)

_LAYER = 2**40
"""What the numbers of a line's stands in one layer and the next differ by."""


class StandField(NamedTuple):
    """An endless stand of p prototypes.

    grids       grids of the prototypes' sticks
    chance (p,) probability that an object has this prototype or an earlier one
    reach, high (p,)  radius about an object's axis, and height, that it stays within [m]
    low, top    lowest and highest that any object reaches [m]
    cell        side of a cell [m]
    mean, none  mean number of objects in a cell, and probability that there is none
    """

    grids: Grids
    chance: np.ndarray
    reach: np.ndarray
    high: np.ndarray
    low: float
    top: float
    cell: float
    mean: float
    none: float


class Ray(NamedTuple):
    """A ray from a point [m] along a direction, (3,) each."""

    origin: np.ndarray
    direction: np.ndarray


def stand_field(
    tables: Sequence[StickTable], densities: Reals, cell: float | None = None
) -> StandField:
    """Make a stand of prototypes with densities (p,) [1/m²].

    Stands of one number have the same objects if their cells and densities are the same. A cell may
    not be smaller than the largest reach; by default it is that, or room for one object.
    """
    reach, low, high = np.array([stick_extent(table) for table in tables]).T
    density, furthest = float(densities.sum()), float(reach.max())
    side = max(furthest, 1 / math.sqrt(density)) if cell is None else cell
    assert side >= furthest, "a cell holds what stands in its middle"
    return StandField(
        make_grids(tables),
        np.cumsum(densities) / density,
        reach,
        high,
        float(low.min()),
        float(high.max()),
        side,
        density * side**2,
        math.exp(-density * side**2),
    )


def stick_extent(table: StickTable) -> tuple[float, float, float]:
    """Find the radius about its axis that an object is within, its lowest and highest [m]."""
    radius = np.maximum(table.start_radius, table.end_radius)
    ends = ((each, radius) for each in (table.start, table.end))
    rows = [(np.hypot(p[:, 0], p[:, 1]) + r, p[:, 2] - r, p[:, 2] + r) for p, r in ends]
    away, low, high = (np.concatenate(each) for each in zip(*rows, strict=True))
    return float(away.max()), float(low.min()), float(high.max())


CROWDED = 16.0
"""Objects in a cell of the largest from which on smaller ones get a layer of finer cells."""


def stand_layers(reach: Reals, densities: Reals) -> list[np.ndarray]:
    """Share out species of these reaches [m] and densities [1/m²], (k,), to layers: rows of each.

    Rays through the large cells of trees would meet thousands of tufts in each.
    """
    furthest = reach.max()
    crowded = (densities * furthest**2 > CROWDED) & (reach < furthest / 2)
    layers = np.flatnonzero(~crowded), np.flatnonzero(crowded)
    return [each for each in layers if len(each)]


@njit(cache=True)
def intersect_layers(layers, number, origin, v):  # type: ignore[no-untyped-def]
    """Find the first stick that a ray meets in stands one in another, as ``intersect_stand`` does.

    Rows count the sticks of all layers; the stands of layers are independent.
    """
    nearest, row, normal = intersect_stand(layers[0], number, origin, v)
    before = len(layers[0].grids.shapes)
    for k in range(1, len(layers)):
        t, stick, met = intersect_stand(layers[k], number + k * _LAYER, origin, v)
        if stick >= 0 and t < nearest:
            nearest, row, normal = t, before + stick, met
        before += len(layers[k].grids.shapes)
    return nearest, row, normal


@njit(cache=True)
def intersect_stand(stand, number, origin, v):  # type: ignore[no-untyped-def]
    """Find the first stick of a stand that a ray meets: distance, row, outward normal (3,).

    Rows count the sticks of all prototypes. Without a hit they are NOTHING, −1 and 0.
    """
    begin, end = 0.0, math.inf
    if v[2] != 0.0:
        one, two = (stand.low - origin[2]) / v[2], (stand.top - origin[2]) / v[2]
        begin, end = max(begin, min(one, two)), max(one, two)
    elif not stand.low <= origin[2] <= stand.top:
        end = -1.0
    nearest, row, normal = NOTHING, -1, np.zeros(3)
    ray = Ray(origin, v)
    if begin >= end:
        return nearest, row, normal
    cell, step = np.empty(2, np.int64), np.empty(2, np.int64)
    next_t, delta = np.full(2, math.inf), np.full(2, math.inf)
    for c in range(2):
        at = origin[c] + begin * v[c]
        cell[c] = math.floor(at / stand.cell)
        step[c] = 1 if v[c] > 0 else -1
        if v[c] != 0.0:
            edge = (cell[c] + (1 if v[c] > 0 else 0)) * stand.cell
            next_t[c], delta[c] = begin + (edge - at) / v[c], stand.cell / abs(v[c])
    # What stands in the neighbours of a cell may reach into it, and nothing from further off.
    low_x, high_x, low_y, high_y = cell[0] - 1, cell[0] + 1, cell[1] - 1, cell[1] + 1
    while True:
        for x in range(low_x, high_x + 1):
            for y in range(low_y, high_y + 1):
                nearest, row = _intersect_cell(stand, number, (x, y), ray, nearest, row, normal)
        axis = 0 if next_t[0] < next_t[1] else 1
        if min(nearest, end) <= next_t[axis]:
            return nearest, row, normal
        cell[axis] += step[axis]
        next_t[axis] += delta[axis]
        low_x, high_x, low_y, high_y = cell[0] - 1, cell[0] + 1, cell[1] - 1, cell[1] + 1
        if axis == 0:
            low_x = high_x = cell[0] + step[0]
        else:
            low_y = high_y = cell[1] + step[1]


@njit(cache=True)
def _intersect_cell(stand, number, cell, ray, nearest, row, normal):  # type: ignore[no-untyped-def]
    """Distance and stick that a ray meets first among ``nearest``, ``row`` and a cell's objects.

    The normal there is written to ``normal``.
    """
    x, y = cell
    origin, v = ray.origin, ray.direction
    bits = lattice_bits(lattice_bits(_SEED, number, 0), x, y)
    for each in range(_poisson_count(stand, unit_float(bits))):
        px = (x + unit_float(lattice_bits(bits, each, 0))) * stand.cell
        py = (y + unit_float(lattice_bits(bits, each, 1))) * stand.cell
        u = unit_float(lattice_bits(bits, each, 2))
        which = min(np.searchsorted(stand.chance, u, side="right"), len(stand.reach) - 1)
        dx, dy = origin[0] - px, origin[1] - py
        begin, end = _cylinder_interval(dx, dy, v, stand.reach[which])
        lowest = origin[2] + (begin if v[2] > 0 else end) * v[2]
        if begin >= min(end, nearest) or lowest > stand.high[which]:
            continue
        turn = 2 * math.pi * unit_float(lattice_bits(bits, each, 3))
        cos, sin = math.cos(turn), math.sin(turn)
        own = cos * dx + sin * dy, cos * dy - sin * dx, origin[2]
        way = cos * v[0] + sin * v[1], cos * v[1] - sin * v[0], v[2]
        t, stick = intersect_ray(stand.grids, which, own, way, nearest)
        if stick >= 0:
            nearest, row = t, stick
            there = own[0] + t * way[0], own[1] + t * way[1], own[2] + t * way[2]
            a, b, normal[2] = normal_at(stand.grids.shapes[stick], there, way)
            normal[0], normal[1] = cos * a - sin * b, sin * a + cos * b
    return nearest, row


@njit(cache=True, inline="always")
def _cylinder_interval(dx, dy, v, reach):  # type: ignore[no-untyped-def]
    """Interval of a ray, begun (dx, dy) from a vertical axis, within reach of it.

    Its end is before its beginning if there is none.
    """
    across, along = v[0] * v[0] + v[1] * v[1], dx * v[0] + dy * v[1]
    apart = dx * dx + dy * dy - reach * reach
    if across == 0.0:
        return 0.0, math.inf if apart <= 0 else -1.0
    square = along * along - across * apart
    if square <= 0:
        return 0.0, -1.0
    root = math.sqrt(square)
    return max((-along - root) / across, 0.0), (root - along) / across


@njit(cache=True, inline="always")
def _poisson_count(stand, u):  # type: ignore[no-untyped-def]
    """Number of objects in a cell: the first n with u below the Poisson sum Σ mᵏ·exp(−m)/k!."""
    term, below, n = stand.none, stand.none, 0
    while u >= below and term > 0.0:
        n += 1
        term *= stand.mean / n
        below += term
    return n
