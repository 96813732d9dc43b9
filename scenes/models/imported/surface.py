"""Pieces of a model's meshes, each as a small ball: what is gathered into sticks in their place."""

import numpy as np

from lod.arrays import Points, expand
from lod.shapes import MeshTable, StickTable, triangle_areas

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
