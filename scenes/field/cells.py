"""A Poisson process on an endless plane, drawn cell by cell from a counter-based hash (§4.1).

A frame visits only the cells from which a whole could pass its test.
"""

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals, expand
from lod.camera import Corner
from lod.errors import InputError
from lod.kernels import njit
from lod.view import View, compile_view, search_radius, sphere_in_frustum
from scenes.noise import hash_name, philox4x64, unit_float
from scenes.processes.cache import content_key, kept


class SearchBounds(NamedTuple):
    """Where wholes of a species can pass their tests in a view, whatever else is known of them.

    limit, limit_offscreen  (v,) greatest true distance of the eye from the origin of a whole of
            each prototype, in view and out of it [m]; bound (v,) its B [m]
    farthest, farthest_offscreen, widest  the greatest of each of them [m]
    horizontal  greatest distance in plan of a cell from the eye [m]
    max_offset  how far in plan that origin can be from the object's place in its cell [m]
    gap     how far the eye is above all origins, or below them [m]
    middle, spread  of the heights of origins, and how far those are from there, in plan too [m]
    half_window half the side of the world; inf = no edge [m]
    """

    limit: np.ndarray
    limit_offscreen: np.ndarray
    bound: np.ndarray
    farthest: float
    farthest_offscreen: float
    widest: float
    horizontal: float
    max_offset: float
    gap: float
    middle: float
    spread: float
    half_window: float


def search_bounds(
    view: View,
    limits: tuple[Reals, Reals],
    bound: Reals,
    max_offset: float,
    heights: tuple[float, float],
    extent: float | None,
) -> SearchBounds:
    """Find the bounds of a search for wholes with these limit distances and bounds.

    limits  (v,) D of each prototype's whole, in view and out of it [m]; bound (v,) its B [m]
    heights that the origin of a whole cannot be beyond [m]; extent: side of the world, None = no
            edge
    """
    (inside, outside), (low, high), eye_z = limits, heights, float(view.camera.eye[2])
    pairs = zip(inside.tolist(), bound.tolist(), strict=True)
    limit = np.array([search_radius(view, each, radius) for each, radius in pairs])
    widest = float(bound.max())
    farthest = search_radius(view, float(inside.max()), widest)
    gap = max(0.0, eye_z - high, low - eye_z)
    return SearchBounds(
        limit,
        outside,
        bound,
        farthest,
        float(outside.max()),
        widest,
        math.sqrt(max(farthest**2 - gap**2, 0.0)) + max_offset,
        max_offset,
        gap,
        (low + high) / 2,
        (high - low) / 2 + max_offset,
        math.inf if extent is None else extent / 2,
    )


@njit(cache=True)
def cell_in_reach(view, east, north, side, bounds):  # type: ignore[no-untyped-def]
    """Tell whether the cell about that middle may hold a displayed whole, in view or out of it."""
    aside_x = max(abs(east - view.eye[0]) - side / 2, 0.0)
    aside_y = max(abs(north - view.eye[1]) - side / 2, 0.0)
    near = math.sqrt(aside_x * aside_x + aside_y * aside_y)
    if near > bounds.horizontal:
        return False
    if view.look_around:
        return True
    away = _min_distance(near, bounds)
    if away > bounds.farthest:
        return False
    if not away > bounds.farthest_offscreen:
        return True
    radius = side / math.sqrt(2.0) + bounds.spread + bounds.widest
    return sphere_in_frustum(view, east, north, bounds.middle, radius)


@njit(cache=True, inline="always")
def _min_distance(horizontal, bounds):  # type: ignore[no-untyped-def]
    """Least true distance from the eye of an origin whose place is so far away in plan [m]."""
    nearer = max(horizontal - bounds.max_offset, 0.0)
    return math.sqrt(nearer * nearer + bounds.gap * bounds.gap)


