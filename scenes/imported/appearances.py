"""What the parts of a model look like as sticks: fitted ones for those that own parts, and ends.

Leaf appearances are fitted as for any other object (``scenes.appearance.fit``), with balls in the
place of pieces of surface where they are gathered, and the meshes themselves where anything is seen
or lit. Ends show their meshes; far cover (``scenes.far_cover``) is worked out from a few sticks in
their place, as thick as makes them cover, on average over directions, what the mesh does.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64
from PIL import Image

from lod.arrays import Points, Reals, expand
from lod.shapes import MeshTable, StickTable, triangle_areas
from scenes.appearance.fit import (
    FittedAppearances,
    cluster,
    error_diffusion,
    fit_appearances,
    fit_radii,
)
from scenes.imported.part_tree import PartTree
from scenes.sticks.by_view import ViewDependence
from scenes.sticks.shapes import PartSticks

_PIECES = 48
"""Pieces of one mesh, about as many or more."""

_MOST_BALLS = 200_000
"""Balls of a model, about as many at most: beyond, one ball stands for several pieces in a row."""


def surface_balls(meshes: MeshTable) -> tuple[StickTable, Points]:
    """Make the pieces of every part's mesh, and the albedo of each piece, (k, 3).

    A ball covers on average over directions as much as its piece, half of which faces away: it does
    not matter to what is fitted that balls of one surface overlap. A triangle that is much of its
    mesh has several pieces, in a regular pattern.
    """
    area = triangle_areas(meshes.vertices, meshes.faces)
    whole = np.bincount(meshes.owner, area, len(meshes.count))[meshes.owner]
    side = np.ceil(np.sqrt(_PIECES * area / whole)).astype(np.int64)  # pieces along each edge
    face, number = expand(side * side)
    s = side[face]
    row = np.floor(np.sqrt(number)).astype(np.int64)  # the row-th strip has 2 row + 1 pieces
    place = number - row * row
    down = place % 2  # every other piece points the other way
    u = (row - place // 2 + np.where(down, -1 / 3, 1 / 3)) / s
    v = (place // 2 + np.where(down, 2 / 3, 1 / 3)) / s
    shares = np.stack((1 - u - v, u, v), axis=1)[:, :, None]
    corners = meshes.faces[face]
    points = (meshes.vertices[corners] * shares).sum(axis=1)
    albedo = (meshes.colours[corners] * shares).sum(axis=1)
    radius = np.sqrt(area[face] / (s * s) / (2 * np.pi))
    owner = meshes.owner[face]
    step = max(1, len(points) // _MOST_BALLS)
    first = np.searchsorted(owner, np.arange(len(meshes.count)))
    kept = np.flatnonzero((np.arange(len(points)) - first[owner]) % step == 0)
    points, radius, none = points[kept], radius[kept] * np.sqrt(step), np.zeros(len(kept), np.int64)
    columns = points, points, radius, radius, none
    return StickTable.of(len(meshes.count), owner[kept], *columns), albedo[kept]


Tints = Float64[np.ndarray, "t 3"]

END_STICKS = 3
"""Sticks of one end at most."""

TINTS = 24
"""Tints of a model at most."""


def model_appearances(tree: PartTree, area: Reals) -> tuple[StickTable, Tints, FittedAppearances]:
    """Fit the sticks of all n parts of a model, as it rests.

    Returns their table, their tints, and the fit for those that own parts: its view dependence is
    that of the table.

    area (n,): mean projected area over directions of all that hangs on each part [m²]
    """
    balls, albedo = surface_balls(tree.meshes)
    tints = few_tints(albedo)
    weight, every = balls.start_radius**2, np.arange(len(tints))
    own = replace(balls, tint=error_diffusion(weight, albedo, tints, every))
    fitted = fit_appearances(PartSticks(tree.parent, tree.level, own, tints, tree.meshes))
    owns = np.bincount(tree.parent[1:], minlength=len(tree)) > 0
    ends = _end_sticks(own.of_parts(~owns), albedo, tints, area[~owns])
    ends = ends.with_owner(len(tree), np.flatnonzero(~owns)[ends.owner])
    inner, views = owns[fitted.leaf.owner], fitted.view_dependence
    rows = np.concatenate((views.table_row[inner], np.full(len(ends), -1)))
    owner = np.concatenate((fitted.leaf.owner[inner], ends.owner))
    leaf = StickTable.merge([fitted.leaf.take(inner), ends])
    in_order = rows[np.argsort(owner, kind="stable")]
    by_view = ViewDependence.of_area(in_order, views.area_share)
    return leaf, tints, replace(fitted, leaf=leaf, view_dependence=by_view)


def few_tints(colours: Points) -> Tints:
    """Choose at most TINTS albedos for all of these (k, 3), in order."""
    exact = np.unique(np.round(colours, 6), axis=0)
    if len(exact) <= TINTS:
        return exact
    coded = np.rint(255 * np.sqrt(colours)).astype(np.uint8)
    picture = Image.fromarray(coded[None]).quantize(TINTS, Image.Quantize.MEDIANCUT)
    _, row = np.unique(np.asarray(picture)[0], return_inverse=True)
    count = np.bincount(row)
    return np.stack([np.bincount(row, c) / count for c in colours.T], axis=1)


def _end_sticks(balls: StickTable, albedo: Points, tints: Tints, area: np.ndarray) -> StickTable:
    """Sticks in the place of the balls of m ends, which cover these areas (m,) [m²] on average."""
    groups, group = cluster(balls, np.full(len(area), END_STICKS))
    factor = fit_radii(groups, balls.take(np.zeros(0, np.int64)), area)
    weight = balls.start_radius**2
    total = np.bincount(group, weight, len(groups.part))
    sums = [np.bincount(group, weight * c, len(total)) for c in albedo.T]
    wanted = np.stack(sums, axis=1) / total[:, None]
    tint = error_diffusion(total, wanted, tints, np.arange(len(tints)))
    return groups.table(len(area), factor, tint)
