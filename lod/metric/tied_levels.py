"""Two levels of the modelling hierarchy that are one object of the display hierarchy (§4.2).

Where a whole has one part only, and that is no smaller, nothing tells their distances of
disappearing apart but rounding: they are to drop in and out of view together. Measured from the
same origin with the same P and R, they do, for every metric, eye and air. An only part that is
smaller than its whole drops out before it, like any other.
"""

import numpy as np

from lod.arrays import Ints, Reals


def representative(whole: Ints, P: Reals) -> Ints:
    """For each part the first of the parts that it is tied to, (n,): itself for most parts.

    whole (n,) row of the part that owns each part, -1 for row 0; P (n,) priorities [m]. A part that
    is tied to its only part counts as large as that part when it is compared with its own whole.
    """
    only = np.bincount(whole[1:], minlength=len(whole)) == 1
    size, tied = P.copy(), np.zeros(len(P), bool)
    for row in range(len(P) - 1, 0, -1):
        if only[whole[row]] and size[row] >= size[whole[row]]:
            tied[row], size[whole[row]] = True, size[row]
    first = np.arange(len(P))
    for row in np.flatnonzero(tied).tolist():
        first[row] = first[whole[row]]
    return first


def max_over_tied(lengths: Reals, first: Ints) -> Reals:
    """Greatest length of all parts that are tied together, for each of them, (n,) [m]."""
    greatest = lengths.copy()
    np.maximum.at(greatest, first, lengths)
    return greatest[first]