@dataclass(frozen=True, eq=False)
class CellSamples(ArrayData):
    """Objects drawn from some cells, in the order of the cells.

    cell_x, cell_y, index  (n,) the object's identity: its cell in the species' lattice, and which
            of the cell's objects it is
    u       (n, 8) uniform numbers in [0, 1): place in the cell (x, y), heading, prototype; then
            phase of motion, which way round, stride, and the one that habitats compare
    """

    cell_x: IntArray
    cell_y: IntArray
    index: IntArray
    u: FloatArray

    def __len__(self) -> int:
        return len(self.index)

    def take(self, rows: np.ndarray) -> "CellSamples":
        """Select the objects at ``rows`` (indices or flags)."""
        if rows.dtype == bool:
            rows = np.flatnonzero(rows)
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


class SquareCells(ABC):
    """A process that is drawn in squares of side 2^j m, j being its ``exponent``."""

    density: float

    @property
    @abstractmethod
    def exponent(self) -> int: ...

    @property
    def side_m(self) -> float:
        """Return the side of a cell [m], a power of two."""
        return 2.0**self.exponent

    def lattice(self, corner: Corner) -> CellLattice:
        """Return the lattice of cells as seen from a frame's corner."""
        return CellLattice(*corner.lattice(self.side_m), self.side_m)

    @abstractmethod
    def sample(self, cell_x: Ints, cell_y: Ints) -> CellSamples:
        """Draw every object of the given cells: the same cell always holds the same objects."""

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


