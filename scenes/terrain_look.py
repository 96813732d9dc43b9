"""What the displayed tiles look like: one mesh, its normals and its colours, that never jump.

Over the view's band of fading, vertices move from the surface of the coarser tile to the relief
(``terrain_morph``), and patches of colour smaller than the spacing fade in.
"""

from collections.abc import Callable, Sized
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from lod.arrays import Ints, Points, Reals
from lod.parts import Triangles
from lod.runs import in_runs
from lod.view import View, distance
from scenes.relief import Relief
from scenes.terrain_colour import Cover, ground_colours
from scenes.terrain_mesh import MOST_COARSER, lattice_mesh, vertex_normals
from scenes.terrain_morph import Places, blended, blended_normals, lineage
from scenes.terrain_patches import Patches, balanced

SLOPE_M = 8.0
"""Shortest waves of the slope that grass minds: it grows over smaller bumps."""

_RUN = 8192
"""Points that are shaded at once."""

_NO_POINTS = np.zeros((0, 3))
NOTHING = Triangles(_NO_POINTS, _NO_POINTS, _NO_POINTS, _NO_POINTS, np.zeros(0))
"""What no tiles look like."""


@runtime_checkable
class Far(Protocol):
    """What too distant objects leave on the ground."""

    @property
    def highest(self) -> float:
        """The most that it lifts the ground anywhere [m]."""

    def lift(self, view: View, points: Points) -> Reals:
        """How much higher the ground is for it at points (n, 3), (n,) [m]."""

    def colours(self, view: View, points: Points, normals: Points, bare: Points) -> Points:
        """Its albedo there, (n, 3), where ``normals`` shade it and it would be ``bare``."""


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
    far: Far | None


def surface(
    ground: Ground, patches: Patches, southwest: tuple[float, float], unit: float
) -> Triangles:
    """One watertight mesh of patches; the lattice of the deepest has quads of side ``unit`` [m]."""
    view, far = ground.view, ground.far
    where, faces, owner = lattice_mesh(*balanced(patches, MOST_COARSER))

    def placed(where: Places) -> Points:
        xy = np.array(southwest) + unit * where
        return np.column_stack((xy, ground.relief.height(view.camera.corner, xy)))

    def arrived(points: Points, level: Ints) -> Reals:
        return arrived_at(ground, points, level)

    lines = lineage(where, patches.deepest, placed, arrived)
    vertices = stood = blended(lines, lines.points)
    colours = blended(
        lines, _by_runs(lambda rows: bare_colours(ground, lines.points[rows]), lines.points)
    )
    if far:
        vertices = vertices.copy()
        vertices[:, 2] += _by_runs(lambda rows: far.lift(view, stood[rows]), stood)
    normals = blended_normals(lines, vertex_normals(vertices, faces))
    if far:
        bare = colours
        colours = _by_runs(
            lambda rows: far.colours(view, stood[rows], normals[rows], bare[rows]), stood
        )
    return Triangles(vertices=vertices, normals=normals, colours=colours, faces=faces, owner=owner)


def _by_runs(task: Callable[[slice], np.ndarray], points: Sized) -> np.ndarray:
    """What a task says of slices of points, each as long as suits the processor's cache."""
    runs = in_runs(lambda first, last: task(slice(first, last)), len(points), _RUN, _RUN)
    return np.concatenate(runs)


def arrived_at(ground: Ground, points: Points, level: Ints) -> Reals:
    """How far points that tiles of a level add have come from the coarser surface, 0 to 1."""
    limit, view = ground.limit[level], ground.view
    arrived, near = np.ones(len(points)), np.flatnonzero(np.isfinite(limit) & (limit > 0))
    if view.fade and len(near):
        limit = limit[near]
        before = limit - distance(view, points[near])
        arrived[near] = np.clip(before / (view.fade * limit), 0.0, 1.0)
    return arrived


def bare_colours(ground: Ground, points: Points) -> Points:
    """Albedo of the ground at points of the relief, as smooth as the spacing there is wide."""
    spacing, relief = spacing_at(ground, points), ground.relief
    corner, xy = ground.view.camera.corner, points[:, :2]
    slopes = relief.slopes(corner, xy, np.maximum(2 * spacing, SLOPE_M))
    rise, slope = points[:, 2] / (relief.amplitude or 1.0), np.hypot(slopes[:, 0], slopes[:, 1])
    return ground_colours(relief.seed, corner, xy, rise, slope, spacing, ground.cover)


def spacing_at(ground: Ground, points: Points) -> Reals:
    """Spacing of the tiles in view that far away, running smoothly over each band [m]."""
    level = np.searchsorted(-ground.limit, -distance(ground.view, points)) - 1
    arrived = arrived_at(ground, points, level)
    halved = np.where(level > 0, arrived, 0.0)
    return np.asarray(ground.spacings[np.maximum(level - 1, 0)] * 0.5**halved)
