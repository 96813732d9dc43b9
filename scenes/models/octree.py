"""How any solid becomes an octree of parts: each cell is a ball for the matter in it (§1.3).

After D. Meagher, "Geometric modeling using octree encoding", Computer Graphics and Image Processing
19 (1982), p. 129: a cube that holds the solid is halved along each axis again and again, empty
cells are left out, and so is what lies wholly inside, hidden by what lies about it: of the finest
cells those that the surface crosses are kept, of coarser ones also their full neighbours, or light
would fall through beside slivers. Level k has cells of side 2^-k of the cube.

A cell's leaf appearance is a ball about the middle of its matter, the larger the more of it there
is; how thick and how bright the balls of a level are is fitted (``scenes.sticks.appearance``). The
finest are larger than their cells and sunk to the surface, so that it is rough and not beaded. An
inner cell has no looks of its own.
"""

from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy.ndimage import gaussian_filter

from lod.arrays import ArrayData, FlagArray, FloatArray, Ints
from lod.errors import InputError
from lod.shapes import StickTable
from scenes.sticks.appearance.fit import fit_appearances
from scenes.sticks.appearance.part_sticks import PartSticks
from scenes.sticks.prototype import PartPlaces, Prototype, assemble_prototype

SUNK = 1.7
"""Radius of the finest balls in sides of their cells: bumps of a seventh of a cell."""

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
    """Cells of a level that are kept; level 0 is the whole cube."""
    s = len(solid.within)
    blocks = 2**level
    matter = solid.within.astype(np.float64)
    filled = _sums(matter, blocks)
    within = solid.within if level == solid.depth else filled == (s / blocks) ** 3
    kept = np.argwhere((filled > 0) & _at_surface(within, blocks))
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
    """Sums of voxel values over blocks³ equal cubes."""
    size = len(values) // blocks
    return values.reshape(blocks, size, blocks, size, blocks, size).sum(axis=(1, 3, 5))


def _at_surface(full: Bool[np.ndarray, "s s s"], blocks: int) -> Bool[np.ndarray, "b b b"]:
    """Cells that hold a voxel or finest cell that is not full, or has a neighbour that is not."""
    hidden = full.copy()
    for axis in range(3):
        for way in (-1, 1):
            hidden &= np.roll(full, way, axis)
    return _sums(1.0 - hidden, blocks) > 0


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
