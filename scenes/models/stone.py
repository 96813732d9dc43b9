"""Things of stone: boulders, which are octrees of parts, and a fluted column.

How any solid becomes an octree, in which each cell is a ball for the matter in it (§1.3), is after
D. Meagher, "Geometric modeling using octree encoding", Computer Graphics and Image Processing 19
(1982), p. 129: a cube that holds the solid is halved along each axis again and again, empty cells
are left out, and so is what lies wholly inside, hidden by what lies about it: of the finest cells
those that the surface crosses are kept, of coarser ones also their full neighbours, or light would
fall through beside slivers. Level k has cells of side 2^-k of the cube. A cell's leaf appearance is
a ball about the middle of its matter, the larger the more of it there is; how thick and how bright
the balls of a level are is fitted (``scenes.appearance``). The finest are larger than their cells
and sunk to the surface, so that it is rough and not beaded. An inner cell has no looks of its own.

The shape of a boulder is an ellipsoid cut by random planes (the faces along which rock breaks), its
edges rounded and its surface roughened by noise of every size. Sizes are of the preset's choosing;
here the block is about a metre and a half across, half sunk into the ground.

The column, 6 m high, has base, shaft and capital, each with finer parts of its own. Level 0 is the
whole column, one stick; 1 base, shaft and capital; 2 the rings of the base, the flutes, the leaves
of the capital; 3 the curls of the leaves.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float64, Int64
from scipy.ndimage import gaussian_filter, zoom

from lod.arrays import ArrayData, FlagArray, FloatArray, Ints
from lod.errors import InputError
from lod.shapes import StickTable
from scenes.appearance.fit import fit_appearances
from scenes.sticks.prototype import PartPlaces, PartSticks, Prototype, assemble_prototype

SUNK = 1.7  # radius of the finest balls in sides of their cells: bumps of a seventh of a cell

_JITTER = 0.3
"""How far the finest balls stand from their places along the surface, in sides of their cells: on
a regular lattice they would look like beads."""


@dataclass(frozen=True, eq=False)
class Solid(ArrayData):
    """A solid sampled in a cube: s³ voxels of one side, s = 2^(depth + 1).

    within  (s, s, s) whether the middle of each voxel is solid; nothing touches the cube's faces
    albedo  (s, s, s, 3) linear Rec.709, 0 to 1
    corner  (3,) lowest corner of the cube in the object's frame [m]
    side    of the cube [m]
    """

    within: FlagArray
    albedo: FloatArray
    corner: FloatArray
    side: float

    def __post_init__(self) -> None:
        super().__post_init__()
        s = len(self.within)
        if self.within.shape != (s, s, s) or s < 4 or s & (s - 1):
            rule = "a cube of voxels, 4 or a higher power of two along each side"
            raise InputError("solid.within", self.within.shape, rule)
        faces = [np.take(self.within, end, axis) for axis in range(3) for end in (0, -1)]
        if np.any(faces) or not self.within.any():
            rule = "matter somewhere, and none at the faces of its cube"
            raise InputError("solid.within", "voxels", rule, "leave a margin of a voxel")

    @property
    def depth(self) -> int:
        """Return the level of the finest cells; each holds 2³ voxels."""
        return len(self.within).bit_length() - 2


@dataclass(frozen=True, eq=False)
class _Cells:
    """The kept cells of a level: (n, 3) place in the level's grid, and what is in each of them.

    volume (n,) [m³]; centre (n, 3) of its matter [m]; albedo (n, 3) mean of its matter
    """

    place: np.ndarray
    volume: np.ndarray
    centre: np.ndarray
    albedo: np.ndarray


def octree_prototype(name: str, solid: Solid, tints: Float64[np.ndarray, "t 3"]) -> Prototype:
    """Make the prototype of a solid, coarse cells first; a ball has the nearest of the tints."""
    levels = [_cells(solid, level) for level in range(solid.depth + 1)]
    levels[-1] = _sink_to_surface(solid, levels[-1])
    radii = [np.cbrt(3 * cells.volume / (4 * np.pi)) for cells in levels]
    radii[-1] = np.full(len(levels[-1].place), SUNK * solid.side / 2**solid.depth)
    count = [len(cells.place) for cells in levels]
    first = np.concatenate(([0], np.cumsum(count)))
    parent = [np.array([-1])]
    for level in range(1, len(levels)):
        parent.append(first[level - 1] + _cell_rows(levels[level - 1], levels[level].place // 2))
    n, centre = int(first[-1]), np.concatenate([cells.centre for cells in levels])
    albedo = np.concatenate([cells.albedo for cells in levels])
    tint = ((albedo[:, None, :] - tints) ** 2).sum(axis=2).argmin(axis=1)
    of, detail = np.concatenate(parent), np.repeat(np.arange(len(levels)), count)
    every = np.arange(n)
    balls = StickTable.of(n, every, centre, centre, *[np.concatenate(radii)] * 2, tint)
    owns = np.bincount(of[1:], minlength=n) > 0
    parts = PartSticks(of, detail, balls.only(~owns), tints, chosen=balls.only(owns))
    fitted = fit_appearances(parts)
    places = PartPlaces(of, detail, centre, fitted.overlap)
    inner = balls.take(np.zeros(0, np.int64))
    return assemble_prototype(name, places, inner, fitted.leaf, tints, fitted.view_dependence)


def _cells(solid: Solid, level: int) -> _Cells:
    s = len(solid.within)
    blocks = 2**level
    matter = solid.within.astype(np.float64)
    filled = _sums(matter, blocks)
    within = solid.within if level == solid.depth else filled == (s / blocks) ** 3
    # Kept is what holds a voxel or finest cell that is not full, or has a neighbour that is not.
    hidden = within.copy()
    for axis in range(3):
        for way in (-1, 1):
            hidden &= np.roll(within, way, axis)
    kept = np.argwhere((filled > 0) & (_sums(1.0 - hidden, blocks) > 0))
    at = tuple(kept.T)
    voxel = solid.side / s
    middles = solid.corner[:, None] + (np.arange(s) + 0.5) * voxel
    shapes = ((s, 1, 1), (1, s, 1), (1, 1, s))
    moments = [
        _sums(matter * middle.reshape(shape), blocks)
        for middle, shape in zip(middles, shapes, strict=True)
    ]
    colours = [_sums(matter * solid.albedo[..., k], blocks) for k in range(3)]
    share = filled[at]
    centre = np.stack([moment[at] / share for moment in moments], axis=1)
    albedo = np.stack([colour[at] / share for colour in colours], axis=1)
    return _Cells(kept, share * voxel**3, centre, albedo)


def _sums(values: Float64[np.ndarray, "s s s"], blocks: int) -> Float64[np.ndarray, "b b b"]:
    size = len(values) // blocks
    return values.reshape(blocks, size, blocks, size, blocks, size).sum(axis=(1, 3, 5))


def _cell_rows(cells: _Cells, place: Int64[np.ndarray, "n 3"]) -> Ints:
    """The row of the cell at each place; every one of them is kept, for it holds a kept cell."""
    side = int(cells.place.max()) + 1
    code = np.ravel_multi_index(tuple(cells.place.T), (side,) * 3)
    order = np.argsort(code)
    wanted = np.ravel_multi_index(tuple(place.T), (side,) * 3)
    return order[np.searchsorted(code, wanted, sorter=order)]


def _sink_to_surface(solid: Solid, cells: _Cells) -> _Cells:
    """The finest cells with the middles of balls whose tops lie at the surface, (n, 3) [m]."""
    side = solid.side / 2**solid.depth
    slopes = np.stack(np.gradient(gaussian_filter(solid.within.astype(np.float32), 2.0)), axis=-1)
    out = -slopes[tuple((2 * cells.place + 1).T)].astype(np.float64)
    out /= np.maximum(np.linalg.norm(out, axis=1, keepdims=True), 1e-9)
    # The solid itself is the seed: as many numbers as cells, whatever its name.
    along = np.random.default_rng(len(cells.place)).uniform(-1, 1, cells.centre.shape)
    along -= (along * out).sum(axis=1, keepdims=True) * out
    above = cells.volume / (2 * side**2) - SUNK * side
    return replace(cells, centre=cells.centre + out * above[:, None] + _JITTER * side * along)


STONE = np.linspace((0.19, 0.18, 0.165), (0.37, 0.36, 0.33), 7)
LICHEN = np.array(((0.33, 0.30, 0.16), (0.24, 0.26, 0.19)))
TINTS = np.concatenate((STONE, LICHEN))
"""Linear Rec.709 albedo of weathered granite, from dark to light, and of what grows on it; chosen
by eye."""

SIDE_M = 2.0  # side of the octree's cube
DEPTH = 6  # finest cells are 2^-DEPTH of the cube: 3 cm

_PLANES, _ROUNDED = 11, 0.07
_STREAM = 0xB01D


@lru_cache(maxsize=16)
def boulder_prototypes(seed: int, count: int) -> tuple[Prototype, ...]:
    """Make ``count`` boulders; the k-th depends on the seed and on k only."""
    return tuple(
        octree_prototype(f"boulder {k}", boulder_solid(seed, k), TINTS) for k in range(count)
    )


def boulder_solid(seed: int, k: int, depth: int = DEPTH) -> Solid:
    """Make the k-th block of that seed, sampled finely enough for an octree of that depth."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    s = 2 ** (depth + 1)
    axis = (np.arange(s) + 0.5) / s * 2 - 1
    xyz = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    # An ellipsoid, wider than high, and the planes that cut it; negative inside.
    half = rng.uniform((0.66, 0.55, 0.45), (0.8, 0.7, 0.6))
    outside = np.linalg.norm(xyz / half, axis=-1) - 1
    normals = rng.normal(size=(_PLANES, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    support = np.linalg.norm(normals * half, axis=1)
    depths = support * rng.uniform(0.62, 0.95, _PLANES)
    for normal, far in zip(normals, depths, strict=True):
        # The greater of two fields, rounded where they are near each other (a quadratic blend).
        plane = (xyz @ normal - far) / half.mean()
        near = np.maximum(_ROUNDED - np.abs(outside - plane), 0.0) / _ROUNDED
        outside = np.maximum(outside, plane) + near * near * _ROUNDED / 4
    outside = outside + 0.09 * _noise(rng, s, 2, 2.6)
    tone, growth = _noise(rng, s, 4, 1.8), _noise(rng, s, 3, 2.0)
    corner = SIDE_M * np.array((-0.5, -0.5, -0.43))
    # Stone of uneven tone; lichen in patches, more of it above.
    row = np.clip(np.rint(3 + 2.2 * tone), 0, len(STONE) - 1).astype(np.int64)
    patch = growth + 0.5 * xyz[..., 2]
    lichen = LICHEN[np.where(tone > 0, 0, 1)]
    albedo = np.where((patch > 1.25)[..., None], lichen, STONE[row])
    return Solid(outside < 0, albedo, corner, SIDE_M)


def _noise(
    rng: np.random.Generator, s: int, coarsest: int, fall: float
) -> Float64[np.ndarray, "s s s"]:
    """Noise of RMS 1 by spectral synthesis (Voss 1988, in "The Science of Fractal Images").

    Amplitudes fall as 1/(f + ``coarsest``)^fall, f in waves along the cube. Drawn on half as many
    points along each side, straight lines between.
    """
    n = s // 2
    frequency = np.fft.fftfreq(n, 1 / n), np.fft.fftfreq(n, 1 / n), np.fft.rfftfreq(n, 1 / n)
    x, y, z = np.meshgrid(*frequency, indexing="ij")
    f = np.sqrt(x * x + y * y + z * z)
    weight = np.where(f > 0, (f + coarsest) ** -fall, 0.0)
    spectrum = weight * np.fft.rfftn(rng.normal(size=(n, n, n)))
    values = np.fft.irfftn(spectrum, s=(n, n, n), axes=(0, 1, 2))
    return zoom(values / values.std(), 2, order=1, mode="nearest")


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
    whole, level, origin, inners, leaves = zip(*rows, strict=True)
    columns = np.array(whole, np.int64), np.array(level, np.int64), np.array(origin, np.float64)
    places = PartPlaces(*columns)
    return assemble_prototype("column", places, _table(inners), _table(leaves), _TINTS)


def _axis_stick(low: float, high: float, radius: float, tint: int) -> Stick:
    return (0.0, 0.0, low, 0.0, 0.0, high, radius, tint)


def _ring_point(k: float, count: int, radius: float, z: float) -> tuple[float, float, float]:
    turn = 2 * np.pi * k / count
    return float(radius * np.cos(turn)), float(radius * np.sin(turn)), z


def _table(looks: tuple[list[Stick], ...]) -> StickTable:
    owner = np.repeat(np.arange(len(looks)), [len(look) for look in looks])
    sticks = np.array([stick for look in looks for stick in look], np.float64).reshape(-1, 8)
    start, end, radius, tint = sticks[:, :3], sticks[:, 3:6], sticks[:, 6], sticks[:, 7]
    columns = start, end, radius, radius.copy(), tint.astype(np.int64)
    return StickTable.of(len(looks), owner, *columns)
