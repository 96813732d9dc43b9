"""Haze along rays: what a ray loses to the air, and the airlight that it gains.

The air along rays has transmittance T and airlight L_air: L·T + L_air·(1 − T) is Koschmieder's law
(1924) with T = exp(−∫β); β has one value for each band of the picture.
``air_along`` alone says what T and the added light of a ray are. jit.py calls it for samples, on
Dr.Jit arrays, and scalar_passes.py for means over pixels, on NumPy arrays; neither does where the
renderer traces the air itself as a medium.

With analytic haze L_air is the sky's radiance at the horizon in the ray's azimuth, so that land
fades into the sky. A ray that meets nothing has T = 0 below the elevation ``HORIZON_DEG`` and shows
the airlight alone. Above it the ray shows the sky of the sky model, which includes the haze of the
atmosphere already, so that T is 1.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from lod.air import Air, haze_extinction
from scenes.render.description import Description
from scenes.render.light import Bands, sky_radiance, sun_disc, variant_bands

HORIZON_DEG = 0.5
"""Elevation of the airlight: the sky model darkens towards 0°, within its last half degree."""

AZIMUTHS = 1440  # rows of a table of airlight, evenly spaced clockwise from north


def horizon(light: Description) -> np.ndarray:
    """Radiance at the horizon by azimuth, (AZIMUTHS, bands); never negative."""
    angles, up = np.arange(AZIMUTHS) / AZIMUTHS * 2 * np.pi, np.radians(HORIZON_DEG)
    east, north = np.cos(up) * np.sin(angles), np.cos(up) * np.cos(angles)
    return sky_radiance(light, np.stack((east, north, np.full(AZIMUTHS, np.sin(up))), axis=1))


@dataclass(frozen=True, eq=False)
class Haze:
    """Air and airlight of a frame: what the drivers need to finish a sample.

    air             extinction of haze
    bands           bands of the picture
    airlight_table  (columns, bands) radiance of an endless path, by azimuth
    horizon_sine    sine of the elevation below which a ray that meets nothing shows the airlight
                    alone: that of HORIZON_DEG
    to_sun          (3,) unit vector to the sun
    sun             (bands,) radiance of the sun's disc
    sun_cosine      cosine of the disc's angular radius
    """

    air: Air
    bands: Bands
    airlight_table: np.ndarray
    horizon_sine: float
    to_sun: np.ndarray
    sun: np.ndarray
    sun_cosine: float


def make_haze(light: Description, air: Air) -> Haze:
    """Make the haze of a scene in that light."""
    sun, cosine = sun_disc(light)
    return Haze(
        air=air,
        bands=variant_bands(),
        airlight_table=horizon(light),
        horizon_sine=float(np.sin(np.radians(HORIZON_DEG))),
        to_sun=light["to_sun"],
        sun=sun,
        sun_cosine=cosine,
    )


class Direction(NamedTuple):
    """Unit directions east, north and up, (…, 1) each, as Dr.Jit's vectors have them."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray


class NumpyArrays:
    """What ``air_along`` does to numbers, on NumPy arrays: rays (…, 1) and colours (…, bands)."""

    select: Any = np.where
    exp: Any = np.exp
    floor: Any = np.floor
    atan2: Any = np.arctan2
    fma: Any = staticmethod(lambda a, b, c: a * b + c)
    dot: Any = staticmethod(lambda d, v: d.x * v[0] + d.y * v[1] + d.z * v[2])
    colour: Any = staticmethod(lambda values: values)
    index: Any = staticmethod(lambda values: values.astype(np.int64))
    table: Any = staticmethod(lambda values: values)
    take: Any = staticmethod(lambda table, index: table[index[..., 0]])


class JitArrays(NumpyArrays):
    """The same on Dr.Jit arrays; constants are inputs of the kernel (``dr.opaque``).

    That is a barrier to Dr.Jit's optimiser: a kernel is not compiled anew when the numbers change.
    """

    select, exp, floor, atan2 = dr.select, dr.exp, dr.floor, dr.atan2
    fma: Any = staticmethod(dr.fma)
    dot: Any = staticmethod(lambda way, vector: dr.dot(way, mi.Vector3f(JitArrays.colour(vector))))
    colour: Any = staticmethod(lambda v: mi.Color3f(*(dr.opaque(mi.Float, float(n)) for n in v)))
    index: Any = staticmethod(lambda values: mi.UInt32(values))
    table: Any = staticmethod(lambda values: mi.Float(values.astype(np.float32).reshape(-1)))
    take: Any = staticmethod(lambda table, index: dr.gather(mi.Color3f, table, index))


Arrays = type[NumpyArrays]


def air_along(
    haze: Haze, distance: Any, direction: Any, below_horizon: Any, of: Arrays
) -> tuple[Any, Any]:
    """T of rays and the light that the air adds to each; distance 0 says that a ray met nothing.

    ``below_horizon`` says which of those show the airlight alone.
    The sun's disc is among what is added where the sky is open.
    """
    met = distance > 0
    depth = distance * of.colour(haze_extinction(haze.air, haze.bands.wavelengths))
    transmittance = of.exp(-depth)
    airlight = _airlight(haze.airlight_table, direction, of)
    disc = of.dot(direction, haze.to_sun) > haze.sun_cosine
    sun = of.select(disc & ~met, of.colour(haze.sun), 0.0)
    through = of.select(met | ~below_horizon, transmittance, 0.0)
    return through, airlight * (1 - through) + sun


def _airlight(table: np.ndarray, direction: Any, of: Arrays) -> Any:
    """Interpolate a table (columns, bands) between azimuths clockwise from north."""
    values, columns = of.table(table), len(table)
    turn = of.atan2(direction.x, direction.y) / (2 * math.pi)
    column = (turn - of.floor(turn)) * columns
    west = of.floor(column)
    left = of.index(west)
    first = of.take(values, left % columns)
    return of.fma(of.take(values, (left + 1) % columns) - first, column - west, first)
