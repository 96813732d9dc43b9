"""How shapes that fade are thinned: radii and shares of area of a partly shown part (§2.4)."""

import math

from numba import njit


@njit(cache=True)
def radius_factor(r0, r1, length, share):  # type: ignore[no-untyped-def]
    """Compute the factor on radii of a stick that leaves a share of its mean outline area.

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
    """Compute which share s of its area a leaf appearance shows while a share h of parts is hidden.

    The share s of the leaf appearance and the share 1 − h of the parts overlap by c·s·(1 − h), with
    c the overlap of the two at full size. Covering the same area as before asks for
    s + (1 − h) − c·s·(1 − h) = 1, so that s = h/(1 − c·(1 − h)), which is 0 for h = 0 and 1 for
    h = 1. The overlap c is below 1; it is below 0 where both together cover more than their sum.
    """
    return hidden / (1.0 - overlap * (1.0 - hidden))
