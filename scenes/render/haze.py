"""Transmittance T and airlight L_air of the air along rays, for L·T + L_air·(1 − T).

This is Koschmieder's law (1924) with T = exp(−∫β); β has one value for each band of the picture.
The law is applied in two places, which change together:

    drivers/jit.py, composite_haze             to each sample, on Dr.Jit arrays
    drivers/scalar_passes.py, composite_haze   to the means over each pixel, on NumPy arrays, with
                                               a covariance term: exact while linear in L

Both take the light that the air adds from ``in_scattered_light`` below. The look-ups of airlight
and sky and the path through mist are written twice, too: here (and in lod.air) in NumPy
for drivers/scalar_passes.py, in drivers/jit.py for Dr.Jit, with other rounding. drivers/volpath.py
applies nothing of this: there the renderer traces the air itself as a medium.

With analytic haze L_air is the sky's radiance at the horizon in the ray's azimuth. A ray that meets
nothing has T = 0 below the elevation ``HORIZON_DEG`` and shows the airlight alone. Above it the ray
shows the sky of the sky model, which includes the haze of the atmosphere already, so that T is that
of the mist alone, which the model does not include.

With scattered haze L_air is the source term of the air along the path, tabulated by direction and
distance. A ray that meets nothing shows the sky through the scattering layer, from a table.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from lod.air import Air, PathBands, base_equivalent_length, mist_extinction, optical_depth
from lod.arrays import Reals
from scenes.render.build import BuiltScene
from scenes.render.light import (
    HORIZON_DEG,
    Bands,
    azimuth,
    horizon,
    interpolate,
    interpolate_planes,
    row_sqrt_sine,
    row_upper,
    sun_disc,
    variant_bands,
)
from scenes.render.scattered_layer import NEAR_M, RATIO, ScatteringLayer


@dataclass(frozen=True, eq=False)
class Haze:
    """Air and airlight of a frame: what the drivers need to finish a sample.

    air             extinction of haze and mist
    bands           bands of the picture
    eye_m           height of the eye above the datum
    airlight_table  (planes, rows, columns, bands) radiance of an endless path, by distance (see
                    ``plane_index``) and direction (see direction_table.row_sqrt_sine)
    sky_table       (rows, columns, bands) radiance of the sky as it appears through the scattering
                    layer, by direction (see direction_table.row_upper); None with analytic haze,
                    where rays that meet nothing keep the radiance that the renderer traced
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

    @property
    def wavelengths(self) -> np.ndarray:
        """Effective wavelengths of the bands [nm], (bands,)."""
        return self.bands.wavelengths


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


def in_scattered_light(airlight: Any, transmittance: Any) -> Any:
    """Light that the air adds to a ray, L_air·(1 − T), on NumPy or Dr.Jit arrays of equal shape."""
    return airlight * (1 - transmittance)


def optical_depth_to(haze: Haze, distance: Reals, rise: Reals) -> PathBands:
    """Integrate β from the eye over each distance [m], along a line that rises ``rise`` a metre."""
    start = np.full_like(distance, haze.eye_m)
    return optical_depth(haze.air, start, start + distance * rise, distance, haze.wavelengths)


def mist_transmittance(haze: Haze, directions: np.ndarray) -> np.ndarray:
    """Transmittance of the mist between the eye and open sky, (…, 3) → (…, bands).

    Below the horizon it is as at the horizon. It is 1 where the sky table includes the mist.
    composite_haze of drivers/jit.py does this for Dr.Jit arrays, by mist_equivalent_length.
    """
    rise = np.maximum(directions[..., 2].astype(np.float64).ravel(), haze.horizon_sine)
    if haze.sky_table is not None or haze.air.mist is None:
        return np.ones((*directions.shape[:-1], len(haze.wavelengths)))
    metres = base_equivalent_length(haze.air.mist, np.full_like(rise, haze.eye_m), rise)
    depth = metres[:, None] * mist_extinction(haze.air, haze.wavelengths)
    return np.exp(-depth).reshape(*directions.shape[:-1], -1)


def sky_through_air(
    haze: Haze, directions: np.ndarray, below_horizon: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """T of rays (…) that meet nothing, and the light that is added to it, (…, bands) each.

    ``below_horizon`` (…) says which rays show the airlight alone; a sky table needs no such mask.
    """
    airlight = airlight_along(haze, directions, np.full(below_horizon.shape, np.inf))
    if haze.sky_table is None:
        mist = mist_transmittance(haze, directions)
        transmittance = np.where(below_horizon[..., None], 0.0, mist)
        return transmittance, in_scattered_light(airlight, transmittance)
    up = directions[..., 2]
    sky = interpolate(haze.sky_table, row_upper(len(haze.sky_table), up), azimuth(directions))
    return np.zeros_like(sky), np.where(up[..., None] > 0, sky, airlight)


def airlight_along(haze: Haze, directions: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Look up the airlight of paths of a length (…) [m] from the eye, (…, bands).

    airlight_along of drivers/jit.py does the same for Dr.Jit arrays.
    """
    row = row_sqrt_sine(haze.airlight_table.shape[1], directions[..., 2])
    return interpolate_planes(haze.airlight_table, plane_index(distance), row, azimuth(directions))


def plane_index(distance: np.ndarray) -> np.ndarray:
    """Find the places of distances [m] among a table's planes, plane k being at NEAR_M·RATIO**k."""
    return np.log(np.maximum(distance, NEAR_M) / NEAR_M) / np.log(RATIO)
