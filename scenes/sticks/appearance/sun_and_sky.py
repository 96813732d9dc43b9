"""Sun and sky as paths of light meet them, and the directions in which surfaces scatter."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit

from scenes.sticks.appearance.sky import ELEVATIONS_DEG, Sky


class SunAndSky(NamedTuple):
    """Light on a stand for t azimuths of the sun at one elevation.

    to_sun (t, 3), azimuth (t,)  unit vectors to the sun, and its azimuths [rad]
    sun (3,)       what the sun gives of the light on level ground
    sky (r, c, 3)  radiance of the cells of the sky (``scenes.sticks.appearance.sky``)
    """

    to_sun: np.ndarray
    azimuth: np.ndarray
    sun: np.ndarray
    sky: np.ndarray

    @staticmethod
    def at_azimuths(elevation_deg: float, azimuths_deg: Sequence[float], sky: Sky) -> "SunAndSky":
        """Compute the light of a sky and of its sun at azimuths from that of the lines of sight.

        At azimuth 0 the sun is behind the viewer. The sun is no lower than the table of skies has
        it (``scenes.sticks.appearance.sky``): of a lower one the sky is that of the lowest, too.
        """
        e = math.radians(max(elevation_deg, ELEVATIONS_DEG[0]))
        a = np.radians(azimuths_deg)
        level = math.cos(e)
        up = np.full(len(a), math.sin(e))
        to_sun = np.column_stack((level * np.cos(a), level * np.sin(a), up))
        return SunAndSky(to_sun, a, 1 - sky.share, sky.radiance)


@njit(cache=True)
def cosine_direction(normal, u0, u1):  # type: ignore[no-untyped-def]
    """Direction about a normal, drawn by its cosine (frame: Duff et al., JCGT 6(1), 2017)."""
    r, turn = math.sqrt(u0), 2 * math.pi * u1
    x, y, z = normal
    sign = math.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    cos, sin, rise = r * math.cos(turn), r * math.sin(turn), math.sqrt(1 - u0)
    return np.array(
        (
            cos * (1.0 + sign * x * x * a) + sin * b + rise * x,
            cos * sign * b + sin * (sign + y * y * a) + rise * y,
            -cos * sign * x - sin * y + rise * z,
        )
    )
