"""What covers less than all of itself: a share of its area, for what fades (§2.4)."""

import math

from numba import njit


@njit(cache=True)
def radius_factor(r0, r1, length, share):  # type: ignore[no-untyped-def]
    """What to multiply both radii of a stick by, for it to have this share of its mean outline.

    A stick of radii r₀, r₁ and length L has a quarter of its surface as mean outline (Cauchy):
    caps π(r₀² + r₁²)/2 and a flank π(r₀ + r₁)L/4, but for a term of (r₀ − r₁)². Radii times f
    make that f²·caps + f·flank: f is about the share for long sticks, its root for round blobs.
    """
    caps = (r0 * r0 + r1 * r1) / 2
    flank = (r0 + r1) * length / 4
    area = share * (caps + flank)
    return 2 * area / (flank + math.sqrt(flank * flank + 4 * caps * area))


@njit(cache=True)
def leaf_area_share(hidden, overlap):  # type: ignore[no-untyped-def]
    """Share of its area that a leaf appearance shows for a share h of its parts that is hidden.

    The shares s of the one and 1 − h of the others hide s·(1 − h)·c of one another, c the overlap,
    as what lies here and there in the same outline does: s + (1 − h) − c·s·(1 − h) = 1 gives
    s = h/(1 − c·(1 − h)), all for all and none for none. c is below 1; below 0 where the two are
    more together than either alone.
    """
    return hidden / (1.0 - overlap * (1.0 - hidden))
