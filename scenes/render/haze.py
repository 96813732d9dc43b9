"""Haze along a ray, in closed form: L·T + L_air·(1 − T), T = exp(−∫β) (Koschmieder 1924).

β has one value for each band of the picture. L_air is the airlight in the ray's azimuth. Rays that
meet nothing and go below ``HORIZON_DEG`` get it whole. Above it they get the sky as it is, which
holds its haze already; mist, which it does not hold, veils it on the way out.
"""

from dataclasses import dataclass

import numpy as np

from lod.air import Air, PathBands, extinction, mist_extinction, optical_depth
from lod.arrays import Reals
from lod.mist import depth_beyond
from scenes.render.airlight import HORIZON_DEG, horizon
from scenes.render.bands import Bands
from scenes.render.build import Built, bands, sun_disc
from scenes.render.describe import Description
from scenes.render.scattered import scattered


@dataclass(frozen=True, eq=False)
class Haze:
    """What the drivers need to finish a sample.

    air       what lies in between; bands of the picture, wavelengths of which are (bands,) [nm]
    eye_m     height of the eye above the datum
    airlight  (n + 1, bands) radiance at the horizon, by azimuth, evenly spaced; last row = first
    lowest    sine of the elevation below which a ray that meets nothing gets the airlight
    to_sun    (3,); sun (bands,) radiance of the disc; sun_cosine of its angular radius
    """

    air: Air
    bands: Bands
    eye_m: float
    airlight: np.ndarray
    lowest: float
    to_sun: np.ndarray
    sun: np.ndarray
    sun_cosine: float

    @property
    def wavelengths(self) -> np.ndarray:
        """Of the bands [nm]."""
        return self.bands.wavelengths


def haze_of(built: Built, air: Air, kind: str = "analytic") -> Haze:
    """The air of a built scene, its airlight that of ``kind`` (one of frame.HAZES)."""
    light = built.description["light"]
    sun, cosine = sun_disc(light)
    return Haze(
        air=air,
        bands=bands(),
        eye_m=float(built.description["camera"]["eye"][2]),
        airlight=_airlight(built.description, air, kind),
        lowest=float(np.sin(np.radians(HORIZON_DEG))),
        to_sun=light["to_sun"],
        sun=sun,
        sun_cosine=cosine,
    )


def _airlight(description: Description, air: Air, kind: str) -> np.ndarray:
    if kind != "scattered":
        return horizon(description["light"])
    beta = extinction(air, description["camera"]["eye"][2:], bands().wavelengths)[0]
    return scattered(description, beta)


def depth_to(haze: Haze, distance: Reals, rise: Reals) -> PathBands:
    """∫β from the eye over each distance [m], in a direction that rises by ``rise`` a metre."""
    start = np.full_like(distance, haze.eye_m)
    return optical_depth(haze.air, start, start + distance * rise, distance, haze.wavelengths)


def depth_of_sky(haze: Haze, rise: Reals) -> PathBands:
    """∫β of the mist from the eye to where it ends, upwards: what veils the sky."""
    beta = mist_extinction(haze.air, haze.wavelengths)
    if haze.air.mist is None:
        return np.zeros((len(rise), len(beta)))
    return depth_beyond(haze.air.mist, np.full_like(rise, haze.eye_m), rise)[:, None] * beta


def airlight_towards(haze: Haze, directions: np.ndarray) -> np.ndarray:
    """Airlight in the azimuth of each direction, (…, 3) → (…, 3)."""
    turn = np.arctan2(directions[..., 0], directions[..., 1]) / (2 * np.pi) % 1.0
    at = turn * (len(haze.airlight) - 1)
    row = np.minimum(at.astype(np.int64), len(haze.airlight) - 2)
    share = (at - row)[..., None]
    return haze.airlight[row] * (1 - share) + haze.airlight[row + 1] * share
