"""How a fluted column is made: base, shaft and capital, each with finer parts of its own.

Level 0 is the whole column, one stick; 1 base, shaft and capital; 2 the rings of the base, the
flutes, the leaves of the capital; 3 the curls of the leaves. Sizes in metres, for a column of 6 m.
"""

from functools import lru_cache

import numpy as np

from lod.shapes import StickTable
from scenes.sticks.prototype import PartPlaces, Prototype, assemble_prototype

FLUTES, RINGS, LEAVES, CURLS = 20, 12, 16, 3
HEIGHT_M, RADIUS_M = 6.0, 0.43

_TINTS = np.array([[0.62, 0.6, 0.55], [0.2, 0.19, 0.18], [0.75, 0.68, 0.5]])
"""Stone, shade, gilding."""

Stick = tuple[float, ...]
Row = tuple[int, int, tuple[float, float, float], list[Stick], list[Stick]]
"""Whole, level, origin; sticks of the inner and of the leaf appearance: start, end, radius, tint"""


@lru_cache(maxsize=1)
def column() -> Prototype:
    """Make the prototype of the column, its foot at the origin."""
    rows: list[Row] = [(-1, 0, (0, 0, 0), [], [_axis_stick(0.45, 5.55, 0.45, 0)])]
    rows.append((0, 1, (0, 0, 0.25), [], [_axis_stick(0.25, 0.35, 0.5, 0)]))
    shaft, bell = _axis_stick(0.5, 5.2, 0.38, 1), _axis_stick(5.3, 5.6, 0.36, 1)
    rows.append((0, 1, (0, 0, 2.85), [shaft], [_axis_stick(0.5, 5.2, 0.42, 0)]))
    rows.append((0, 1, (0, 0, 5.5), [bell], [_axis_stick(5.4, 5.55, 0.45, 2)]))
    for k in range(RINGS):
        a, b = _ring_point(k, RINGS, 0.4, 0.2), _ring_point(k + 1, RINGS, 0.4, 0.2)
        rows.append((1, 2, a, [], [(*a, *b, 0.12, k % 2)]))
    for k in range(FLUTES):
        low, high = _ring_point(k, FLUTES, 0.385, 0.5), _ring_point(k, FLUTES, 0.385, 5.2)
        rows.append((2, 2, _ring_point(k, FLUTES, 0.385, 2.85), [], [(*low, *high, 0.045, 0)]))
    for k in range(LEAVES):
        low, high = _ring_point(k, LEAVES, 0.38, 5.3), _ring_point(k, LEAVES, 0.52, 5.75)
        leaf = (*low, *high, 0.06, 2)
        rows.append((3, 2, low, [leaf], [leaf]))
        for c in range(CURLS):
            at = _ring_point(k + (c - 1) / 3, LEAVES, 0.56, 5.78)
            end = _ring_point(k + (c - 1) / 3, LEAVES, 0.6, 5.7)
            rows.append((len(rows) - c - 1, 3, at, [], [(*at, *end, 0.03, c % 2)]))
    return _assemble(rows)


def _axis_stick(low: float, high: float, radius: float, tint: int) -> Stick:
    """A stick on the column's axis."""
    return (0.0, 0.0, low, 0.0, 0.0, high, radius, tint)


def _ring_point(k: float, count: int, radius: float, z: float) -> tuple[float, float, float]:
    """A point of a ring of ``count`` about the axis."""
    turn = 2 * np.pi * k / count
    return float(radius * np.cos(turn)), float(radius * np.sin(turn)), z


def _assemble(rows: list[Row]) -> Prototype:
    whole, level, origin, inner, leaf = zip(*rows, strict=True)
    columns = np.array(whole, np.int64), np.array(level, np.int64), np.array(origin, np.float64)
    places = PartPlaces(*columns)
    return assemble_prototype("column", places, _table(inner), _table(leaf), _TINTS)


def _table(looks: tuple[list[Stick], ...]) -> StickTable:
    owner = np.repeat(np.arange(len(looks)), [len(look) for look in looks])
    sticks = np.array([stick for look in looks for stick in look], np.float64).reshape(-1, 8)
    start, end, radius, tint = sticks[:, :3], sticks[:, 3:6], sticks[:, 6], sticks[:, 7]
    return StickTable.of(
        len(looks), owner, start, end, radius, radius.copy(), tint.astype(np.int64)
    )
