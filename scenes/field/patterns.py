"""Objects that do not stand as a Poisson process: in clusters, apart, or where a map has them.

Each is drawn cell by cell as ``PoissonCells`` is, so that the same cell always holds the same
objects and a field has no edge; the pruner is handed clustered objects as any others.
"""

import csv
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy import stats
from scipy.spatial import cKDTree

from lod.arrays import ArrayData, FloatArray, Ints, expand
from lod.errors import InputError
from scenes.field.cells import CellSamples, PoissonCells, SquareCells, uniforms

_FARTHEST = 5.0
"""Deviations σ beyond which a cluster has no objects: 4 in a million of a whole Gaussian."""

_OFFSPRING = 2**20  # more objects than a cluster ever has


@dataclass(frozen=True)
class ThomasCells(SquareCells):
    """One species' Thomas process: Gaussian clusters about the points of a Poisson process.

    density  of objects [1/m²]; parents: of clusters [1/m²]; sigma: deviation on either axis [m]
    """

    seed: int
    name: str
    density: float
    parents: float
    sigma: float

    @cached_property
    def middles(self) -> PoissonCells:
        """Return the process of the middles of clusters."""
        return PoissonCells(self.seed, f"{self.name} clusters", self.parents)

    @property
    def exponent(self) -> int:
        return self.middles.exponent

    def sample(self, cell_x: Ints, cell_y: Ints) -> CellSamples:
        side = self.side_m
        near = _grown(cell_x, cell_y, math.ceil(_FARTHEST * self.sigma / side))
        middles = self.middles.sample(*near)
        number = stats.poisson.ppf(middles.u[:, 2], self.density / self.parents).astype(np.int64)
        of, index = expand(number)
        x, y = middles.cell_x[of], middles.cell_y[of]
        key = PoissonCells(self.seed, self.name, self.density).key
        u = uniforms(x, y, middles.index[of] * _OFFSPRING + index, key)
        # Rayleigh's distribution, cut off where next to nothing is left.
        share = u[:, 0] * -math.expm1(-(_FARTHEST**2) / 2)
        away = self.sigma / side * np.sqrt(-2 * np.log1p(-share))
        angle = 2 * np.pi * u[:, 1]
        place = middles.u[of, :2] + away[:, None] * np.stack((np.cos(angle), np.sin(angle)), 1)
        step = np.floor(place)
        u[:, :2] = np.minimum(place - step, 1 - 2.0**-53)
        own_x, own_y = x + step[:, 0].astype(np.int64), y + step[:, 1].astype(np.int64)
        asked = np.flatnonzero(_among(own_x, own_y, cell_x, cell_y))
        keys = (index, middles.index[of], y, x, own_x, own_y)
        order = asked[np.lexsort([each[asked] for each in keys])]
        own_x, own_y = own_x[order], own_y[order]
        first = np.ones(len(order), bool)
        first[1:] = (np.diff(own_x) != 0) | (np.diff(own_y) != 0)
        _, rank = expand(np.diff(np.flatnonzero(first), append=len(order)))
        return CellSamples(own_x, own_y, rank, u[order])


@dataclass(frozen=True)
class MaternCells(SquareCells):
    """One species' second process of Matérn: of two that are nearer than ``core`` [m] one goes.

    density  of objects [1/m²], below 1/(π·core²), which raises InputError
    """

    seed: int
    name: str
    density: float
    core: float

    def __post_init__(self) -> None:
        if not 0 < self.density * math.pi * self.core**2 < 1:
            rule = f"below 1/(π·{self.core:g}²) objects per m², which is all that there is room for"
            raise InputError(f"species.{self.name}.density", self.density, rule)

    @cached_property
    def candidates(self) -> PoissonCells:
        """Return the Poisson process that is thinned."""
        disc = math.pi * self.core**2
        return PoissonCells(self.seed, self.name, -math.log1p(-self.density * disc) / disc)

    @property
    def exponent(self) -> int:
        return self.candidates.exponent

    def sample(self, cell_x: Ints, cell_y: Ints) -> CellSamples:
        side = self.side_m
        all_ = self.candidates.sample(*_grown(cell_x, cell_y, math.ceil(self.core / side)))
        if not len(all_):
            return all_
        key = PoissonCells(self.seed, f"{self.name} order", 1.0).key
        order = uniforms(all_.cell_x, all_.cell_y, all_.index, key)[:, 0]
        cells = np.stack((all_.cell_x, all_.cell_y), 1)
        places = cells - cells.min(axis=0) + all_.u[:, :2]
        pairs = cKDTree(places).query_pairs(self.core / side * (1 + 1e-9), output_type="ndarray")
        # Apart by whole cells and by shares: the same, wherever the search began.
        apart = np.diff(cells[pairs], axis=1)[:, 0] + np.diff(all_.u[pairs, :2], axis=1)[:, 0]
        pairs = pairs[np.square(apart).sum(axis=1) < (self.core / side) ** 2]
        gone = np.where(order[pairs[:, 0]] > order[pairs[:, 1]], pairs[:, 0], pairs[:, 1])
        kept = _among(all_.cell_x, all_.cell_y, cell_x, cell_y)
        kept[gone] = False
        return all_.take(kept)


