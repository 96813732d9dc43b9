"""Distances within which the ground is refined: P, R and limit distances of each level of tiles.

For a tile of spacing s:

    P  √(width × amplitude) of the bumps that this spacing adds: half their wavelength, which is s,
       × their height: RMS, or of ridged relief its crests'
    R  the height that the still shorter octaves, left to the tile's own parts, rarely exceed

The priority of ground is the size of what refining would show, not of what it displaces: a wave
shades and colours the ground as soon as it is wider than a pixel, however low it is. R is no hard
bound: all crests of all octaves in one place would make one 2 to 3 times as high, which costs steep
ground three times the triangles for no better a skyline (``lodbench study terrain_skyline``). Both
are the bumps' own, not the tile's, so the cut does not depend on how many quads a tile has.
"""

import math

import numpy as np

from lod.arrays import Reals
from lod.metric.family import blake
from lod.pruning.view import View
from lod.vision.viewer import perceptual_limits
from scenes.sticks.contrast import GROUND_CONTRAST
from scenes.terrain.relief import Relief

FULL_DETAIL_PX = 0.5
"""Detail of the ground where the metric is ``full`` [px].

That metric displays everything, and all the relief out to the reach is more than memory can hold:
the ground is then cut by ``blake`` at half a pixel, whatever the detail of the view.
"""


def sizes(relief: Relief, spacings: Reals) -> tuple[Reals, Reals]:
    """Priority P and range R of the tiles of each level, from the spacing of their mesh [m]."""
    wavelength = np.minimum(2 * spacings, relief.wavelength)
    rms = np.array([relief.rms_between(w, 2 * w) for w in wavelength.tolist()])
    R = relief.likely_below(wavelength)
    return np.sqrt(wavelength / 2 * relief.bump * rms), R


SUN_RAD = math.radians(0.533)
"""Angular diameter of the sun [rad].

Ground out of view is seen only by its shadow, which the sun's disc blurs by this angle as seen from
where it falls, so that no finer detail shows.
"""


def limits(P: Reals, R: Reals, view: View) -> tuple[Reals, Reals, Reals]:
    """Limit distances of the tiles of each level: in view, hidden in it, and out of it, (l,) [m].

    They do not increase with the level, and are infinite for the first one. Air and eye shorten
    them as they do every part's, by the ground's own class of contrast.
    """
    if view.metric.finite:
        limit, m, m_hidden = view.metric.limit, view.m, view.m_offscreen
    else:
        limit, m = blake, FULL_DETAIL_PX * view.camera.pixel_angle
        m_hidden = m / view.offscreen_detail
    angles = m, m_hidden, max(m_hidden, SUN_RAD)
    found = np.stack([limit(P, R, angle) for angle in angles])
    if view.conditions is not None and view.metric.finite:
        contrast = np.full(len(P), GROUND_CONTRAST)
        pairs = zip(found, angles, strict=True)
        found = np.stack(
            [perceptual_limits(view.conditions, D, contrast, angle) for D, angle in pairs]
        )
    found[2] *= not view.metric.along_axis
    found[:, 0] = np.inf
    inside, hidden, outside = map(view.for_both_eyes, np.minimum.accumulate(found, axis=1))
    return inside, hidden, outside
