"""Geomorphing of the ground: a new vertex starts on the coarser surface and moves to the relief.

A vertex that refining adds lies on an edge of the coarser mesh, midway between two of its vertices,
its parents. While it morphs it is a blend of their mean and of itself (geomorphing: Hoppe 1996,
"Progressive meshes"; by distance as in Strugar 2009, "Continuous distance-dependent level of detail
for rendering heightmaps"). Its parents may themselves be morphing.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from numba import njit

from lod.arrays import Ints, Points, Reals, freeze

Places = Int64[np.ndarray, "n 2"]
"""Places on the lattice of the deepest patches, counted in its quads."""


@dataclass(frozen=True, eq=False)
class GeomorphParents:
    """Vertices of a mesh and the parents that they morph from.

    The mesh's vertices come first, then those parents that the mesh lacks.

    points (n, 3)   places on the relief [m]
    count           number of the mesh's own vertices
    fraction (n,)   0 = on the coarser surface, 1 = on the relief
    morphing (k,)   rows of the vertices that have not arrived, coarsest first
    parents (k, 2)  rows of the two parents of each of those
    """

    points: np.ndarray
    count: int
    fraction: np.ndarray
    morphing: np.ndarray
    parents: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, points=np.float64, fraction=np.float64, morphing=np.int64, parents=np.int64)


def vertex_levels(where: Places, deepest: int) -> Ints:
    """Level of the coarsest tiles with a vertex at each place.

    deepest: depth of the finest patches
    """
    step = _steps(where, deepest)
    return deepest - 1 - np.rint(np.log2(step)).astype(np.int64)


def geomorph_parents(
    where: Places,
    deepest: int,
    point_at: Callable[[Places], Points],
    morph_fraction: Callable[[Points, Ints], Reals],
) -> GeomorphParents:
    """Vertices of a mesh, in order of their places, with all parents that morphing needs.

    ``point_at`` is called with places in their order, ``morph_fraction`` with points and their
    levels. A parent is not a vertex of the mesh where a side was simplified to meet a coarser
    patch.
    """
    points, level = point_at(where), vertex_levels(where, deepest)
    fraction = morph_fraction(points, level)
    count, names = len(where), place_keys(where)
    morphing = np.flatnonzero(fraction < 1)
    levels = [level[morphing]]
    pairs = [coarser_edge_ends(where[morphing], deepest)]
    seeking = morphing
    while len(seeking):
        new = _lacking(names, pairs[-1])
        seeking = len(names) + np.arange(len(new))
        names, level = np.append(names, place_keys(new)), vertex_levels(new, deepest)
        points = np.concatenate((points, point_at(new)))
        fraction = np.append(fraction, morph_fraction(points[seeking], level))
        seeking, new, level = seeking[level > 0], new[level > 0], level[level > 0]
        morphing = np.append(morphing, seeking)
        levels.append(level)
        pairs.append(coarser_edge_ends(new, deepest))
    order = np.argsort(np.concatenate(levels), kind="stable")
    by_name = np.argsort(names, kind="stable")
    pair = place_keys(np.concatenate(pairs)[order].reshape(-1, 2))
    rows = by_name[np.searchsorted(names, pair, sorter=by_name)].reshape(-1, 2)
    return GeomorphParents(points, count, fraction, morphing[order], rows)


def _lacking(names: Ints, pairs: Int64[np.ndarray, "h 2 2"]) -> Int64[np.ndarray, "w 2"]:
    """Ends of edges that are not among the keys of known places, each once."""
    wanted = pairs.reshape(-1, 2)
    name = place_keys(wanted)
    known = np.sort(names, kind="stable")
    found = known[np.minimum(np.searchsorted(known, name), len(known) - 1)]
    missing = np.flatnonzero(found != name)
    return wanted[missing[np.unique(name[missing], return_index=True)[1]]]


def coarser_edge_ends(where: Places, deepest: int) -> Int64[np.ndarray, "n 2 2"]:
    """Ends of the coarser edge that each vertex halves."""
    step = _steps(where, deepest)
    x, y = (where // step[:, None]).T
    odd_x, odd_y = x & 1, y & 1
    # In the middle of a coarser quad it is the diagonal, and those alternate (``_faces`` in mesh).
    turn = np.where(odd_x & odd_y & (((x >> 1) + (y >> 1)) & 1), -1, 1)
    along = step[:, None] * np.stack((odd_x, turn * odd_y), axis=1)
    return np.stack((where - along, where + along), axis=1)


def morph(lines: GeomorphParents, values: Float64[np.ndarray, "n k"]) -> Float64[np.ndarray, "m k"]:
    """Values of the mesh's vertices, blended with those of their parents."""
    values = _morph(values.copy(), lines.fraction, lines.morphing, lines.parents)
    return values[: lines.count]


@njit(cache=True)
def _morph(values, fraction, morphing, parents):  # type: ignore[no-untyped-def]
    for j in range(len(morphing)):
        i, a, b = morphing[j], parents[j, 0], parents[j, 1]
        for k in range(values.shape[1]):
            mean = (values[a, k] + values[b, k]) / 2
            values[i, k] = mean + fraction[i] * (values[i, k] - mean)
    return values


def _steps(where: Places, deepest: int) -> Ints:
    """Spacing of the coarsest lattice with a vertex at each place, in quads of the finest."""
    both = where[:, 0] | where[:, 1]
    coarsest = 1 << (deepest - 1)
    lowest_bit = both & -both
    return np.where(lowest_bit == 0, coarsest, np.minimum(lowest_bit, coarsest))


def place_keys(where: Places) -> Ints:
    """Number of each place, ascending in the order of the places."""
    return (where[:, 0] << 32) | where[:, 1]
