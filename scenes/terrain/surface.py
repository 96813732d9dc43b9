"""What the displayed tiles look like: one mesh, its normals and its colours, that never jump.

Over the view's band of fading, vertices move from the surface of the coarser tile to the relief
(``terrain_morph``), and patches of colour smaller than the spacing fade in.

Normals are the relief's, down to waves of a few pixels, however coarse the mesh: it looks nearly as
rough as the finest. Where what is too far to be displayed covers the ground, small
bumps are hidden with it.
"""

import math
from collections.abc import Callable, Sized
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.pruning.parts import Triangles
from lod.pruning.view import View, distance
from lod.threads import map_chunks
from scenes.noise.partial_sums import SoFar
from scenes.terrain.colour import Cover, ground_colours
from scenes.terrain.geomorph import Places, geomorph_parents, morph, place_keys
from scenes.terrain.mesh import MOST_COARSER, lattice_mesh
from scenes.terrain.point_cache import Shelf, heights_of
from scenes.terrain.quadtree import Patches, balance
from scenes.terrain.relief import Relief, unit_normals

SLOPE_M = 8.0
"""Shortest waves of the slope that grass minds: it grows over smaller bumps."""

SHOWN_PX = 4.0
"""Length of the waves that normals still hold whole [px]: a pixel's box leaves 0.90 of them; of
those half as long 0.64, which vertices some pixels apart would put in wrong places."""

LEAST_FACING, LEVEL_FACING = 0.05, 1e-4
"""Cosines between a normal and the way to the eye: what is bent is bent so far that faces between
such normals are turned to the eye as well; but no further than the ground without its bumps is,
down to the second, or plains would tilt where they are seen at a grazing angle."""

Shading = Float64[np.ndarray, "n 7"]
"""Of points of the ground: two slopes without small bumps, two with those that can be seen, and the
albedo."""

_RUN = 8192
"""Points that are shaded at once."""

_NO_POINTS = np.zeros((0, 3))
EMPTY_MESH = Triangles(_NO_POINTS, _NO_POINTS, _NO_POINTS, _NO_POINTS, np.zeros(0))
"""What no tiles look like."""


@runtime_checkable
class ResidualCover(Protocol):
    """What too distant objects leave at points of the ground."""

    @property
    def lift(self) -> Reals:
        """How much higher the ground is for it, (n,) [m]."""

    @property
    def covered(self) -> Reals:
        """Share of the ground that it covers, as the eye sees it, (n,)."""

    def colours(self, normals: Points, bare: Points) -> Points:
        """Albedo of the ground, (n, 3), where it would be ``bare``, and without small bumps would
        have these ``normals``."""


@runtime_checkable
class AggregateCover(Protocol):
    """What too distant objects leave on the ground."""

    @property
    def highest(self) -> float:
        """The most that it lifts the ground anywhere [m]."""

    def residual(self, view: View, points: Points) -> ResidualCover:
        """What of it there is at points (n, 3) of the ground."""


@dataclass(frozen=True, eq=False)
class Ground:
    """What is drawn of the ground, for whom.

    spacings, limit  of the tiles of each level: of their mesh, and how near they are in view [m]
    """

    view: View
    relief: Relief
    spacings: Reals
    limit: Reals
    cover: Cover
    aggregate_cover: AggregateCover | None


def surface(
    ground: Ground,
    patches: Patches,
    southwest: tuple[float, float],
    unit: float,
    shelf: Shelf | None = None,
) -> Triangles:
    """One watertight mesh of patches; the lattice of the deepest has quads of side ``unit`` [m].

    shelf: what is known from the frame before, and for the next; the same mesh in less time
    """
    view, shelf = ground.view, shelf or Shelf()
    where, faces, owner = lattice_mesh(*balance(patches, MOST_COARSER))
    before = shelf.at((ground.relief, view.camera.corner, southwest, unit))

    def placed(where: Places) -> Points:
        xy = np.array(southwest) + unit * where
        return np.column_stack((xy, heights_of(before, place_keys(where), xy)))

    def fraction(points: Points, level: Ints) -> Reals:
        return morph_fraction(ground, distance(view, points), level)

    lines = geomorph_parents(where, patches.deepest, placed, fraction)
    known = before.at(place_keys(where), lines.points)
    sums = known.slopes, known.patches

    def bare_at(rows: slice) -> Shading:
        return bare_shading(ground, lines.points[rows], *(each[rows] for each in sums))

    bare = _by_runs(bare_at, lines.points, 7)
    shelf.known = known
    points, looks = morph(lines, lines.points), morph(lines, bare)
    drawn = _by_runs(lambda rows: _drawn(ground, points[rows], looks[rows]), points, 9)
    vertices, normals, colours = drawn[:, :3], drawn[:, 3:6], drawn[:, 6:]
    return Triangles(vertices=vertices, normals=normals, colours=colours, faces=faces, owner=owner)


