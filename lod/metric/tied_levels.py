"""Which levels of the modelling hierarchy are one object of the display hierarchy (§4.2)?

Where a whole has one part only, and that is no smaller, only rounding would separate their limit
distances, although they should appear and disappear together. Measured from the same origin with
the same P and R, they do, for every metric, eye and air. An only part that is smaller than its
whole disappears before it, like any other.
"""

import numpy as np

from lod.arrays import Ints, Reals


def representative(parent: Ints, P: Reals) -> Ints:
    """Find the first of the parts that each part is tied to, (n,); for most it is the part itself.

    parent (n,) row of the part that owns each part, -1 for row 0; P (n,) priorities [m]. A part
    that is tied to its only part counts as large as that part when it is compared with its own
    whole.
    """
    only = np.bincount(parent[1:], minlength=len(parent)) == 1
    size, tied = P.copy(), np.zeros(len(P), bool)
    for row in range(len(P) - 1, 0, -1):
        if only[parent[row]] and size[row] >= size[parent[row]]:
            tied[row], size[parent[row]] = True, size[row]
    first = np.arange(len(P))
    for row in np.flatnonzero(tied).tolist():
        first[row] = first[parent[row]]
    return first


def max_over_tied(lengths: Reals, first: Ints) -> Reals:
    """Give each part the greatest length of all parts that are tied to it, (n,) [m]."""
    greatest = lengths.copy()
    np.maximum.at(greatest, first, lengths)
    return greatest[first]
