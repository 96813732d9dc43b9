"""How near the ground must be for its next finer tiles: P and R of each level, and their limits.

For a tile of spacing s (DESIGN §1):

    P  √(width × amplitude) of the bumps that this spacing adds: half their wavelength, which is s,
       × their RMS height
    R  the height that the still shorter octaves, left to the tile's own parts, rarely exceed

R is no hard bound: all crests of all octaves in one place would make one 2 to 3 times as high,
which steep ground pays for with three times the triangles and no better a skyline
(``bench.terrain_benchmark``).
Both are the bumps' own, not the tile's, so the cut does not depend on how many quads a tile has.
"""

import numpy as np

from lod.arrays import Reals
from lod.metric import blake
from lod.sight import seen_limits
from lod.view import View
from scenes.part_contrast import GROUND_CONTRAST
from scenes.relief import Relief

FULL_DETAIL_PX = 0.5
"""Metric ``full`` asks for everything, and all the relief out to the reach is more than memory can
hold: there the ground is cut by ``blake`` at half a pixel, whatever the detail of the view."""


def sizes(relief: Relief, spacings: Reals) -> tuple[Reals, Reals]:
    """P and R of the tiles of each level, by the spacing of their mesh [m]."""
    wavelength = np.minimum(2 * spacings, relief.wavelength)
    rms = np.array([relief.rms_between(w, 2 * w) for w in wavelength.tolist()])
    R = np.array([relief.likely_below(w) for w in wavelength.tolist()])
    return np.sqrt(wavelength / 2 * rms), R


def limits(P: Reals, R: Reals, view: View) -> tuple[Reals, Reals]:
    """Limit distance of the tiles of each level, in view and out of it, never growing [m].

    Through air and eye as of every part, by the ground's own class of contrast. Those of the first
    level have none.
    """
    if view.metric.finite:
        limit, m, m_outside = view.metric.limit, view.m, view.m_offscreen
    else:
        limit, m = blake, FULL_DETAIL_PX * view.camera.pixel_angle
        m_outside = m / view.offscreen_detail
    both = np.stack((limit(P, R, m), limit(P, R, m_outside)))
    if view.sight is not None and view.metric.finite:
        contrast, angles = np.full(len(P), GROUND_CONTRAST), (m, m_outside)
        pairs = zip(both, angles, strict=True)
        both = np.stack([seen_limits(view.sight, D, contrast, angle) for D, angle in pairs])
    both[1] *= not view.metric.along_axis
    both[:, 0] = np.inf
    inside, outside = np.minimum.accumulate(both, axis=1)
    return inside, outside
