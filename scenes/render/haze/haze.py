"""Haze along a ray, in closed form: L·T + L_air·(1 − T), T = exp(−∫β) (Koschmieder 1924).

β has one value for each band of the picture. Analytic: L_air is the horizon's sky in the ray's
azimuth. Rays that meet nothing and go below ``HORIZON_DEG`` get it whole. Above it they get the sky
as it is, which holds its haze already; mist, which it does not hold, veils it on the way out.

Scattered: L_air is the source term of the air as it lights the path, tabulated by direction and
distance. Rays that meet nothing see the sky through the layer.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.atmosphere.air import Air, PathBands, mist_extinction, optical_depth
from lod.atmosphere.mist import base_equivalent_length
from scenes.render.description.direction_table import (
    azimuth,
    interpolate,
    interpolate_planes,
    row_sqrt_sine,
    row_upper,
)
from scenes.render.haze.horizon_airlight import HORIZON_DEG, horizon
from scenes.render.haze.scattered_layer import NEAR_M, RATIO, Layer
from scenes.render.mitsuba.bands import Bands
from scenes.render.mitsuba.build import BuiltScene
from scenes.render.mitsuba.emitters import sun_disc, variant_bands


@dataclass(frozen=True, eq=False)
class Haze:
    """Air and airlight of a frame: what the drivers need to finish a sample.

    air       what lies in between; bands of the picture, wavelengths of which are (bands,) [nm]
    eye_m     height of the eye above the datum
    airlight  (planes, rows, columns, bands) by distance (see ``plane_index``) and direction
        (scenes.render.description.direction_table.row_sqrt_sine)
    seen      (rows, columns, bands) of what meets nothing, see row_upper; None = as it is rendered
    lowest    sine of the elevation below which a ray that meets nothing gets the airlight
    to_sun    (3,); sun (bands,) radiance of the disc; sun_cosine of its angular radius
    """

    air: Air
    bands: Bands
    eye_m: float
    airlight: np.ndarray
    seen: np.ndarray | None
    lowest: float
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
    layer: Layer | None = light.get("layer")
    return Haze(
        air=air,
        bands=variant_bands(),
        eye_m=float(built.description["camera"]["eye"][2]),
        airlight=layer.airlight if layer else horizon(light)[None, None],
        seen=layer.seen if layer else None,
        lowest=0.0 if layer else float(np.sin(np.radians(HORIZON_DEG))),
        to_sun=light["to_sun"],
        sun=sun * layer.through_to_sun if layer else sun,
        sun_cosine=cosine,
    )


def optical_depth_to(haze: Haze, distance: Reals, rise: Reals) -> PathBands:
    """Integrate β from the eye over each distance [m], along a line that rises ``rise`` a metre."""
    start = np.full_like(distance, haze.eye_m)
    return optical_depth(haze.air, start, start + distance * rise, distance, haze.wavelengths)


def mist_transmittance(haze: Haze, directions: np.ndarray) -> np.ndarray:
    """Transmittance of the mist between the eye and open sky, (…, 3) → (…, bands).

    Below the horizon it is as at the horizon. It is 1 where ``seen`` holds the mist already.
    """
    rise = np.maximum(directions[..., 2].astype(np.float64).ravel(), haze.lowest)
    if haze.seen is not None or haze.air.mist is None:
        return np.ones((*directions.shape[:-1], len(haze.wavelengths)))
    metres = base_equivalent_length(haze.air.mist, np.full_like(rise, haze.eye_m), rise)
    depth = metres[:, None] * mist_extinction(haze.air, haze.wavelengths)
    return np.exp(-depth).reshape(*directions.shape[:-1], -1)


def sky_through_air(
    haze: Haze, directions: np.ndarray, low: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Share of the rendered sky that rays show which meet nothing, and the light added to it.

    Both are (…, bands). ``low`` (…) says which rays show the airlight alone.
    """
    air = airlight_along(haze, directions, np.full(low.shape, np.inf))
    if haze.seen is None:
        through = np.where(low[..., None], 0.0, mist_transmittance(haze, directions))
        return through, air * (1 - through)
    up = directions[..., 2]
    sky = interpolate(haze.seen, row_upper(len(haze.seen), up), azimuth(directions))
    return np.zeros_like(sky), np.where(up[..., None] > 0, sky, air)


def airlight_along(haze: Haze, directions: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Look up the airlight of paths of a length (…) [m] from the eye, (…, bands)."""
    row = row_sqrt_sine(haze.airlight.shape[1], directions[..., 2])
    return interpolate_planes(haze.airlight, plane_index(distance), row, azimuth(directions))


def plane_index(distance: np.ndarray) -> np.ndarray:
    """Place of distances [m] among the planes of a table, which stand at NEAR_M·RATIO**k."""
    return np.log(np.maximum(distance, NEAR_M) / NEAR_M) / np.log(RATIO)
