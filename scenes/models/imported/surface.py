"""Pieces of a model's meshes, each as a small ball: what sticks in their place are fitted to."""

import numpy as np

from lod.arrays import Points, expand
from lod.mesh_table import MeshTable, triangle_areas
from lod.stick_table import StickTable

_PIECES = 48
"""Pieces of one mesh, about as many or more."""


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
    none = np.zeros(len(points), np.int64)
    balls = StickTable.of(
        len(meshes.count), meshes.owner[face], points, points, radius, radius, none
    )
    return balls, albedo


def balls_below(
    parent: np.ndarray, balls: StickTable, rows: np.ndarray, most: int
) -> tuple[StickTable, np.ndarray]:
    """Gather for each of the parts ``rows`` (m,) the balls of all that hangs on it.

    Where there are more than ``most`` in all, every so-manieth stands for those between. Returns
    them as a table of m parts, and the row of each among the balls that were given.
    """
    at = np.full(len(parent), -1)
    at[rows] = np.arange(len(rows))
    ball, owner = np.arange(len(balls)), balls.owner
    step = max(1, len(balls) // most)
    ball, owner = ball[::step], owner[::step]
    found, owners = [], []
    while len(ball):
        inside = at[owner] >= 0
        found.append(ball[inside])
        owners.append(at[owner[inside]])
        above = parent[owner]
        ball, owner = ball[above >= 0], above[above >= 0]
    chosen, number = np.concatenate(found), np.concatenate(owners)
    order = np.argsort(number, kind="stable")
    columns = (column[chosen] for column in balls.columns)
    return StickTable.of(len(rows), number, *columns), chosen[order]
