"""One watertight mesh of patches of different fineness, on an integer lattice.

Along a side shared with a patch 2**k times coarser, the finer patch's vertices move to the nearest
multiple of 2**k, which are exactly the coarser patch's vertices: no T-junction remains, and the
triangles that lose their area are left out. Vertices are merged by their integer coordinates, so
that shared ones are the same bits.

**Geomorphing.** A new vertex starts on the coarser surface and moves to the relief. One that
refining adds lies on an edge of the coarser mesh, midway between two of its vertices, its parents.
While it morphs it is a blend of their mean and of itself (geomorphing: Hoppe 1996, "Progressive
meshes"; by distance as in Strugar 2009, "Continuous distance-dependent level of detail for
rendering heightmaps"). Its parents may themselves be morphing.

Over the view's band of fading, vertices move from the surface of the coarser tile to the relief,
and patches of colour smaller than the spacing fade in. Relief too small for the mesh leaves its
mean light (``scenes.ground.shading``). Where undisplayed objects cover the ground, small bumps are
hidden with it.

The ground as an ordinary representation: fractal relief, finer where it is nearer.

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
from collections.abc import Callable, Sized
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Points, Reals, frozen
from lod.camera import Corner
from lod.errors import InputError
from lod.kernels import map_chunks, njit
from lod.pruner import BlendWeights, Parts
from lod.shapes import Triangles
from lod.view import View, distance
from scenes.ground.quadtree import (
    Horizon,
    Patches,
    Squares,
    balance,
    below_horizon,
    horizon,
    limits,
    outside_picture,
    quarters,
    uncovered_quarters,
)
from scenes.ground.relief import Relief, unit_normals
from scenes.ground.shading import (
    GROUND_MATERIALS,
    AggregateCover,
    GroundInView,
    Shading,
    bare_shading,
    cavity_albedo,
    morph_fraction,
    seen_facets,
)

QUADS = 4  # quads along the side of a patch; a tile has twice as many

MOST_COARSER = 2
"""Largest difference of depth of neighbours: a side of 2**2 quads can meet one coarser quad."""


def lattice_mesh(
    patches: Patches, coarser: Int64[np.ndarray, "n 4"]
) -> tuple[Int64[np.ndarray, "v 2"], Int64[np.ndarray, "f 3"], Int64[np.ndarray, " f"]]:
    """Vertices, faces, and the owner of each face, of one watertight mesh.

    Vertices (v, 2) are places counted in quads of the deepest patches, ascending. Faces (f, 3) are
    counter-clockwise from above.

    coarser (n, 4)  how many halvings coarser the neighbour across each side of a patch is
    """
    fine = patches.deepest - patches.depth
    keys = _vertex_keys(patches.x << fine, patches.y << fine, fine, coarser)
    unique, row = np.unique(keys.ravel(), return_inverse=True)
    rows = row.reshape(len(patches), QUADS + 1, QUADS + 1)
    faces, owner = _faces(rows, patches.owner)
    return np.stack((unique >> 32, unique & 0xFFFFFFFF), axis=1), faces, owner


@njit(cache=True)
def _snapped(i: int, halvings: int) -> int:
    return ((i + ((1 << halvings) >> 1)) >> halvings) << halvings


@njit(cache=True)
def _vertex_keys(x: np.ndarray, y: np.ndarray, fine: np.ndarray, coarser: np.ndarray) -> np.ndarray:
    """Places of each patch's vertices after snapping, x and y in one integer, (n, 9, 9)."""
    keys = np.empty((len(x), QUADS + 1, QUADS + 1), np.int64)
    for p in range(len(x)):
        south, east, north, west = coarser[p]
        for j in range(QUADS + 1):
            for i in range(QUADS + 1):
                along_x = south if j == 0 else (north if j == QUADS else 0)
                along_y = west if i == 0 else (east if i == QUADS else 0)
                vx = x[p] * QUADS + (_snapped(i, along_x) << fine[p])
                vy = y[p] * QUADS + (_snapped(j, along_y) << fine[p])
                keys[p, j, i] = (vx << 32) | vy
    return keys


