"""One mesh of the displayed tiles, with normals and colours, that never jumps from frame to frame.

Over the view's band of fading, vertices move from the surface of the coarser tile to the relief
(``scenes.terrain.geomorph``), and patches of colour smaller than the spacing fade in
(``scenes.terrain.shading``). Relief too small for the mesh leaves its mean light
(``scenes.terrain.hidden_relief``). Where undisplayed objects cover the ground, small bumps are
hidden with it.
"""

from collections.abc import Callable, Sized

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.shapes import Triangles
from lod.threads import map_chunks
from lod.view import distance
from scenes.terrain.geomorph import Places, geomorph_parents, morph
from scenes.terrain.hidden_relief import cavity_albedo, seen_facets
from scenes.terrain.mesh import MOST_COARSER, lattice_mesh
from scenes.terrain.quadtree import Patches, balance
from scenes.terrain.relief import unit_normals
from scenes.terrain.shading import (
    GroundInView,
    Shading,
    bare_shading,
    morph_fraction,
)

_RUN = 8192
"""Points that are shaded at once: as many as suit the processor's cache."""

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
    """Vertices [m], unit normals and albedo of the ground under its residual cover, (n, 9)."""
    smooth, slopes, hidden, bare = np.split(shading, (2, 4, 5), axis=1)
    eye, cover = ground.view.camera.eye, ground.aggregate_cover
    if cover is None:
        normals, share = seen_facets(slopes, hidden[:, 0], eye - vertices, ground.to_sun)
        return np.concatenate((vertices, normals, cavity_albedo(bare, share)), axis=1)
    residual = cover.residual(ground.view, vertices)
    vertices = vertices + residual.lift[:, None] * (0.0, 0.0, 1.0)
    open_share = 1 - residual.covered[:, None]
    slopes, hidden = smooth + open_share * (slopes - smooth), open_share**2 * hidden
    normals, share = seen_facets(slopes, hidden[:, 0], eye - vertices, ground.to_sun)
    colours = residual.colours(unit_normals(smooth), cavity_albedo(bare, share))
    return np.concatenate((vertices, normals, colours), axis=1)


def _by_runs(task: Callable[[slice], np.ndarray], points: Sized, columns: int) -> np.ndarray:
    """Rows (n, columns) that ``task`` returns for slices of points, worked out in threads."""
    found = np.empty((len(points), columns))

    def run(first: int, last: int) -> None:
        found[first:last] = task(slice(first, last))

    map_chunks(run, len(points), _RUN, _RUN)
    return found
