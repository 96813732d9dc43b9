"""A Poisson process on an endless plane, drawn cell by cell from a counter-based hash (§4.1)."""

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from scipy.stats import poisson

from lod.arrays import freeze
from scenes.random import philox, unit, word_of

_MEAN_PER_CELL = 2.0
"""Cells are the squares of side 2^j m that hold about this many objects, between half and twice."""


@dataclass(frozen=True, eq=False)
class Draws:
    """Objects drawn from some cells, in the order of the cells.

    cell_x, cell_y, index  (n,) the object's identity: its cell in the species' lattice, and which
            of the cell's objects it is
    u       (n, 8) uniform numbers in [0, 1): place in the cell (x, y), heading, prototype; then
            phase of motion, which way round, stride, and one to spare
    """

    cell_x: np.ndarray
    cell_y: np.ndarray
    index: np.ndarray
    u: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, cell_x=np.int64, cell_y=np.int64, index=np.int64, u=np.float64)

    def __len__(self) -> int:
        return len(self.index)

    def take(self, rows: np.ndarray) -> "Draws":
        """The objects at ``rows``."""
        return Draws(self.cell_x[rows], self.cell_y[rows], self.index[rows], self.u[rows])


@dataclass(frozen=True)
class PoissonCells:
    """One species' homogeneous Poisson process of density K [1/m²]."""

    seed: int
    name: str
    density: float

    @property
    def exponent(self) -> int:
        """j: the cells are squares of side 2^j m."""
        j = round(0.5 * math.log2(_MEAN_PER_CELL / self.density))
        return min(max(j, -3), 40)

    @property
    def side_m(self) -> float:
        """Side of a cell [m], a power of two."""
        return 2.0**self.exponent

    def draw(self, cell_x: np.ndarray, cell_y: np.ndarray) -> Draws:
        """Every object of the given cells: the same cell always holds the same objects."""
        mean = self.density * self.side_m**2
        cumulative = poisson.cdf(np.arange(math.ceil(mean + 12 * math.sqrt(mean) + 30)), mean)
        key = np.uint64(self.seed), word_of(self.name)
        count = _counts(cell_x, cell_y, *key, cumulative)
        row = np.repeat(np.arange(len(count)), count)
        index = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        x, y = cell_x[row], cell_y[row]
        return Draws(x, y, index, _uniforms(x, y, index, *key))


@njit(cache=True)
def _counts(cell_x, cell_y, seed, species, cumulative):  # type: ignore[no-untyped-def]
    """Objects in each cell, by inversion of the Poisson distribution function."""
    count = np.empty(len(cell_x), np.int64)
    zero = np.uint64(0)
    for i in range(len(cell_x)):
        word, _, _, _ = philox(
            np.uint64(cell_x[i]), np.uint64(cell_y[i]), zero, zero, seed, species
        )
        count[i] = np.searchsorted(cumulative, unit(word), side="right")
    return count


@njit(cache=True)
def _uniforms(cell_x, cell_y, index, seed, species):  # type: ignore[no-untyped-def]
    """Eight uniforms for each object; block 0 of a cell is spent on its count."""
    u = np.empty((len(index), 8))
    for i in range(len(index)):
        block = np.uint64(index[i] + 1)
        for half in range(2):
            x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
            words = philox(x, y, block, np.uint64(half), seed, species)
            for k in range(4):
                u[i, 4 * half + k] = unit(words[k])
    return u
