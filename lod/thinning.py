"""Sticks that cover less than all of themselves: a share of their area, for what fades (§2.4)."""

import numpy as np

from lod.arrays import Reals
from lod.parts import Sticks


def thinned(sticks: Sticks, share: Reals) -> Sticks:
    """The same sticks with radii such that each has this share (n,) of its mean outline.

    A stick of radii r₀, r₁ and length L has a quarter of its surface as mean outline (Cauchy):
    caps π(r₀² + r₁²)/2 and a flank π(r₀ + r₁)L/4, but for a term of (r₀ − r₁)². Radii times f
    make that f²·caps + f·flank: f is about the share for long sticks, its root for round blobs.
    """
    rows = np.flatnonzero(share != 1.0)
    if not len(rows):
        return sticks
    r0, r1 = sticks.start_radius[rows], sticks.end_radius[rows]
    axis = sticks.end[rows] - sticks.start[rows]
    caps = (r0 * r0 + r1 * r1) / 2
    flank = (r0 + r1) * np.sqrt((axis * axis).sum(axis=1)) / 4
    area = share[rows] * (caps + flank)
    factor = 2 * area / (flank + np.sqrt(flank * flank + 4 * caps * area))
    start_radius, end_radius = sticks.start_radius.copy(), sticks.end_radius.copy()
    start_radius[rows] *= factor
    end_radius[rows] *= factor
    columns = sticks.tint, sticks.tints, sticks.owner
    return Sticks(sticks.start, sticks.end, start_radius, end_radius, *columns)
