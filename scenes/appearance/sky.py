"""The light of sun and sky that comes down on level ground, as paths of light meet it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib import resources
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from lod.kernels import njit
from scenes.processes.cache import content_key, kept

SKY_ROWS, SKY_COLUMNS = 8, 6
"""Cells of the sky: rows even in the sine of elevation, columns even in azimuth from the sun.

Columns go up to 180° and are the same on either side of the sun.
"""

ELEVATIONS_DEG = (1.0, 10.0, 20.0, 40.0, 60.0, 85.0)
TURBIDITIES = (2.0, 3.0, 5.0, 10.0)

GRASS = (0.072, 0.135, 0.031), (0.165, 0.178, 0.066)
"""Linear Rec.709 albedo of grassy ground, moist and dry, which also lights what stands on it."""


@dataclass(frozen=True, eq=False)
class Sky(ArrayData):
    """Radiance of the cells of the sky over that of white level ground in the light of sun and sky.

    radiance (SKY_ROWS, SKY_COLUMNS, 3) in red, green and blue
    """

    radiance: FloatArray

    @property
    def share(self) -> Reals:
        """Compute the share of light on level ground that the sky sends, Σ L·∫ sin h dΩ/π, (3,).

        It is at most 1, which rounded figures may exceed.
        """
        found: Reals = np.minimum(cell_irradiance() @ self.radiance.reshape(-1, 3), 1.0)
        return found


def cell_irradiance() -> Reals:
    """Compute the irradiance of level ground from cells of the sky of radiance 1/π, (cells,)."""
    edges = np.linspace(0.0, 1.0, SKY_ROWS + 1)
    return np.repeat(np.diff(edges**2), SKY_COLUMNS) / SKY_COLUMNS


@lru_cache(maxsize=16)
def sky_at(elevation_deg: float, turbidity: float) -> Sky:
    """Return the sky with the sun at an elevation, clipped to the range of the table.

    It is Mitsuba's ``sunsky`` (Hosek & Wilkie, "An analytic model for full spectral sky-dome
    radiance", SIGGRAPH 2012), as ``python -m tests.tools.sky_table`` averages it.
    """
    nodes = TURBIDITIES, ELEVATIONS_DEG
    at = [
        float(np.clip(x, n[0], n[-1]))
        for x, n in zip((turbidity, elevation_deg), nodes, strict=True)
    ]

    def interpolated() -> dict[str, np.ndarray]:
        from scipy.interpolate import interpn  # expensive to import, and what it finds is kept

        with (resources.files("scenes.appearance") / "sky.csv").open(encoding="ascii") as file:
            rows = np.loadtxt(file, delimiter=",", skiprows=1)
        radiance = rows[:, -3:].reshape(*map(len, nodes), SKY_ROWS, SKY_COLUMNS, 3)
        return {"radiance": interpn(nodes, radiance, at)[0]}

    return Sky(kept("sky", content_key(*at), interpolated)["radiance"])


class SunAndSky(NamedTuple):
    """Light on a stand for t azimuths of the sun at one elevation.

    to_sun (t, 3), azimuth (t,)  unit vectors to the sun, and its azimuths [rad]
    sun (3,)       what the sun gives of the light on level ground
    sky (r, c, 3)  radiance of the cells of the sky (``scenes.appearance.sky``)
    """

    to_sun: np.ndarray
    azimuth: np.ndarray
    sun: np.ndarray
    sky: np.ndarray

    @staticmethod
    def at_azimuths(elevation_deg: float, azimuths_deg: Sequence[float], sky: Sky) -> "SunAndSky":
        """Compute the light of a sky and of its sun at azimuths from that of the lines of sight.

        At azimuth 0 the sun is behind the viewer. The sun is no lower than the table of skies has
        it (``scenes.appearance.sky``): of a lower one the sky is that of the lowest, too.
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
