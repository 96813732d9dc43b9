"""A Poisson process on an endless plane, drawn cell by cell from a counter-based hash (§4.1)."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.stats import poisson

from lod.arrays import freeze
from lod.camera import Corner
from lod.pruning.compiled_test import CompiledView, sphere_in_frustum
from scenes.noise.philox import hash_name, philox, unit_float

_MEAN_PER_CELL = 2.0
"""Cells are the squares of side 2^j m that hold about this many objects, between half and twice."""


@dataclass(frozen=True, eq=False)
class CellSamples:
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

    def take(self, rows: np.ndarray) -> "CellSamples":
        """The objects at ``rows``."""
        return CellSamples(self.cell_x[rows], self.cell_y[rows], self.index[rows], self.u[rows])


class SearchBounds(NamedTuple):
    """Where objects can be displayed at all.

    farthest, farthest_offscreen  (v,) limit of the distance from the eye to the origin of each
            prototype's whole, in view and out of it [m]; bound (v,) its B [m]
    lean    how far in plan that origin can be from the object's place in its cell [m]
    low, high   heights that it cannot be beyond [m]
    window  half the side of the world; inf = no edge [m]
    """

    farthest: np.ndarray
    farthest_offscreen: np.ndarray
    bound: np.ndarray
    lean: float
    low: float
    high: float
    window: float


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

    def draw(self, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        """Every object of the given cells: the same cell always holds the same objects."""
        key = np.uint64(self.seed), hash_name(self.name)
        count = _counts(cell_x, cell_y, *key, self._cumulative)
        row = np.repeat(np.arange(len(count)), count)
        index = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
        x, y = cell_x[row], cell_y[row]
        return CellSamples(x, y, index, _uniforms(x, y, index, *key))

    def candidates(
        self,
        cell_x: np.ndarray,
        cell_y: np.ndarray,
        corner: Corner,
        vantage: CompiledView,
        near: SearchBounds,
    ) -> tuple[CellSamples, int]:
        """The objects of the given cells that could be displayed, and how many are in the window.

        What is beyond every limit is turned away by its place and prototype alone.
        """
        key = np.uint64(self.seed), hash_name(self.name)
        count = _counts(cell_x, cell_y, *key, self._cumulative)
        lattice = (*corner.lattice(self.exponent), self.side_m)
        room = int(count.sum())
        name, u = np.empty((3, room), np.int64), np.empty((room, 8))
        kept, examined = _near(cell_x, cell_y, count, *key, lattice, vantage, near, name, u)
        return CellSamples(name[0, :kept], name[1, :kept], name[2, :kept], u[:kept]), examined

    @cached_property
    def _cumulative(self) -> np.ndarray:
        """The Poisson distribution function of a cell's count, as far as it matters."""
        mean = self.density * self.side_m**2
        return poisson.cdf(np.arange(math.ceil(mean + 12 * math.sqrt(mean) + 30)), mean)


@njit(cache=True)
def cells_near(spans, lattice, vantage, rules):  # type: ignore[no-untyped-def]
    """Cells near enough, in view or out of it, to hold a displayed whole, row by row: x, y (n,).

    spans    first x and the one after the last, then y: cells that may be near enough
    lattice  the frame's corner in cells, how far into its cell it is [m], and their side [m]
    rules    limits in plan, in view and out of it; lean, height of the eye above all wholes;
             middle of their heights, and radius of all that a cell holds [m]
    """
    x0, x1, y0, y1 = spans
    ix, iy, rest_x, rest_y, side = lattice
    room = max(x1 - x0, 0) * max(y1 - y0, 0)
    cell_x, cell_y, n = np.empty(room, np.int64), np.empty(room, np.int64), 0
    for y in range(y0, y1):
        north = (y - iy + 0.5) * side - rest_y
        for x in range(x0, x1):
            east = (x - ix + 0.5) * side - rest_x
            if near_enough(vantage, east, north, side, rules):
                cell_x[n], cell_y[n] = x, y
                n += 1
    return cell_x[:n], cell_y[:n]


