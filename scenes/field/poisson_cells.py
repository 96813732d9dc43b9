"""A Poisson process on an endless plane, drawn cell by cell from a counter-based hash (§4.1)."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import expand, freeze
from lod.camera import Corner
from lod.pruning.compiled_test import compile_view, sphere_in_frustum
from lod.pruning.view import View
from scenes.field.search_bounds import SearchBounds, min_distance
from scenes.noise.philox import hash_name, philox, unit_float
from scenes.processes.content_cache import kept
from scenes.processes.content_key import content_key

_MEAN_PER_CELL = 2.0
"""Cells are the squares of side 2^j m that hold about this many objects, between half and twice."""


_THINNEST = 1e-24
"""Below this density cells have their largest side [1/m²]."""


@dataclass(frozen=True, eq=False)
class CellSamples:
    """Objects drawn from some cells, in the order of the cells.

    cell_x, cell_y, index  (n,) the object's identity: its cell in the species' lattice, and which
            of the cell's objects it is
    u       (n, 8) uniform numbers in [0, 1): place in the cell (x, y), heading, prototype; then
            phase of motion, which way round, stride, and the one that habitats compare
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
        """Return the objects at ``rows`` (indices or flags)."""
        return CellSamples(self.cell_x[rows], self.cell_y[rows], self.index[rows], self.u[rows])


class CellLattice(NamedTuple):
    """A lattice of square cells as seen from a frame's corner.

    cell_x, cell_y  cell that the corner is in; rest_x, rest_y: how far it is into that cell [m]
    side            of a cell [m]
    """

    cell_x: int
    cell_y: int
    rest_x: float
    rest_y: float
    side: float


class ProcessKey(NamedTuple):
    """The two words by which a species' process keys the hash."""

    seed: np.uint64
    species: np.uint64


