"""One watertight mesh of patches of different fineness, on an integer lattice.

Along a side shared with a patch 2**k times coarser, the finer patch's vertices move to the nearest
multiple of 2**k, which are exactly the coarser patch's vertices: no T-junction remains, and the
triangles that lose their area are left out. Vertices are merged by their integer coordinates, so
that shared ones are the same bits.
"""

import numpy as np
from jaxtyping import Int64
from numba import njit

from scenes.terrain.quadtree import Patches

QUADS = 4
"""Quads along the side of a patch; a tile has twice as many."""

MOST_COARSER = 2
"""Largest difference of depth of neighbours: a side of 2**2 quads can meet one coarser quad."""


def lattice_mesh(
    patches: Patches, coarser: Int64[np.ndarray, "n 4"]
) -> tuple[
    Int64[np.ndarray, "v 2"],
    Int64[np.ndarray, "f 3"],
    Int64[np.ndarray, " f"],
]:
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
    """Nearest multiple of 2**halvings."""
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