@dataclass(frozen=True, eq=False)
class StemMap(ArrayData):
    """Places of real objects in a rectangle of ground, which is repeated without end.

    xy       (n, 2) from the rectangle's corner [m]
    period   sides of the rectangle [m]
    licence  what the file says that may be done with it
    """

    xy: FloatArray
    period: FloatArray
    licence: str

    @property
    def density(self) -> float:
        """Return the objects on a unit of ground [1/m²]."""
        return float(len(self.xy) / np.prod(self.period))


@dataclass(frozen=True, eq=False)
class MappedCells(SquareCells):
    """One species where a map has it, moved as a whole by a random vector of the seed."""

    seed: int
    name: str
    density: float
    stems: StemMap

    @property
    def exponent(self) -> int:
        return math.floor(math.log2(float(self.stems.period.min()) / 4))

    def sample(self, cell_x: Ints, cell_y: Ints) -> CellSamples:
        side, period = self.side_m, self.stems.period
        key = PoissonCells(self.seed, self.name, self.density).key
        zero = np.zeros(1, np.int64)
        moved = self.stems.xy + uniforms(zero, zero, zero, key)[0, :2] * period
        # A product with a power of two is exact, and so is the rest of a division of floats.
        corners = np.mod(cell_x * side, period[0]), np.mod(cell_y * side, period[1])
        into = [np.mod(moved[:, k] - corners[k][:, None], period[k]) / side for k in (0, 1)]
        cell, stem = np.nonzero((into[0] < 1) & (into[1] < 1))
        u = uniforms(cell_x[cell], cell_y[cell], stem, key)
        u[:, 0], u[:, 1] = into[0][cell, stem], into[1][cell, stem]
        return CellSamples(cell_x[cell], cell_y[cell], stem, u)


def read_stems(path: Path) -> StemMap:
    """Read a map of stems: lines ``x,y`` [m] after lines ``# window: …`` and ``# licence: …``.

    The window is its least x, greatest x, least y and greatest y; a line of heads is passed over.
    Raises InputError for a file that cannot be read, says no licence, or holds anything else.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError("stems", str(path), "a text file that can be read", str(error)) from None
    said = dict(
        line.lstrip("# ").split(":", 1) for line in lines if line[:1] == "#" and ":" in line
    )
    rows = list(csv.reader(line for line in lines if line.strip() and not line.startswith("#")))
    licence = said.get("licence", "").strip()
    if not licence:
        rule = "says what may be done with it"
        raise InputError(f"stems {path}", "no licence", rule, "add a line '# licence: …'")
    try:
        low_x, high_x, low_y, high_y = map(float, said.get("window", "").replace(",", " ").split())
        xy = np.array([row[:2] for row in rows[not _is_number(rows[0][0]) :]], np.float64)
        xy = xy.reshape(-1, 2) - (low_x, low_y)
    except (ValueError, IndexError) as error:
        rule = "numbers x,y [m] in each line, and one line '# window: x0 x1 y0 y1'"
        raise InputError(f"stems {path}", str(error), rule) from None
    period = np.array((high_x - low_x, high_y - low_y))
    inside = bool(((xy >= 0) & (xy <= period)).all()) and np.isfinite(period).all()
    if len(xy) < 2 or not inside or not (period > 0).all():
        raise InputError(f"stems {path}", f"{len(xy)} stems", "two or more, all in the window")
    return StemMap(xy, period, licence)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _grown(cell_x: np.ndarray, cell_y: np.ndarray, by: int) -> tuple[np.ndarray, np.ndarray]:
    """Return these cells and all that are within so many of them, each once, row by row."""
    if not len(cell_x):
        return cell_x, cell_y
    low_x, low_y = cell_x.min() - by, cell_y.min() - by
    room = np.zeros((cell_y.max() - low_y + by + 1, cell_x.max() - low_x + by + 1), bool)
    for east in range(2 * by + 1):
        for north in range(2 * by + 1):
            room[cell_y - low_y - by + north, cell_x - low_x - by + east] = True
    y, x = np.nonzero(room)
    return x + low_x, y + low_y


def _among(x: np.ndarray, y: np.ndarray, cell_x: np.ndarray, cell_y: np.ndarray) -> np.ndarray:
    if not len(x) or not len(cell_x):
        return np.zeros(len(x), bool)
    low_x, low_y = min(x.min(), cell_x.min()), min(y.min(), cell_y.min())
    wide = max(x.max(), cell_x.max()) - low_x + 1
    numbers = [(v - low_y) * wide + u - low_x for u, v in ((x, y), (cell_x, cell_y))]
    return np.isin(*numbers)