@njit(cache=True)
def _faces(rows: np.ndarray, owner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two triangles for each quad; diagonals alternate so that no direction is preferred."""
    faces = np.empty((len(owner) * QUADS * QUADS * 2, 3), np.int64)
    owners = np.empty(len(faces), np.int64)
    n = 0
    for p in range(len(owner)):
        for j in range(QUADS):
            for i in range(QUADS):
                a, b = rows[p, j, i], rows[p, j, i + 1]
                d, c = rows[p, j + 1, i], rows[p, j + 1, i + 1]
                if (i + j) % 2 == 0:
                    pair = ((a, b, c), (a, c, d))
                else:
                    pair = ((a, b, d), (b, c, d))
                for u, v, w in pair:
                    if u != v and v != w and w != u:
                        faces[n, 0], faces[n, 1], faces[n, 2] = u, v, w
                        owners[n] = owner[p]
                        n += 1
    return faces[:n].copy(), owners[:n].copy()


Places = Int64[np.ndarray, "n 2"]
"""Places on the lattice of the deepest patches, counted in its quads."""


@dataclass(frozen=True, eq=False)
class GeomorphParents(ArrayData):
    """Vertices of a mesh and the parents that they morph from.

    The mesh's vertices come first, then those parents that the mesh lacks.

    points (n, 3)   places on the relief [m]
    count           number of the mesh's own vertices
    fraction (n,)   0 = on the coarser surface, 1 = on the relief
    morphing (k,)   rows of the vertices that have not arrived, coarsest first
    parents (k, 2)  rows of the two parents of each of those
    """

    points: FloatArray
    count: int
    fraction: FloatArray
    morphing: IntArray
    parents: IntArray


def vertex_levels(where: Places, deepest: int) -> Ints:
    """Level of the coarsest tiles with a vertex at each place.

    deepest: depth of the finest patches
    """
    step = _steps(where, deepest)
    return deepest - 1 - np.rint(np.log2(step)).astype(np.int64)


def geomorph_parents(
    where: Places,
    deepest: int,
    point_at: Callable[[Places], Points],
    morph_fraction: Callable[[Points, Ints], Reals],
) -> GeomorphParents:
    """Vertices of a mesh, in order of their places, with all parents that morphing needs.

    ``point_at`` is called with places in their order, ``morph_fraction`` with points and their
    levels. A parent is not a vertex of the mesh where a side was simplified to meet a coarser
    patch.
    """
    points, level = point_at(where), vertex_levels(where, deepest)
    fraction = morph_fraction(points, level)
    count, names = len(where), place_keys(where)
    morphing = np.flatnonzero(fraction < 1)
    levels = [level[morphing]]
    pairs = [coarser_edge_ends(where[morphing], deepest)]
    seeking = morphing
    while len(seeking):
        new = _lacking(names, pairs[-1])
        seeking = len(names) + np.arange(len(new))
        names, level = np.append(names, place_keys(new)), vertex_levels(new, deepest)
        points = np.concatenate((points, point_at(new)))
        fraction = np.append(fraction, morph_fraction(points[seeking], level))
        seeking, new, level = seeking[level > 0], new[level > 0], level[level > 0]
        morphing = np.append(morphing, seeking)
        levels.append(level)
        pairs.append(coarser_edge_ends(new, deepest))
    order = np.argsort(np.concatenate(levels), kind="stable")
    by_name = np.argsort(names, kind="stable")
    pair = place_keys(np.concatenate(pairs)[order].reshape(-1, 2))
    rows = by_name[np.searchsorted(names, pair, sorter=by_name)].reshape(-1, 2)
    return GeomorphParents(points, count, fraction, morphing[order], rows)


def _lacking(names: Ints, pairs: Int64[np.ndarray, "h 2 2"]) -> Int64[np.ndarray, "w 2"]:
    wanted = pairs.reshape(-1, 2)
    name = place_keys(wanted)
    known = np.sort(names, kind="stable")
    found = known[np.minimum(np.searchsorted(known, name), len(known) - 1)]
    missing = np.flatnonzero(found != name)
    return wanted[missing[np.unique(name[missing], return_index=True)[1]]]


def coarser_edge_ends(where: Places, deepest: int) -> Int64[np.ndarray, "n 2 2"]:
    """Ends of the coarser edge that each vertex halves."""
    step = _steps(where, deepest)
    x, y = (where // step[:, None]).T
    odd_x, odd_y = x & 1, y & 1
    # In the middle of a coarser quad it is the diagonal, and those alternate (``_faces`` in mesh).
    turn = np.where(odd_x & odd_y & (((x >> 1) + (y >> 1)) & 1), -1, 1)
    along = step[:, None] * np.stack((odd_x, turn * odd_y), axis=1)
    return np.stack((where - along, where + along), axis=1)


def morph(lines: GeomorphParents, values: Float64[np.ndarray, "n k"]) -> Float64[np.ndarray, "m k"]:
    """Values of the mesh's vertices, blended with those of their parents."""
    values = _morph(values.copy(), lines.fraction, lines.morphing, lines.parents)
    return values[: lines.count]


@njit(cache=True)
def _morph(values, fraction, morphing, parents):  # type: ignore[no-untyped-def]
    for j in range(len(morphing)):
        i, a, b = morphing[j], parents[j, 0], parents[j, 1]
        for k in range(values.shape[1]):
            mean = (values[a, k] + values[b, k]) / 2
            values[i, k] = mean + fraction[i] * (values[i, k] - mean)
    return values


def _steps(where: Places, deepest: int) -> Ints:
    """Spacing of the coarsest lattice with a vertex at each place, in quads of the finest."""
    both = where[:, 0] | where[:, 1]
    coarsest = 1 << (deepest - 1)
    lowest_bit = both & -both
    return np.where(lowest_bit == 0, coarsest, np.minimum(lowest_bit, coarsest))


def place_keys(where: Places) -> Ints:
    """Number of each place, ascending in the order of the places."""
    return (where[:, 0] << 32) | where[:, 1]


_RUN = 8192  # points that are shaded at once: as many as suit the processor's cache

_NO_POINTS = np.zeros((0, 3))
EMPTY_MESH = Triangles(_NO_POINTS, _NO_POINTS, _NO_POINTS, _NO_POINTS, np.zeros(0))
"""Mesh of no tiles."""


def ground_mesh(
    ground: GroundInView, patches: Patches, southwest: tuple[float, float], unit: float
) -> Triangles:
    """One watertight mesh of patches, with unit normals and albedo at its vertices.

    southwest, unit  place where the lattice of the deepest patches begins, and its spacing [m]
    """
    places, faces, owner = lattice_mesh(*balance(patches, MOST_COARSER))

    def point_at(places: Places) -> Points:
        xy = np.array(southwest) + unit * places
        return np.column_stack((xy, ground.relief.height(ground.view.camera.corner, xy)))

    def fraction_at(points: Points, level: Ints) -> Reals:
        return morph_fraction(ground, distance(ground.view, points), level)

    lines = geomorph_parents(places, patches.deepest, point_at, fraction_at)
    bare = _by_runs(lambda rows: bare_shading(ground, lines.points[rows]), lines.points, 8)
    points, shading = morph(lines, lines.points), morph(lines, bare)
    columns = _by_runs(lambda rows: _covered(ground, points[rows], shading[rows]), points, 9)
    vertices, normals, colours = columns[:, :3], columns[:, 3:6], columns[:, 6:]
    return Triangles(vertices=vertices, normals=normals, colours=colours, faces=faces, owner=owner)


def _covered(
    ground: GroundInView, vertices: Points, shading: Shading
) -> Float64[np.ndarray, "n 9"]:
    smooth, slopes, hidden, bare = np.split(shading, (2, 4, 5), axis=1)
    eye, cover = ground.view.camera.eye, ground.aggregate_cover
    if cover is None:
        normals, share = seen_facets(slopes, hidden[:, 0], eye - vertices, ground.to_sun)
        return np.concatenate((vertices, normals, cavity_albedo(bare, share)), axis=1)
    residual = cover.residual(ground.view, vertices, smooth)
    vertices = vertices + residual.lift[:, None] * (0.0, 0.0, 1.0)
    open_share = 1 - residual.covered[:, None]
    slopes, hidden = smooth + open_share * (slopes - smooth), open_share**2 * hidden
    normals, share = seen_facets(slopes, hidden[:, 0], eye - vertices, ground.to_sun)
    colours = residual.colours(unit_normals(smooth), cavity_albedo(bare, share))
    return np.concatenate((vertices, normals, colours), axis=1)


def _by_runs(task: Callable[[slice], np.ndarray], points: Sized, columns: int) -> np.ndarray:
    found = np.empty((len(points), columns))

    def run(first: int, last: int) -> None:
        found[first:last] = task(slice(first, last))

    map_chunks(run, len(points), _RUN, _RUN)
    return found


SAMPLES = 4  # points along each side of a tile at which its heights are sampled to bound them

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
    detail   τ of the ground in view, as a share of the view's
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
    detail: float = 1.0
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
        return limits(self.relief, self.spacings, view, self.detail)

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
