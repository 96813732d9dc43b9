"""Patches of ground to be drawn, and which of their sides meet coarser patches.

A patch is a quarter of a tile. Patches form a linear quadtree: sorted by Morton code, each covers
an interval of codes (Gargantini 1982, "An effective way to represent quadtrees"). Where neighbours
differ too much the coarser patch is split (restricted quadtrees: Von Herzen & Barr 1987, "Accurate
triangulations of deformed, intersecting surfaces").
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64

from lod.arrays import Ints, freeze

SIDES = ((0, -1), (1, 0), (0, 1), (-1, 0))
"""Steps to the neighbour across each side: south, east, north, west."""

QUARTERS = np.array(((0, 0), (1, 0), (0, 1), (1, 1)))
"""Places of the quarters of a square, counted in their own sides."""


Squares = tuple[Int64[np.ndarray, " q"], Int64[np.ndarray, " q"], Int64[np.ndarray, " q"]]
"""Level, x and y of squares of a quadtree, x and y counted in their own sides."""


@dataclass(frozen=True, eq=False)
class Patches:
    """Disjoint squares of a quadtree, in order of their Morton codes.

    depth (n,)  halvings from a root tile's side
    x, y (n,)   place, in sides of the patch itself
    owner (n,)  row of the tile that draws the patch
    deepest     depth of the squares that codes number
    """

    depth: np.ndarray
    x: np.ndarray
    y: np.ndarray
    owner: np.ndarray
    deepest: int

    def __post_init__(self) -> None:
        order = np.argsort(self.code(self.x, self.y), kind="stable")
        for name in ("depth", "x", "y", "owner"):
            object.__setattr__(self, name, getattr(self, name)[order])
        freeze(self, depth=np.int64, x=np.int64, y=np.int64, owner=np.int64)

    def __len__(self) -> int:
        return len(self.depth)

    def code(self, x: Ints, y: Ints) -> Ints:
        """Morton codes, at the deepest level, of squares (x, y) of the patches' own sizes."""
        fine = self.deepest - self.depth
        return morton(x << fine, y << fine)


def morton(x: Ints, y: Ints) -> Ints:
    """Morton codes: the bits of x and y in turns, x lowest (Morton 1966)."""
    return _spread(x) | (_spread(y) << 1)


def _spread(v: Ints) -> Ints:
    """Put a zero bit between the bits of each number."""
    for shift, mask in (
        (16, 0x0000FFFF0000FFFF),
        (8, 0x00FF00FF00FF00FF),
        (4, 0x0F0F0F0F0F0F0F0F),
        (2, 0x3333333333333333),
        (1, 0x5555555555555555),
    ):
        v = (v | (v << shift)) & mask
    return v


def uncovered_quarters(level: Ints, x: Ints, y: Ints) -> Patches:
    """Patches of the displayed tiles: every quarter of a tile that no displayed tile covers."""
    squares = quarters(level, x, y)
    free = ~np.isin(_name(*squares), _name(level, x, y))
    owner = np.repeat(np.arange(len(level)), 4)
    depth, x, y = (column[free] for column in squares)
    return Patches(depth, x, y, owner[free], int(level.max()) + 1)


def quarters(level: Ints, x: Ints, y: Ints) -> Squares:
    """Level, x and y of the four quarters of each square, four rows for each."""
    quarter_x, quarter_y = 2 * x[:, None] + QUARTERS[:, 0], 2 * y[:, None] + QUARTERS[:, 1]
    return np.repeat(level + 1, 4), quarter_x.ravel(), quarter_y.ravel()


def _name(level: Ints, x: Ints, y: Ints) -> Ints:
    """Number of each square among those of all levels."""
    return (morton(x, y) << 6) | level


def balance(patches: Patches, most: int) -> tuple[Patches, Int64[np.ndarray, "n 4"]]:
    """Patches split until neighbours differ by at most ``most`` halvings, and by how many they do.

    The second result (n, 4) is how many halvings coarser the neighbour across each of SIDES is, at
    least 0.
    """
    while True:
        neighbour, coarser = _neighbours(patches)
        split = np.unique(neighbour[coarser > most])
        if not len(split):
            return patches, coarser
        patches = _split(patches, split)


def _neighbours(patches: Patches) -> tuple[Int64[np.ndarray, "n 4"], Int64[np.ndarray, "n 4"]]:
    """Row of the neighbour across each of SIDES, and how many halvings coarser it is, (n, 4)."""
    first = patches.code(patches.x, patches.y)
    beyond = first + (np.int64(1) << (2 * (patches.deepest - patches.depth)))
    rows, coarser = (np.zeros((len(patches), 4), np.int64) for _ in range(2))
    for side, (dx, dy) in enumerate(SIDES):
        x, y = patches.x + dx, patches.y + dy
        inside = (x >= 0) & (y >= 0)
        code = patches.code(np.maximum(x, 0), np.maximum(y, 0))
        row = np.maximum(np.searchsorted(first, code, side="right") - 1, 0)
        inside &= (first[row] <= code) & (code < beyond[row])
        rows[:, side] = row
        coarser[:, side] = np.where(inside, np.maximum(patches.depth - patches.depth[row], 0), 0)
    return rows, coarser


def _split(patches: Patches, rows: Ints) -> Patches:
    """Patches with those of ``rows`` replaced by their quarters."""
    kept = np.ones(len(patches), bool)
    kept[rows] = False

    def joined(old: np.ndarray, new: np.ndarray) -> np.ndarray:
        return np.concatenate((old[kept], new))

    depth, x, y = quarters(patches.depth[rows], patches.x[rows], patches.y[rows])
    owner = np.repeat(patches.owner[rows], 4)
    return Patches(
        joined(patches.depth, depth),
        joined(patches.x, x),
        joined(patches.y, y),
        joined(patches.owner, owner),
        patches.deepest,
    )
