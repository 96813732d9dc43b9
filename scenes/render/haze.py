"""Transmittance T and airlight L_air of the air along rays, for L·T + L_air·(1 − T).

This is Koschmieder's law (1924) with T = exp(−∫β); β has one value for each band of the picture.
``air_along`` alone says what T and the added light of a ray are. jit.py calls it for samples, on
Dr.Jit arrays, and scalar_passes.py for means over pixels, on NumPy arrays; neither does where the
renderer traces the air itself as a medium.

With analytic haze L_air is the sky's radiance at the horizon in the ray's azimuth. A ray that meets
nothing has T = 0 below the elevation ``HORIZON_DEG`` and shows the airlight alone. Above it the ray
shows the sky of the sky model, which includes the haze of the atmosphere already, so that T is that
of the mist alone, which the model does not include.

With scattered haze L_air is the source term of the air along the path, tabulated by direction and
distance. A ray that meets nothing shows the sky through the scattering layer, from a table.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from lod.air import Air, Mist, haze_extinction, mist_extinction
from scenes.render.build import BuiltScene
from scenes.render.light import HORIZON_DEG, Bands, horizon, sun_disc, variant_bands
from scenes.render.scattered_layer import NEAR_M, RATIO, ScatteringLayer

_NO_END = 1e30


@dataclass(frozen=True, eq=False)
class Haze:
    """Air and airlight of a frame: what the drivers need to finish a sample.

    air             extinction of haze and mist
    bands           bands of the picture
    eye_m           height of the eye above the datum
    airlight_table  (planes, rows, columns, bands) radiance of an endless path, by distance (plane
                    k is at NEAR_M·RATIO**k) and direction: rows are even in the root of the sine of
                    elevation, either way from the horizon, where views change most
    sky_table       (rows, columns, bands) radiance of the sky as it appears through the scattering
                    layer, by direction (see light.row_upper); None with analytic haze, where rays
                    that meet nothing keep the radiance that the renderer traced
    horizon_sine    sine of the elevation below which a ray that meets nothing shows the airlight
                    alone: that of HORIZON_DEG, or 0 with scattered haze
    to_sun          (3,) unit vector to the sun
    sun             (bands,) radiance of the sun's disc
    sun_cosine      cosine of the disc's angular radius
    """

    air: Air
    bands: Bands
    eye_m: float
    airlight_table: np.ndarray
    sky_table: np.ndarray | None
    horizon_sine: float
    to_sun: np.ndarray
    sun: np.ndarray
    sun_cosine: float


def make_haze(built: BuiltScene, air: Air) -> Haze:
    """Make the haze of a built scene, with scattered light where the scene has a layer."""
    light = built.description["light"]
    sun, cosine = sun_disc(light)
    layer: ScatteringLayer | None = light.get("scattering_layer")
    return Haze(
        air=air,
        bands=variant_bands(),
        eye_m=float(built.description["camera"]["eye"][2]),
        airlight_table=layer.airlight_table if layer else horizon(light)[None, None],
        sky_table=layer.sky_from_eye if layer else None,
        horizon_sine=0.0 if layer else float(np.sin(np.radians(HORIZON_DEG))),
        to_sun=light["to_sun"],
        sun=sun * layer.sun_to_eye if layer else sun,
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
    log: Any = np.log
    sqrt: Any = np.sqrt
    floor: Any = np.floor
    minimum: Any = np.minimum
    maximum: Any = np.maximum
    clip: Any = np.clip
    atan2: Any = np.arctan2
    mulsign: Any = np.copysign
    fma: Any = staticmethod(lambda a, b, c: a * b + c)
    dot: Any = staticmethod(lambda d, v: d.x * v[0] + d.y * v[1] + d.z * v[2])
    number: Any = staticmethod(lambda value: value)
    colour: Any = staticmethod(lambda values: values)
    index: Any = staticmethod(lambda values: values.astype(np.int64))
    table: Any = staticmethod(lambda values: values.reshape(-1, values.shape[-1]))
    take: Any = staticmethod(lambda table, index: table[index[..., 0]])

    @staticmethod
    def mean_exponential(x: Any) -> Any:
        """(1 − exp(−x))/x, the mean of exp(−t) from 0 to x."""
        return np.where(x > 0, -np.expm1(-x) / np.where(x > 0, x, 1.0), 1.0)


class JitArrays(NumpyArrays):
    """The same on Dr.Jit arrays; constants are inputs of the kernel (``dr.opaque``).

    That is a barrier to Dr.Jit's optimiser: a kernel is not compiled anew when the numbers change.
    """

    select, exp, log, sqrt, floor = dr.select, dr.exp, dr.log, dr.sqrt, dr.floor
    minimum, maximum, clip, atan2, mulsign = dr.minimum, dr.maximum, dr.clip, dr.atan2, dr.mulsign
    fma: Any = staticmethod(dr.fma)
    dot: Any = staticmethod(lambda way, vector: dr.dot(way, mi.Vector3f(JitArrays.colour(vector))))
    number: Any = staticmethod(lambda value: dr.opaque(mi.Float, value))
    colour: Any = staticmethod(lambda v: mi.Color3f(*map(JitArrays.number, map(float, v))))
    index: Any = staticmethod(lambda values: mi.UInt32(values))
    table: Any = staticmethod(lambda values: mi.Float(values.astype(np.float32).reshape(-1)))
    take: Any = staticmethod(lambda table, index: dr.gather(mi.Color3f, table, index))

    @staticmethod
    def mean_exponential(x: Any) -> Any:
        """Below 2e-3 it is 1 − x/2, in float32 more exactly than by its own formula."""
        return dr.select(x > 2e-3, (1 - dr.exp(-x)) / x, 1 - x / 2)


Arrays = type[NumpyArrays]


def air_along(
    haze: Haze, distance: Any, direction: Any, below_horizon: Any, of: Arrays
) -> tuple[Any, Any]:
    """T of rays and the light that the air adds to each; distance 0 says that a ray met nothing.

    ``below_horizon`` says which of those show the airlight alone; a sky table needs no such mask.
    The sun's disc is among what is added where the sky is open.
    """
    met = distance > 0
    depth = distance * of.colour(haze_extinction(haze.air, haze.bands.wavelengths))
    if haze.air.mist:
        metres = _mist_equivalent_length(
            haze.air.mist, haze.eye_m, distance, direction.z, haze.horizon_sine, of
        )
        depth = depth + metres * of.colour(mist_extinction(haze.air, haze.bands.wavelengths))
    transmittance = of.exp(-depth)
    airlight = _airlight(haze, direction, of.select(met, distance, _NO_END), of)
    disc = of.dot(direction, haze.to_sun) > haze.sun_cosine
    sun = of.select(disc & ~met, of.colour(haze.sun), 0.0)
    if haze.sky_table is None:
        through = of.select(met | ~below_horizon, transmittance, 0.0)
        return through, airlight * (1 - through) + sun * transmittance
    # The table includes what the air does to the sky.
    row = of.sqrt(of.maximum(direction.z, 0.0)) * (len(haze.sky_table) - 1)
    sky = _interpolate(haze.sky_table, row, direction, of)
    sky = of.select(direction.z > haze.horizon_sine, sky, airlight) + sun
    through = of.select(met, transmittance, 0.0)
    return through, of.select(met, airlight * (1 - through), sky)


def _mist_equivalent_length(
    mist: Mist, eye_m: float, distance: Any, rise: Any, horizon_sine: float, of: Arrays
) -> Any:
    """Length [m] of a path at the mist's base with as much mist as each ray, as lod.air has it."""
    scale, start = of.number(mist.scale_m), of.number(eye_m - mist.base_m)
    end = of.fma(distance, rise, start)
    lower, upper = of.minimum(start, end), of.maximum(start, end)
    lower_above, upper_above = of.maximum(lower, 0.0), of.maximum(upper, 0.0)
    height = of.select(upper > lower, upper - lower, 1.0)
    above = of.select(upper > lower, (upper_above - lower_above) / height, 1.0)
    mean = of.mean_exponential((upper_above - lower_above) / scale)
    share = 1 - above + above * mean * of.exp(-lower_above / scale)
    beyond = of.maximum(-start, 0.0) + scale * of.exp(-of.maximum(start, 0.0) / scale)
    return of.select(distance > 0, distance * share, beyond / of.maximum(rise, horizon_sine))