def _drawn(ground: Ground, vertices: Points, looks: Shading) -> Float64[np.ndarray, "n 9"]:
    """Vertices [m], unit normals and albedo of points, (n, 9), under the residual cover on them.

    looks: the shading that ``bare_shading`` gives
    """
    smooth, slopes, bare = looks[:, :2], looks[:, 2:4], looks[:, 4:]
    level = unit_normals(smooth)
    if ground.aggregate_cover is None:
        normals, colours = unit_normals(slopes), bare
    else:
        left = ground.aggregate_cover.residual(ground.view, vertices)
        normals = unit_normals(slopes + left.covered[:, None] * (smooth - slopes))
        colours = left.colours(level, bare)
        vertices = vertices + left.lift[:, None] * (0.0, 0.0, 1.0)
    normals = bend_toward_eye(normals, level, ground.view.camera.eye - vertices)
    return np.concatenate((vertices, normals, colours), axis=1)


@njit(cache=True, nogil=True)
def bend_toward_eye(normals: np.ndarray, smooth: np.ndarray, to_eye: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), those bent that turn from the eye, which is ``to_eye`` (n, 3) away;
    ``smooth``: those of the ground without its bumps.

    Ground that is seen faces the eye, but its bumps may be smaller than the mesh shows; shaded by
    the side of one that the eye cannot see, it would be black.
    """
    bent = normals.copy()
    for i in range(len(normals)):
        away, facing, level = 0.0, 0.0, 0.0
        for k in range(3):
            away += to_eye[i, k] ** 2
            facing += normals[i, k] * to_eye[i, k]
            level += smooth[i, k] * to_eye[i, k]
        away = math.sqrt(away)
        if away < 1e-6:
            continue
        facing, level = facing / away, abs(level) / away
        least = min(max(level, LEVEL_FACING), LEAST_FACING)
        if facing < least:
            share = math.sqrt((1 - least**2) / max(1 - facing**2, 1e-12))
            for k in range(3):
                way = to_eye[i, k] / away
                bent[i, k] = least * way + share * (normals[i, k] - facing * way)
    return bent


def _by_runs(task: Callable[[slice], np.ndarray], points: Sized, columns: int) -> np.ndarray:
    """What a task says of slices of points, each as long as suits the processor's cache."""
    found = np.empty((len(points), columns))

    def run(first: int, last: int) -> None:
        found[first:last] = task(slice(first, last))

    map_chunks(run, len(points), _RUN, _RUN)
    return found


def morph_fraction(ground: Ground, d: Reals, level: Ints) -> Reals:
    """How far points that tiles of a level add, d away, have come from the coarser surface."""
    limit, fade = ground.limit[level], ground.view.fade
    fraction, near = np.ones(len(d)), np.flatnonzero(np.isfinite(limit) & (limit > 0))
    if fade and len(near):
        limit = limit[near]
        fraction[near] = np.clip((limit - d[near]) / (fade * limit), 0.0, 1.0)
    return fraction


def bare_shading(ground: Ground, points: Points, slopes: SoFar, patches: SoFar) -> Shading:
    """Shading of the ground at points of the relief (n, 3), with an albedo as smooth as the spacing
    there is wide; from what is known of their slopes and patches of colour so far."""
    view, relief = ground.view, ground.relief
    d, corner = distance(view, points), view.camera.corner
    xy = np.ascontiguousarray(points[:, :2])  # once for all that looks at it
    spacing = spacing_at(ground, d)
    grown, seen = np.maximum(2 * spacing, SLOPE_M), SHOWN_PX * view.camera.pixel_angle * d
    steep = relief.slopes(corner, xy, np.column_stack((grown, seen)), slopes)
    rise, slope = points[:, 2] / (relief.amplitude or 1.0), np.hypot(steep[:, 0], steep[:, 1])
    albedo = ground_colours(relief.seed, corner, xy, rise, slope, spacing, ground.cover, patches)
    return np.concatenate((steep, albedo), axis=1)


def spacing_at(ground: Ground, d: Reals) -> Reals:
    """Spacing of the tiles in view that far away, running smoothly over each band [m]."""
    level = np.searchsorted(-ground.limit, -d) - 1
    halved = np.where(level > 0, morph_fraction(ground, d, level), 0.0)
    return np.asarray(ground.spacings[np.maximum(level - 1, 0)] * 0.5**halved)
