"""The ground as an ordinary representation: fractal relief, finer where it is nearer.

Parts are the tiles of a quadtree over the plane; refining a tile into its four quarters halves its
spacing s and adds the relief of wavelength 2s. ``scenes.ground.quadtree`` defines P and R, and

    d  to the nearest point of the tile's box
    B  half the box's diagonal on the map + half its height: spheres about its centre that nest

Tiles that nearer ground hides, and those whose box is outside the picture, are as coarse as what is
out of view, and coarser still where their shadow is outside as well (``scenes.ground.quadtree``).
Root tiles have no limit: the ground itself is never dropped, only its refinement. The Earth is flat
here.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals, frozen
from lod.camera import Corner
from lod.errors import InputError
from lod.pruner import BlendWeights, Parts
from lod.shapes import Triangles
from lod.view import View
from scenes.ground.mesh import EMPTY_MESH, MOST_COARSER, QUADS, ground_mesh, lattice_mesh
from scenes.ground.quadtree import (
    Horizon,
    Squares,
    balance,
    below_horizon,
    horizon,
    limits,
    outside_picture,
    quarters,
    uncovered_quarters,
)
from scenes.ground.relief import Relief
from scenes.ground.shading import GROUND_MATERIALS, AggregateCover, GroundInView

SAMPLES = 4
"""Points along each side of a tile at which its heights are sampled to bound them."""

MOST_TILES = 240_000
"""Largest number of tiles examined on one level; more would make tens of millions of triangles."""


@dataclass(frozen=True)
class TileGrid:
    """Where a view's tiles are: root (0, 0) has its south-west corner at (west, south) [m].

    limits   limit distances of the tiles of each level: in view, hidden, out of view, and out of
             view with their shadows [m]
    horizon  what hides tiles; None: nothing does
    """

    view: View
    root_side: float
    west: float
    south: float
    limits: tuple[Reals, Reals, Reals, Reals]
    horizon: Horizon | None


@dataclass(frozen=True)
class Terrain:
    """Ground out to ``reach`` [m] from the eye.

    amplitude, wavelength, hurst, ridged   of the relief (scenes.ground.relief)
    finest   spacing of the finest mesh [m], a power of two
    cover    what lies on it, one of GROUND_MATERIALS
    aggregate_cover   what undisplayed objects leave on it; None: nothing
    to_sun   unit vector to the sun (3,), for facets too small to be drawn; None: no sun
    """

    seed: int
    amplitude: float
    wavelength: float
    hurst: float
    reach: float
    finest: float = 0.125
    ridged: bool = False
    cover: str = "grassy"
    name: str = "terrain"
    aggregate_cover: AggregateCover | None = None
    to_sun: tuple[float, float, float] | None = None

    @cached_property
    def relief(self) -> Relief:
        """The shape of the ground."""
        return Relief(self.seed, self.amplitude, self.wavelength, self.hurst, self.ridged)

    def height(self, corner: Corner, xy: Float64[np.ndarray, "n 2"]) -> Reals:
        """Height of the full relief above the datum at points ``xy`` from ``corner`` [m]."""
        return self.relief.height(corner, xy)

    def bounds(self) -> tuple[float, float]:
        """Heights that no point of the ground is beyond [m]."""
        return self.relief.bounds()

    @property
    def root_exponent(self) -> int:
        """log₂ of a root tile's side in metres: between a quarter and a half of the reach."""
        return math.floor(math.log2(self.reach / 2))

    @cached_property
    def spacings(self) -> Reals:
        """Spacing of the mesh of a tile of each level [m]."""
        coarsest = self.root_exponent - round(math.log2(2 * QUADS))
        finest = min(round(math.log2(self.finest)), coarsest)
        return frozen(2.0 ** np.arange(coarsest, finest - 1, -1), np.float64)

    def roots(self, view: View) -> Parts:
        """The root tiles that the disc of radius ``reach`` about the eye touches."""
        corner, eye = view.camera.corner, view.camera.eye
        side = 2.0**self.root_exponent
        inset = np.array(corner.lattice(side)[2:])
        first, last = (np.floor((eye[:2] + inset + s * self.reach) / side) for s in (-1, 1))
        x, y = (g.ravel() for g in np.indices((last - first + 1).astype(np.int64)))
        southwest = first * side - inset
        corners = southwest + side * np.stack((x, y), axis=1)
        away = np.clip(eye[:2], corners, corners + side) - eye[:2]
        near = np.hypot(away[:, 0], away[:, 1]) <= self.reach
        x, y, zero = x[near], y[near], np.zeros(np.count_nonzero(near), np.int64)
        (west, south), limits = southwest.tolist(), self.limits(view)
        over = horizon(self.relief, view, self.reach)
        grid = TileGrid(view, side, west, south, limits, over)
        low, high = (np.full(len(x), bound) for bound in self.bounds())
        hidden, rows = np.zeros(len(x), bool), np.arange(len(x))
        return self._tiles(view, grid, (zero, x, y), rows, zero - 1, low, high, hidden)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The four quarters of each tile. Raises InputError when memory would not hold them."""
        rows = np.flatnonzero(parts.level < len(self.spacings) - 1)
        if 4 * len(rows) > MOST_TILES:
            rule = f"the ground of a view has at most {MOST_TILES} tiles a level"
            raise InputError("detail", view.detail, rule, "raise --detail or lower --size")
        tiles = quarters(parts.level[rows], *tile_xy(parts.part[rows]))
        parent = np.repeat(rows, 4)
        z = parts.centre[parent, 2]
        half = parts.bound[parent] - _flat_bound(parts.state, parts.level[parent])
        hidden = parts.limit[parent] < parts.state.limits[0][parts.level[parent]]
        roots = parts.object[parent]
        return self._tiles(view, parts.state, tiles, roots, parent, z - half, z + half, hidden)

    def _tiles(
        self,
        view: View,
        grid: TileGrid,
        tiles: Squares,
        root: Ints,
        parent: Ints,
        lowest: Reals,
        highest: Reals,
        hidden: np.ndarray,
    ) -> Parts:
        """Tiles (level, x, y) as parts, (n,) each.

        lowest, highest (n,)  heights between which the ground of each tile's whole lies [m]
        hidden (n,)           whether the whole is hidden; tiles of others may be hidden, too
        """
        level, x, y = tiles
        low, high, top = self.boxes(grid, tiles, lowest, highest)
        likely = np.column_stack(
            (high[:, :2], top + (self.aggregate_cover.highest if self.aggregate_cover else 0.0))
        )
        unlit = outside_picture(view, low, likely, self._shadow(likely))
        hidden = hidden | outside_picture(view, low, likely)
        if grid.horizon is not None:
            rows = np.flatnonzero(~hidden)
            eye = view.camera.eye
            hidden[rows] = below_horizon(low[rows], likely[rows], eye, grid.horizon)
        inside, behind, outside, dim = (row[level] for row in grid.limits)
        return Parts(
            position=_nearest(view, low, high),
            centre=(low + high) / 2,
            bound=_flat_bound(grid, level) + (high - low)[:, 2] / 2,
            limit=np.where(unlit, dim, np.where(hidden, behind, inside)),
            limit_offscreen=np.where(unlit, dim, outside),
            level=level,
            object=root,
            part=(x << 32) | y,
            parent=parent,
            share=np.where(parent < 0, 1.0, 0.25),
            state=grid,
        )

    def boxes(
        self, grid: TileGrid, tiles: Squares, lowest: Reals, highest: Reals
    ) -> tuple[Points, Points, Reals]:
        """Lowest and highest corners of boxes that hold the tiles, and likely tops of their ground.

        Boxes (n, 3) each lie within their wholes'; the ground rarely exceeds the tops, (n,) [m].
        Heights come from SAMPLES² points of a tile and from how far the ground can differ from
        them within the circles about them.
        """
        level, x, y = tiles
        side = grid.root_side / 2.0**level
        west, south = grid.west + side * x, grid.south + side * y
        xy, radius = height_samples(west, south, side)
        low, high = self.relief.height_bounds(grid.view.camera.corner, xy, radius)
        low, high = low.reshape(-1, SAMPLES**2), high.reshape(-1, SAMPLES**2)
        middle = (low + high).max(axis=1) / 2
        low = np.maximum(lowest, low.min(axis=1))
        high = np.minimum(highest, high.max(axis=1))
        top = np.minimum(high, middle + self.relief.likely_rise_within(radius[:: SAMPLES**2]))
        east, north = west + side, south + side
        return np.stack((west, south, low), axis=1), np.stack((east, north, high), axis=1), top

    def _shadow(self, high: Points) -> Points:
        """Way from points to their shadows on the lowest ground that is likely, (n, 3) [m].

        It is no longer than the ground is wide.
        """
        if self.to_sun is None:
            return np.zeros_like(high)
        lowest = -self.relief.likely_below(np.array([math.inf]))
        length = (high[:, 2] - lowest) / max(self.to_sun[2], 1e-9)
        return -np.clip(length, 0.0, 2 * self.reach)[:, None] * np.array(self.to_sun)

    def limits(self, view: View) -> tuple[Reals, Reals, Reals, Reals]:
        """Limit distances of the tiles of each level (``quadtree.limits``), (l,) each [m]."""
        return limits(self.relief, self.spacings, view)

    def triangle_count(self, parts: Parts) -> int:
        """Count the triangles of the mesh of all tiles, which is not made."""
        if not len(parts):
            return 0
        patches = uncovered_quarters(parts.level, *tile_xy(parts.part))
        _, faces, _ = lattice_mesh(*balance(patches, MOST_COARSER))
        return len(faces)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Triangles:
        """One watertight mesh of all tiles, each at its own spacing.

        Where only some quarters of a tile are displayed, the tile itself draws the others. Ground
        has no leaf appearance to blend with: it morphs (``scenes.ground.mesh``).
        """
        if not len(parts):
            return EMPTY_MESH
        grid: TileGrid = parts.state
        patches = uncovered_quarters(parts.level, *tile_xy(parts.part))
        ground = GroundInView(
            grid.view,
            self.relief,
            self.spacings,
            grid.limits[0],
            GROUND_MATERIALS[self.cover],
            self.aggregate_cover,
            np.zeros(3) if self.to_sun is None else np.array(self.to_sun),
        )
        unit = grid.root_side / 2.0**patches.deepest / QUADS
        return ground_mesh(ground, patches, (grid.west, grid.south), unit)


def _flat_bound(grid: TileGrid, level: Ints) -> Reals:
    """Half the diagonal of tiles, plus a millionth: spheres nest despite rounding [m]."""
    return grid.root_side / 2.0**level * math.sqrt(0.5) * (1 + 1e-6)


def height_samples(
    west: Reals, south: Reals, side: Reals
) -> tuple[Float64[np.ndarray, "s 2"], Float64[np.ndarray, " s"]]:
    """SAMPLES² points of each square, and the radii of circles about them that cover it [m]."""
    step = (np.indices((SAMPLES, SAMPLES)).reshape(2, -1) + 0.5) / SAMPLES
    x, y = (v[:, None] + side[:, None] * s for v, s in zip((west, south), step, strict=True))
    radius = np.repeat(side * math.sqrt(0.5) / SAMPLES, SAMPLES**2)
    return np.stack((x.ravel(), y.ravel()), axis=1), radius


def tile_xy(part: Ints) -> tuple[Ints, Ints]:
    """Column and row of tiles by their numbers, counted in their own sides from root (0, 0)."""
    return part >> 32, part & 0xFFFFFFFF


def _nearest(view: View, low: Points, high: Points) -> Points:
    if view.metric.along_axis:
        return np.where(view.camera.forward >= 0, low, high)
    return np.clip(view.camera.eye, low, high)