def _airlight(haze: Haze, direction: Any, distance: Any, of: Arrays) -> Any:
    """Look up the airlight of paths of a length [m] from the eye, between planes of the table."""
    planes, rows = haze.airlight_table.shape[:2]
    table = haze.airlight_table.reshape(planes * rows, *haze.airlight_table.shape[2:])
    root = of.mulsign(of.sqrt(abs(direction.z)), direction.z)
    row = of.clip((root + 1) / 2 * (rows - 1), 0.0, rows - 1.0)
    if planes == 1:
        return _interpolate(table, row, direction, of)
    plane = of.log(of.maximum(distance, NEAR_M) / NEAR_M) / math.log(RATIO)
    plane = of.clip(plane, 0.0, planes - 1.0)
    near_plane = of.floor(plane)
    far_plane = of.minimum(near_plane + 1, planes - 1.0)
    near = _interpolate(table, near_plane * rows + row, direction, of)
    far = _interpolate(table, far_plane * rows + row, direction, of)
    return of.fma(far - near, plane - near_plane, near)


def _interpolate(table: np.ndarray, row: Any, direction: Any, of: Arrays) -> Any:
    """Interpolate a table (rows, columns, bands) between rows and azimuths clockwise from north."""
    rows, columns = table.shape[:2]
    values = of.table(table)
    turn = of.atan2(direction.x, direction.y) / (2 * math.pi)
    row, column = of.clip(row, 0.0, rows - 1.0), (turn - of.floor(turn)) * columns
    low, west = of.floor(row), of.floor(column)
    lower, left = of.index(low), of.index(west)
    upper, left, right = of.minimum(lower + 1, rows - 1), left % columns, (left + 1) % columns

    def between(line: Any) -> Any:
        first = of.take(values, line * columns + left)
        return of.fma(of.take(values, line * columns + right) - first, column - west, first)

    below = between(lower)
    return of.fma(between(upper) - below, row - low, below) if rows > 1 else below
