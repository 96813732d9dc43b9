"""Sums of octaves that go on from those of the frame before, to the same last bit.

Octaves stand longest first, and the nearer a point, the more of them count whole: the sum of those
that do is the beginning of every longer one. So it is kept, point by point, and a frame adds what
has come to count since, and what still fades.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Int64
from numba import njit


@dataclass(frozen=True, eq=False)
class SoFar:
    """Sums of whole octaves at points, for c shortest wavelengths at each; they are written on.

    whole (n, c) int8   octaves that are in each sum
    sums  (n, 2c)       two for each of ``whole``
    """

    whole: np.ndarray
    sums: np.ndarray

    def __getitem__(self, rows: slice) -> "SoFar":
        """Those of a run of points, the very same numbers."""
        return SoFar(self.whole[rows], self.sums[rows])

    @staticmethod
    def none(points: int, columns: int) -> "SoFar":
        """Nothing is summed yet."""
        return SoFar(np.zeros((points, columns), np.int8), np.zeros((points, 2 * columns)))

    def carried(self, row: Int64[np.ndarray, " n"], points: int) -> "SoFar":
        """The same for so many points, the first of which were the ones of ``row`` here, or −1."""
        found = SoFar.none(points, self.whole.shape[1])
        _carry(row, self.whole, self.sums, found.whole, found.sums)
        return found


@njit(cache=True, nogil=True)
def _carry(row, whole, sums, to_whole, to_sums):  # type: ignore[no-untyped-def]
    for i in range(len(row)):
        if row[i] >= 0:
            to_whole[i] = whole[row[i]]
            to_sums[i] = sums[row[i]]
