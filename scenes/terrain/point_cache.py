"""What is known of the ground's points from the frame before: what is the same in every frame.

At walking pace nearly all vertices of the ground are those of the frame before. Their heights are
the same, and of their slopes and colours, which leave out what is small beside their distance, all
octaves that count whole (``octave_sums``).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from scenes.noise.partial_sums import SoFar
from scenes.terrain.relief import Relief

Place = tuple[Relief, Corner, tuple[float, float], float]
"""Of what ground, from which corner, and the lattice that its points are named by: where it begins
and its spacing [m]."""

SLOPES, PATCHES = 2, 1
"""Shortest wavelengths at a point: of its slopes, and of its patches of colour."""


@dataclass(frozen=True, eq=False)
class Known:
    """Points of the ground that a frame has drawn.

    names (n,) of their places, ascending; heights (n,) [m]; slopes, patches: sums of whole octaves
    """

    place: Place
    names: np.ndarray
    heights: np.ndarray
    slopes: SoFar
    patches: SoFar

    def at(self, names: Int64[np.ndarray, " m"], points: Points) -> "Known":
        """The same of points (n, 3), the first of which have these names, ascending."""
        row, heights = rows_among(self.names, names), points[: len(names), 2].copy()
        sums = (each.carried(row, len(points)) for each in (self.slopes, self.patches))
        return Known(self.place, names, heights, *sums)


@dataclass(eq=False)
class Shelf:
    """Where a frame leaves what it knows for the next one; one sequence of frames has one."""

    known: Known | None = None

    def at(self, place: Place) -> Known:
        """What holds at a place."""
        if self.known is not None and self.known.place == place:
            return self.known
        none = np.zeros(0)
        nothing = SoFar.none(0, SLOPES), SoFar.none(0, PATCHES)
        return Known(place, none.astype(np.int64), none, *nothing)


@njit(cache=True)
def rows_among(known: np.ndarray, names: np.ndarray) -> np.ndarray:
    """Row of each name among those that are known, −1 for others; both ascending, (n,)."""
    row, k = np.full(len(names), -1), 0
    for i in range(len(names)):
        while k < len(known) and known[k] < names[i]:
            k += 1
        if k < len(known) and known[k] == names[i]:
            row[i] = k
    return row


def heights_of(before: Known, names: Ints, xy: np.ndarray) -> Reals:
    """Heights at points (n, 2) of these names, ascending; only what is not known is worked out."""
    relief, corner, *_ = before.place
    row = rows_among(before.names, names)
    new, found = row < 0, np.empty(len(names))
    found[~new] = before.heights[row[~new]]
    found[new] = relief.height(corner, xy[new])
    return found