@dataclass(frozen=True)
class PoissonCells(SquareCells):
    """One species' homogeneous Poisson process of density K [1/m²]."""

    seed: int
    name: str
    density: float

    @property
    def exponent(self) -> int:
        """j: cells are squares of side 2^j m that hold about 2 objects, between half and twice."""
        j = round(0.5 * math.log2(2.0 / max(self.density, 1e-24)))
        return min(max(j, -3), 40)

    @property
    def key(self) -> tuple[np.uint64, np.uint64]:
        """Return the two words by which the process keys the hash: of its seed and its name."""
        return np.uint64(self.seed), hash_name(self.name)

    def sample(self, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        count = _counts(cell_x, cell_y, self.key, self._cumulative)
        row, index = expand(count)
        x, y = cell_x[row], cell_y[row]
        return CellSamples(x, y, index, uniforms(x, y, index, self.key))

    @cached_property
    def _cumulative(self) -> np.ndarray:
        mean = self.density * self.side_m**2

        def distribution() -> dict[str, np.ndarray]:
            from scipy.special import pdtr  # slow to import, and what it finds is kept

            return {
                "cumulative": pdtr(np.arange(math.ceil(mean + 12 * math.sqrt(mean) + 30)), mean)
            }

        return kept("cells", content_key(float(mean)), distribution)["cumulative"]


def candidates(
    cells: SquareCells, view: View, bounds: SearchBounds, visited: tuple[Ints, Ints] | None = None
) -> tuple[CellSamples, int]:
    """Draw the objects of a field that could be displayed, and count those in the window.

    visited: x and y of cells, (n,) each; None = those in reach. An object beyond every limit is
    rejected by its place and prototype alone.
    """
    cell_x, cell_y = cells_in_reach(cells, view, bounds) if visited is None else visited
    if not isinstance(cells, PoissonCells):  # the few that are drawn in vain fail their own tests
        samples = cells.sample(cell_x, cell_y)
        samples = samples.take(cells.in_window(samples, bounds.half_window))
        return samples, len(samples)
    count = _counts(cell_x, cell_y, cells.key, cells._cumulative)
    lattice, room = cells.lattice(view.camera.corner), int(count.sum())
    name, u = np.empty((3, room), np.int64), np.empty((room, 8))
    drawn = (cell_x, cell_y, count), cells.key, lattice
    kept, examined = _candidates(*drawn, compile_view(view), bounds, name, u)
    return CellSamples(name[0, :kept], name[1, :kept], name[2, :kept], u[:kept]), examined


@njit(cache=True)
def _counts(cell_x, cell_y, key, cumulative):  # type: ignore[no-untyped-def]
    count = np.empty(len(cell_x), np.int64)
    zero = np.uint64(0)
    for i in range(len(cell_x)):
        x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
        word, _, _, _ = philox4x64(x, y, zero, zero, *key)
        u, number = unit_float(word), 0
        while number < len(cumulative) and cumulative[number] <= u:
            number += 1  # about two steps: cells are that small
        count[i] = number
    return count


@njit(cache=True)
def uniforms(cell_x, cell_y, index, key):  # type: ignore[no-untyped-def]
    """Eight uniforms for each object; block 0 of a cell is spent on its count."""
    u = np.empty((len(index), 8))
    for i in range(len(index)):
        block = np.uint64(index[i] + 1)
        for half in range(2):
            x, y = np.uint64(cell_x[i]), np.uint64(cell_y[i])
            words = philox4x64(x, y, block, np.uint64(half), *key)
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
            words = philox4x64(x, y, block, np.uint64(0), *key)
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
            rest = philox4x64(x, y, block, one, *key)
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
    away = math.sqrt((east - view.eye[0]) ** 2 + (north - view.eye[1]) ** 2)
    away = _min_distance(away, bounds) * (1 - 1e-9)
    passed = away < bounds.limit[kind]
    if passed and not away < bounds.limit_offscreen[kind]:
        radius = (bounds.bound[kind] + bounds.spread) * (1 + 1e-9)
        passed = sphere_in_frustum(view, east, north, bounds.middle, radius)
    return passed


def cells_in_reach(
    cells: SquareCells, view: View, bounds: SearchBounds
) -> tuple[np.ndarray, np.ndarray]:
    """Find the cells that may hold a displayed whole, in view or not, row by row: x, y (n,)."""
    spans, lattice = search_spans(cells, view, bounds), cells.lattice(view.camera.corner)
    return _cells_in_reach(spans, lattice, compile_view(view), bounds)


def search_spans(cells: SquareCells, view: View, bounds: SearchBounds) -> tuple[int, int, int, int]:
    """Find ranges of cell numbers that hold all cells in reach: x from and before, then y.

    Raises InputError where nothing bounds the search.
    """
    side, lattice = cells.side_m, cells.lattice(view.camera.corner)
    reach, window = bounds.horizontal / side, bounds.half_window / side
    if math.isinf(reach) and math.isinf(window):
        rule, cure = "this metric needs a finite world", "-D world.extent=500"
        raise InputError("world.extent", None, rule, cure)
    east, north = view.camera.eye[:2].tolist()

    def span(first: int, eye: float) -> tuple[int, int]:
        lows, highs = [], []
        if math.isfinite(window):
            lows.append(math.floor(-window))
            highs.append(math.floor(window))
        if math.isfinite(reach):
            lows.append(first + math.floor(eye - reach))
            highs.append(first + math.floor(eye + reach))
        low, high = max(lows), min(highs)
        return (low, high + 1) if low <= high else (0, 0)

    x_range = span(lattice.cell_x, (east + lattice.rest_x) / side)
    return *x_range, *span(lattice.cell_y, (north + lattice.rest_y) / side)


@njit(cache=True)
def _cells_in_reach(spans, lattice, view, bounds):  # type: ignore[no-untyped-def]
    x0, x1, y0, y1 = spans
    side = lattice.side
    room = max(x1 - x0, 0) * max(y1 - y0, 0)
    cell_x, cell_y, n = np.empty(room, np.int64), np.empty(room, np.int64), 0
    for y in range(y0, y1):
        north = (y - lattice.cell_y + 0.5) * side - lattice.rest_y
        for x in range(x0, x1):
            east = (x - lattice.cell_x + 0.5) * side - lattice.rest_x
            if cell_in_reach(view, east, north, side, bounds):
                cell_x[n], cell_y[n] = x, y
                n += 1
    return cell_x[:n], cell_y[:n]