@dataclass(frozen=True)
class PoissonCells:
    """One species' homogeneous Poisson process of density K [1/m²]."""

    seed: int
    name: str
    density: float

    @property
    def exponent(self) -> int:
        """j: the cells are squares of side 2^j m."""
        j = round(0.5 * math.log2(_MEAN_PER_CELL / max(self.density, _THINNEST)))
        return min(max(j, -3), 40)

    @property
    def side_m(self) -> float:
        """Return the side of a cell [m], a power of two."""
        return 2.0**self.exponent

    @property
    def key(self) -> ProcessKey:
        """Return the key of the hash."""
        return ProcessKey(np.uint64(self.seed), hash_name(self.name))

    def lattice(self, corner: Corner) -> CellLattice:
        """Return the lattice of cells as seen from a frame's corner."""
        return CellLattice(*corner.lattice(self.side_m), self.side_m)

    def sample(self, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        """Draw every object of the given cells: the same cell always holds the same objects."""
        count = _counts(cell_x, cell_y, self.key, self._cumulative)
        row, index = expand(count)
        x, y = cell_x[row], cell_y[row]
        return CellSamples(x, y, index, _uniforms(x, y, index, self.key))

    def candidates(
        self, cell_x: np.ndarray, cell_y: np.ndarray, view: View, bounds: SearchBounds
    ) -> tuple[CellSamples, int]:
        """Draw the objects of cells that could be displayed, and count those in the window.

        An object beyond every limit is rejected by its place and prototype alone.
        """
        count = _counts(cell_x, cell_y, self.key, self._cumulative)
        cells, lattice = (cell_x, cell_y, count), self.lattice(view.camera.corner)
        room = int(count.sum())
        name, u = np.empty((3, room), np.int64), np.empty((room, 8))
        compiled = compile_view(view)
        kept, examined = _candidates(cells, self.key, lattice, compiled, bounds, name, u)
        return CellSamples(name[0, :kept], name[1, :kept], name[2, :kept], u[:kept]), examined

    def positions(self, corner: Corner, samples: CellSamples) -> Float64[np.ndarray, "n 2"]:
        """Compute the places of objects at home, (n, 2) [m] from the corner."""
        lattice = self.lattice(corner)
        side = lattice.side
        x = (samples.cell_x - lattice.cell_x) * side + samples.u[:, 0] * side - lattice.rest_x
        y = (samples.cell_y - lattice.cell_y) * side + samples.u[:, 1] * side - lattice.rest_y
        return np.stack((x, y), axis=1)

    def in_window(self, samples: CellSamples, half_window: float) -> np.ndarray:
        """Whether each object's place is in the square window of that half side about the origin
        [m], (n,): it depends on the object alone, never on the eye."""
        side = self.side_m
        x, y = (samples.cell_x + samples.u[:, 0]) * side, (samples.cell_y + samples.u[:, 1]) * side
        return (np.abs(x) <= half_window) & (np.abs(y) <= half_window)

    @cached_property
    def _cumulative(self) -> np.ndarray:
        """The Poisson distribution function of a cell's count, as far as it matters."""
        mean = self.density * self.side_m**2
        key = content_key(float(mean))
        return kept("cells", key, lambda: {"cumulative": _distribution(mean)})["cumulative"]


def _distribution(mean: float) -> np.ndarray:
    from scipy.special import pdtr  # dear to import, and what it finds is kept

    found: np.ndarray = pdtr(np.arange(math.ceil(mean + 12 * math.sqrt(mean) + 30)), mean)
    return found


@njit(cache=True)
def _counts(cell_x, cell_y, key, cumulative):  # type: ignore[no-untyped-def]
    """Objects in each cell, by inversion of the Poisson distribution function."""
    count = np.empty(len(cell_x), np.int64)
    zero = np.uint64(0)
    for i in range(len(cell_x)):
        x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
        word, _, _, _ = philox(x, y, zero, zero, key.seed, key.species)
        u, number = unit_float(word), 0
        while number < len(cumulative) and cumulative[number] <= u:
            number += 1  # about two steps: cells are that small
        count[i] = number
    return count


@njit(cache=True)
def _uniforms(cell_x, cell_y, index, key):  # type: ignore[no-untyped-def]
    """Eight uniforms for each object; block 0 of a cell is spent on its count."""
    u = np.empty((len(index), 8))
    for i in range(len(index)):
        block = np.uint64(index[i] + 1)
        for half in range(2):
            x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
            words = philox(x, y, block, np.uint64(half), key.seed, key.species)
            for k in range(4):
                u[i, 4 * half + k] = unit_float(words[k])
    return u


@njit(cache=True)
def _candidates(cells, key, lattice, view, bounds, name, u):  # type: ignore[no-untyped-def]
    """Identities (3, n) and uniforms (n, 8) of objects that could be displayed, into ``name`` and
    ``u``; how many there are, and how many objects are in the window.

    cells: x, y and number of objects of each, (c,)
    """
    cell_x, cell_y, count = cells
    side, half_window = lattice.side, bounds.half_window
    kinds, kept, examined, one = len(bounds.bound), 0, 0, np.uint64(1)
    for i in range(len(cell_x)):
        x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
        west = (cell_x[i] - lattice.cell_x) * side - lattice.rest_x
        south = (cell_y[i] - lattice.cell_y) * side - lattice.rest_y
        for index in range(count[i]):
            block = np.uint64(index + 1)
            words = philox(x, y, block, np.uint64(0), key.seed, key.species)
            u0, u1 = unit_float(words[0]), unit_float(words[1])
            if abs((cell_x[i] + u0) * side) > half_window:
                continue
            if abs((cell_y[i] + u1) * side) > half_window:
                continue
            examined += 1
            kind = int(unit_float(words[3]) * kinds)
            if not _could_pass(view, bounds, kind, west + u0 * side, south + u1 * side):
                continue
            name[0, kept], name[1, kept], name[2, kept] = cell_x[i], cell_y[i], index
            rest = philox(x, y, block, one, key.seed, key.species)
            for k in range(4):
                u[kept, k], u[kept, 4 + k] = unit_float(words[k]), unit_float(rest[k])
            kept += 1
    return kept, examined


@njit(cache=True, inline="always")
def _could_pass(view, bounds, kind, east, north):  # type: ignore[no-untyped-def]
    """Whether a whole of a prototype at that place could pass its test, whatever its height.

    Distances and radii have a billionth of room for rounding: what is kept in vain is rejected by
    the traversal.
    """
    gap = max(0.0, view.eye_z - bounds.high, bounds.low - view.eye_z)
    away = math.sqrt((east - view.eye_x) ** 2 + (north - view.eye_y) ** 2)
    away = min_distance(away, bounds.max_offset, gap) * (1 - 1e-9)
    passed = away < bounds.limit[kind]
    if passed and not away < bounds.limit_offscreen[kind]:
        spread = (bounds.high - bounds.low) / 2 + bounds.max_offset
        radius = (bounds.bound[kind] + spread) * (1 + 1e-9)
        middle = (bounds.low + bounds.high) / 2
        passed = sphere_in_frustum(view, east, north, middle, radius)
    return passed
