"""Projected area of every part of a model, with all that hangs on it, along given directions.

Seen along a direction the triangles of a part and of all below it fall on a square grid of points,
CELLS to the longer side; the points that any covers are counted. Points fall evenly, so that areas
are unbiased, however thin what covers them is.
"""

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints
from lod.shapes import MeshTable
from scenes.sticks.union_area import _along, _frame

CELLS = 160


def projected_areas(
    parent: Ints, meshes: MeshTable, directions: Float64[np.ndarray, "d 3"]
) -> Float64[np.ndarray, "n d"]:
    """Measure the projected area of each part along each direction, (n, d) [m²].

    parent (n,) as in Hierarchy; meshes: of the n parts, in one frame
    """
    order, begin, end = depth_first(parent, meshes.count)
    rows = np.concatenate(
        [np.arange(meshes.first_face[part], meshes.first_face[part + 1]) for part in order]
    )
    corners = np.ascontiguousarray(meshes.vertices[meshes.faces[rows]].reshape(-1, 3))
    return _areas(corners, begin, end, np.ascontiguousarray(directions))


def depth_first(parent: Ints, count: Ints) -> tuple[Ints, Ints, Ints]:
    """Order parts so that all below a part follow it, (n,), and find the run of each, (n,) each.

    The run of a part goes from its first triangle to the end of those below it, in that order;
    ``count`` (n,) is how many triangles each has itself.
    """
    n = len(parent)
    size, total = np.ones(n, np.int64), count.astype(np.int64)
    for row in range(n - 1, 0, -1):
        size[parent[row]] += size[row]
        total[parent[row]] += total[row]
    place, begin = np.zeros(n, np.int64), np.zeros(n, np.int64)
    next_place, next_begin = place + 1, count.astype(np.int64)
    for row in range(1, n):
        above = parent[row]
        place[row], begin[row] = next_place[above], next_begin[above]
        next_place[above] += size[row]
        next_begin[above] += total[row]
        next_place[row] = place[row] + 1
        next_begin[row] = begin[row] + count[row]
    return np.argsort(place), begin, begin + total


@njit(cache=True)
def _areas(corners, begin, end, directions):  # type: ignore[no-untyped-def]
    n = len(begin)
    areas = np.zeros((n, len(directions)))
    grid = np.zeros((CELLS + 1, CELLS + 1), np.uint8)
    for j in range(len(directions)):
        across, up = _frame(directions[j])
        x, y = _along(corners, across), _along(corners, up)
        for i in range(n):
            a, b = 3 * begin[i], 3 * end[i]
            areas[i, j] = _covered(x[a:b], y[a:b], grid)
    return areas


@njit(cache=True)
def _covered(x, y, grid):  # type: ignore[no-untyped-def]
    """Area that triangles cover, three corners each in a row."""
    low_x, low_y = x.min(), y.min()
    side = max(x.max() - low_x, y.max() - low_y)
    cell = side / CELLS
    if cell <= 0.0:
        return 0.0
    grid[:] = 0
    for t in range(0, len(x), 3):
        top = max(y[t], y[t + 1], y[t + 2])
        bottom = min(y[t], y[t + 1], y[t + 2])
        first = int(np.ceil((bottom - low_y) / cell - 0.5))
        last = int(np.floor((top - low_y) / cell - 0.5))
        for row in range(max(first, 0), min(last, CELLS) + 1):
            level = low_y + (row + 0.5) * cell
            left, right = np.inf, -np.inf
            for k in range(3):
                p, q = t + k, t + (k + 1) % 3
                if (y[p] <= level) != (y[q] <= level):
                    at = x[p] + (level - y[p]) / (y[q] - y[p]) * (x[q] - x[p])
                    left, right = min(left, at), max(right, at)
            if left <= right:
                a = int(np.ceil((left - low_x) / cell - 0.5))
                b = int(np.floor((right - low_x) / cell - 0.5))
                for column in range(max(a, 0), min(b, CELLS) + 1):
                    grid[row, column] = 1
    return grid.sum() * cell * cell
