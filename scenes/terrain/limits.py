"""Distances within which the ground is refined: P, R and limit distances of each level of tiles.

For a tile of spacing s, where the eye sees ground of mean inclination t (``seen_tilt``):

    P  √(s·(h + (2/π)²·t·s)), the root of the cross-section, as the eye sees it, of a bump that
       this spacing adds: half a wave wide, which is s, and so tall as it is high, h (the RMS of
       its octave, or of ridged relief the height of its crests), and as the ground that it shades
       shows its face, t·s. Its shade is that of half a wave in both directions, whose mean is
       (2/π)² of its greatest
    R  the height that the still shorter octaves, left to the tile's own parts, rarely exceed

The priority of ground is the size of what refining would show, not of what it displaces: a wave
shades and colours the ground as soon as it is wider than a pixel, however low it is. On ground that
is seen edge-on the height decides, and from above the width. What is not seen itself only casts its
shadow, by its height: there t is 0. R is no hard bound: all crests of all octaves in one place
would make one 2 to 3 times as high, which costs steep ground three times the triangles for no
better a skyline (``lodbench study terrain_skyline``). All are the bumps' own, not the tile's, so
the cut does not depend on how many quads a tile has.
"""

import math
from collections.abc import Callable

import numpy as np

from lod.arrays import Reals
from lod.metric import blake
from lod.view import View
from lod.viewing import perceptual_limits
from scenes.sticks.prototype import GROUND_CONTRAST
from scenes.terrain.hidden_relief import seen_slopes
from scenes.terrain.relief import Relief

FULL_DETAIL_PX = 0.5
"""Detail of the ground where the metric is ``full`` [px].

That metric displays everything, and all the relief out to the reach is more than memory can hold:
the ground is then cut by ``blake`` at half a pixel, whatever the detail of the view.
"""

SUN_RAD = math.radians(0.533)
"""Angular diameter of the sun [rad].

Ground out of view is seen only by its shadow, which the sun's disc blurs by this angle as seen from
where it falls, so that no finer detail shows.
"""

UNLIT = 4.0
"""How many times coarser ground out of view is whose shadow does not fall into view either.

It is seen by the light that it sends to other ground alone.
"""

_SHADE = (2 / math.pi) ** 2
_ROUNDS = 30


def priorities(relief: Relief, spacings: Reals, tilt: Reals) -> Reals:
    """Priority P of the tiles of each level, from their spacing and the tilt seen, (l,) [m]."""
    width = _wavelengths(relief, spacings) / 2
    rms = np.array([relief.rms_between(w, 2 * w) for w in (2 * width).tolist()])
    return np.asarray(np.sqrt(width * (relief.bump * rms + _SHADE * tilt * width)))


def ranges(relief: Relief, spacings: Reals) -> Reals:
    """Range R of the tiles of each level, from the spacing of their mesh, (l,) [m]."""
    return relief.likely_below(_wavelengths(relief, spacings))


def seen_tilt(relief: Relief, spacings: Reals, elevation: Reals) -> Reals:
    """Mean inclination of ground towards the eye that sees it, by the area seen, (l,), at most 1.

    It is the mean of the area across the line of sight over that on the map, about as many of
    which turn their face away as waves of four spacings and more make (Smith 1967).

    elevation (l,)  tangent of the elevation at which the eye stands over it
    """
    shortest = 2 * _wavelengths(relief, spacings)
    variance = relief.slope_variances.sum() - relief.left_out_slope_variance(shortest)
    variance = np.maximum(variance, 0.0)
    level = np.zeros((len(spacings), 2))
    to_eye = np.column_stack((np.ones(len(spacings)), level[:, 0], elevation))
    slopes, _ = seen_slopes(level, variance, np.ones(len(spacings)), to_eye)
    return np.minimum(elevation - slopes[:, 0], 1.0)


def limits(relief: Relief, spacings: Reals, view: View) -> tuple[Reals, Reals, Reals, Reals]:
    """Limit distances of the tiles of each level, (l,) each [m].

    They are those in view, hidden in it, out of it, and out of it with their shadows. They do not
    increase with the level, and are infinite for the first one. Air and eye shorten them as they do
    every part's, by the ground's own class of contrast.
    """
    if view.metric.finite:
        limit, m, m_hidden = view.metric.limit, view.m, view.m_offscreen
    else:
        limit, m = blake, FULL_DETAIL_PX * view.camera.pixel_angle
        m_hidden = m / view.offscreen_detail
    m_outside = max(m_hidden, SUN_RAD)
    angles = m, m_hidden, m_outside, UNLIT * m_outside
    R, unseen = ranges(relief, spacings), priorities(relief, spacings, np.zeros(len(spacings)))

    def seen(D: Reals) -> Reals:
        tilt = seen_tilt(relief, spacings, _height_of_eye(relief, view) / np.maximum(D, 1e-9))
        return limit(priorities(relief, spacings, tilt), R, m)

    found = np.stack([limit(unseen, R, angle) for angle in angles])
    if relief.amplitude > 0:
        found[0] = _fixed_point(seen, found[0])
    if view.conditions is not None and view.metric.finite:
        contrast = np.full(len(R), GROUND_CONTRAST)
        pairs = zip(found, angles, strict=True)
        found = np.stack(
            [perceptual_limits(view.conditions, D, contrast, angle) for D, angle in pairs]
        )
    found[2:] *= not view.metric.along_axis
    found[:, 0] = np.inf
    inside, hidden, outside, unlit = map(view.for_both_eyes, np.minimum.accumulate(found, axis=1))
    return inside, hidden, outside, unlit


def _wavelengths(relief: Relief, spacings: Reals) -> Reals:
    """Wavelength of the bumps that each spacing adds, (l,) [m]."""
    return np.minimum(2 * spacings, relief.wavelength)


def _height_of_eye(relief: Relief, view: View) -> float:
    """Height of the eye above the ground under it, at least 0 [m]."""
    camera = view.camera
    return max(float(camera.eye[2] - relief.height(camera.corner, camera.eye[None, :2])[0]), 0.0)


def _fixed_point(limit: Callable[[Reals], Reals], D: Reals) -> Reals:
    """Distances at which ground just as far away has its limit: the tilt falls as they rise."""
    for _ in range(_ROUNDS):
        D = np.sqrt(D * limit(D))
    return D
