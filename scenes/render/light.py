"""Sun and sky of a frame, as Mitsuba's emitters and as radiance by direction and band.

An _rgb variant renders in three bands, each with an effective wavelength; a _spectral variant in as
many as ``EDGES_NM`` leaves room for, and each holds the integral of the radiance over it.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import mitsuba as mi
import numpy as np

from lod.air import rgb_wavelengths
from lod.arrays import freeze
from scenes.render.description import Description

EDGES_NM = np.arange(400.0, 721.0, 20.0)
"""Of the spectral bands: the sky's model ends at 720 nm, and the eye sees 0.1 % beyond the ends."""

_CIE_Y_NM = 106.856895
"""∫ȳdλ of the CIE 1931 2° observer, by which the renderer's _rgb variants divide radiance."""


@dataclass(frozen=True, eq=False)
class Bands:
    """The bands of a picture.

    wavelengths  (n,) effective [nm]
    width        of each [nm]; 0 in _rgb variants, whose bands are no stretches of the spectrum
    to_rgb       (n, 3) what a band adds to linear Rec.709
    """

    wavelengths: np.ndarray
    width: float
    to_rgb: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, wavelengths=np.float64, to_rgb=np.float64)

    @property
    def is_spectral(self) -> bool:
        """Whether they are stretches of a spectrum."""
        return self.width > 0

    @property
    def even(self) -> np.ndarray:
        """Linear Rec.709 that the renderer makes of an albedo of 1, (3,).

        It integrates spectra under even light, not under the D65 that Rec.709 means. Divided by
        this greys are right, and colours nearly.
        """
        return self.width * self.to_rgb.sum(axis=0) if self.is_spectral else np.ones(3)


@lru_cache(maxsize=2)
def make_bands(is_spectral: bool) -> Bands:
    """Make red, green and blue, or bands of equal width over the visible.

    Spectral bands become XYZ by the mean of colour-science's CIE 1931 2° colour matching functions
    over each, and linear Rec.709 by colour-science's matrix.
    """
    if not is_spectral:
        return Bands(rgb_wavelengths(), 0.0, np.eye(3))
    from colour import MSDS_CMFS, RGB_COLOURSPACES, SpectralShape

    centres = (EDGES_NM[1:] + EDGES_NM[:-1]) / 2
    width = float(EDGES_NM[1] - EDGES_NM[0])
    shape = SpectralShape(EDGES_NM[0] + 0.5, EDGES_NM[-1] - 0.5, 1)
    observer = MSDS_CMFS["CIE 1931 2 Degree Standard Observer"].copy().align(shape).values
    mean = observer.reshape(len(centres), -1, 3).mean(axis=1) / _CIE_Y_NM
    to_rgb = RGB_COLOURSPACES["ITU-R BT.709"].matrix_XYZ_to_RGB
    return Bands(centres, width, mean @ to_rgb.T)


def sky(light: Description, sun_scale: float = 1.0, sky_scale: float = 1.0) -> Description:
    """Describe Hosek's and Wilkie's sky and sun, z up; without its sun where ``sun_scale`` is 0."""
    return {
        "type": "sunsky",
        "sun_direction": light["to_sun"].tolist(),
        "turbidity": light["turbidity"],
        "sun_scale": sun_scale,
        "sky_scale": sky_scale,
    }


def emitters(light: Description) -> Description:
    """Describe what lights a scene: the sky without its sun, and the sun."""
    return {"sky": sky(light, sun_scale=0.0), "sun": sun(light)}


def sun_disc(light: Description) -> tuple[np.ndarray, float]:
    """Radiance of the sun's disc, (bands,), never negative, and cosine of its angular radius."""
    emitter = mi.load_dict(sky(light, sky_scale=0.0), parallel=False)
    radius = np.radians(_SUN_APERTURE_DEG / 2)
    return np.maximum(radiance(emitter, light["to_sun"][None])[0], 0.0), float(np.cos(radius))


def variant_bands() -> Bands:
    """The bands of the variant that is set."""
    return make_bands(str(mi.variant()).endswith("_spectral"))


def radiance(emitter: Any, directions: np.ndarray) -> np.ndarray:
    """Radiance of an environment from each direction in each band, (n, 3) → (n, bands)."""
    made = variant_bands()
    if not made.is_spectral:
        return _radiance(emitter, directions)
    columns = [_radiance(emitter, directions, float(nm))[:, 0] for nm in made.wavelengths]
    return made.width * np.stack(columns, axis=1)


def _radiance(emitter: Any, directions: np.ndarray, nm: float = 0.0) -> np.ndarray:
    """(n, 3) → (n, 3), or (n, 4) alike, at one wavelength, in a spectral variant."""
    hit = mi.SurfaceInteraction3f()
    if nm:
        hit.wavelengths = type(hit.wavelengths)(nm)
    if not str(mi.variant()).startswith("scalar_"):
        hit.wi = mi.Vector3f(np.float32(-directions.T))
        return np.array(emitter.eval(hit), np.float64).T
    rows = []
    for direction in directions:
        hit.wi = mi.Vector3f([-float(x) for x in direction])
        rows.append(np.array(emitter.eval(hit), np.float64))
    return np.array(rows)


_SUN_APERTURE_DEG = 0.5358  # the full width of sunsky's sun


def sun_irradiance(light: Description) -> np.ndarray:
    """Irradiance of a surface that faces the sun, E = L·2π(1 − cos r), (bands,)."""
    disc, cosine = sun_disc(light)
    return disc * 2 * np.pi * (1 - cosine)


def sun(light: Description) -> Description:
    """Describe the sun as a directional light of the same irradiance, which has no penumbra."""
    made, irradiance = variant_bands(), sun_irradiance(light)
    colour: Description = {"type": "rgb", "value": irradiance.tolist()}
    if made.is_spectral:
        low, high = made.wavelengths[[0, -1]].tolist()
        values = ",".join(repr(each) for each in (irradiance / made.width).tolist())
        ends = {"wavelength_min": low, "wavelength_max": high}
        colour = {"type": "regular", "values": values, **ends}
    return {
        "type": "directional",
        "direction": (-light["to_sun"]).tolist(),
        "irradiance": colour,
        "sampling_weight": light["weight"],
    }


def sky_radiance(light: Description, directions: np.ndarray) -> np.ndarray:
    """Radiance of the sky without its sun, (n, 3) → (n, bands); the model's negatives become 0."""
    emitter = mi.load_dict(sky(light, sun_scale=0.0), parallel=False)
    return np.maximum(radiance(emitter, directions), 0.0)