@njit(cache=True)
def near_enough(vantage, east, north, side, rules):  # type: ignore[no-untyped-def]
    """Whether the cell about that middle is one of ``cells_near``."""
    in_plan, inside, outside, lean, above, middle, radius = rules
    near = away_in_plan(vantage, east, north, side)
    if near > in_plan:
        return False
    if vantage.look_around:
        return True
    far = away_at_least(near, lean, above)
    return not far > inside and (
        not far > outside or sphere_in_frustum(vantage, east, north, middle, radius)
    )


@njit(cache=True)
def away_in_plan(vantage, east, north, side):  # type: ignore[no-untyped-def]
    """How far the cell about that middle is from the eye, in plan [m]."""
    aside_x = max(abs(east - vantage.eye_x) - side / 2, 0.0)
    aside_y = max(abs(north - vantage.eye_y) - side / 2, 0.0)
    return math.sqrt(aside_x * aside_x + aside_y * aside_y)


@njit(cache=True, inline="always")
def away_at_least(in_plan, lean, above):  # type: ignore[no-untyped-def]
    """How far from the eye anything is that may be ``lean`` nearer in plan, and is ``above`` higher
    or lower at least [m].
    """
    nearer = max(in_plan - lean, 0.0)
    return math.sqrt(nearer * nearer + above * above)


@njit(cache=True)
def _counts(cell_x, cell_y, seed, species, cumulative):  # type: ignore[no-untyped-def]
    """Objects in each cell, by inversion of the Poisson distribution function."""
    count = np.empty(len(cell_x), np.int64)
    zero = np.uint64(0)
    for i in range(len(cell_x)):
        word, _, _, _ = philox(
            np.uint64(cell_x[i]), np.uint64(cell_y[i]), zero, zero, seed, species
        )
        u, number = unit_float(word), 0
        while number < len(cumulative) and cumulative[number] <= u:
            number += 1  # about two steps: cells are that small
        count[i] = number
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
                u[i, 4 * half + k] = unit_float(words[k])
    return u


@njit(cache=True)
def _near(cell_x, cell_y, count, seed, species, lattice, vantage, near, name, u):  # type: ignore[no-untyped-def]
    """Names and uniforms of objects that pass in plan; how many, and how many are in the window."""
    ix, iy, rest_x, rest_y, side = lattice
    above = max(0.0, vantage.eye_z - near.high, near.low - vantage.eye_z)
    middle, spread = (near.low + near.high) / 2, (near.high - near.low) / 2 + near.lean
    kinds, kept, examined, one = len(near.bound), 0, 0, np.uint64(1)
    for i in range(len(cell_x)):
        x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
        west, south = (cell_x[i] - ix) * side - rest_x, (cell_y[i] - iy) * side - rest_y
        for index in range(count[i]):
            block = np.uint64(index + 1)
            words = philox(x, y, block, np.uint64(0), seed, species)
            u0, u1 = unit_float(words[0]), unit_float(words[1])
            if abs((cell_x[i] + u0) * side) > near.window:
                continue
            if abs((cell_y[i] + u1) * side) > near.window:
                continue
            examined += 1
            kind, east, north = (
                int(unit_float(words[3]) * kinds),
                west + u0 * side,
                south + u1 * side,
            )
            away = math.sqrt((east - vantage.eye_x) ** 2 + (north - vantage.eye_y) ** 2)
            # A billionth for rounding: what is kept in vain is turned away by the walk.
            away = away_at_least(away, near.lean, above) * (1 - 1e-9)
            inside, outside = near.farthest[kind], near.farthest_offscreen[kind]
            reach = (near.bound[kind] + spread) * (1 + 1e-9)
            passed = away < inside
            if passed and not away < outside:
                passed = sphere_in_frustum(vantage, east, north, middle, reach)
            if not passed:
                continue
            name[0, kept], name[1, kept], name[2, kept] = cell_x[i], cell_y[i], index
            rest = philox(x, y, block, one, seed, species)
            for k in range(4):
                u[kept, k], u[kept, 4 + k] = unit_float(words[k]), unit_float(rest[k])
            kept += 1
    return kept, examined
