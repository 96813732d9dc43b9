"""The air of a frame: even haze, mist in the valleys, and what a path through them takes away.

The same β paints the haze and prunes the scene: the renderer uses ``haze_extinction`` and
``mist_extinction`` in its bands, the pruner ``least_extinction``.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from lod.atmosphere import mist as layer
from lod.atmosphere.extinction import REFERENCE_NM, Bands, hazy_extinction
from lod.atmosphere.mist import Mist
from lod.atmosphere.rgb_bands import rgb_wavelengths
from lod.errors import InputError

PathBands = Float64[np.ndarray, "n bands"]


@dataclass(frozen=True)
class Air:
    """Haze that is the same everywhere, and mist that thins out upwards; either may be absent.

    visibility_m  Koschmieder visibility (2 %) of the haze [m]; None = clear, β = 0
    mist          a second layer, whose β is added
    """

    visibility_m: float | None = None
    mist: Mist | None = None

    def __post_init__(self) -> None:
        if self.visibility_m is not None:
            hazy_extinction(self.visibility_m, np.array([REFERENCE_NM]))


CLEAR = Air()


def haze_extinction(air: Air, wavelengths_nm: Bands) -> Bands:
    """Compute β of the even haze at each wavelength [1/m].

    In clear air it is 0, without Rayleigh's extinction.
    """
    if air.visibility_m is None:
        return np.zeros_like(wavelengths_nm)
    return hazy_extinction(air.visibility_m, wavelengths_nm)


def mist_extinction(air: Air, wavelengths_nm: Bands) -> Bands:
    """Compute β of the mist at and below its base, at each wavelength [1/m]; 0 without mist."""
    if air.mist is None:
        return np.zeros_like(wavelengths_nm)
    return layer.mist_extinction(air.mist, wavelengths_nm)


def rgb_extinction(air: Air) -> Bands:
    """Compute β of the even haze in linear Rec.709 red, green and blue, (3,) [1/m]."""
    return haze_extinction(air, rgb_wavelengths())


def extinction(air: Air, height_m: Reals, wavelengths_nm: Bands) -> PathBands:
    """Compute β of both layers at each height above the datum, (n, bands) [1/m]."""
    share = (
        np.ones_like(height_m)
        if air.mist is None
        else layer.relative_extinction(air.mist, height_m)
    )
    return haze_extinction(air, wavelengths_nm) + share[:, None] * mist_extinction(
        air, wavelengths_nm
    )


def optical_depth(
    air: Air, start_m: Reals, end_m: Reals, length_m: Reals, wavelengths_nm: Bands
) -> PathBands:
    """Integrate β along straight paths, in closed form, (n, bands).

    Contrast falls by exp(−∫β) (Koschmieder, 1924). ``start_m`` and ``end_m`` are the heights of the
    ends above the datum, ``length_m`` the distance between them.
    """
    share = np.ones_like(length_m)
    if air.mist is not None:
        share = layer.mean_relative_extinction(air.mist, start_m, end_m)
    beta = haze_extinction(air, wavelengths_nm) + share[:, None] * mist_extinction(
        air, wavelengths_nm
    )
    return length_m[:, None] * beta


def least_extinction(
    air: Air, highest_m: float = math.inf, wavelengths_nm: Bands | None = None
) -> float:
    """Find the least β on any path that stays below ``highest_m``, over the given bands [1/m].

    β never grows upwards, so it is β at the greatest height that the eye or anything seen reaches.
    The least β decides where it varies with height or from band to band, so that nothing visible is
    dropped. By default the bands are those of an RGB picture, of which red is the clearest.
    """
    if math.isnan(highest_m):
        raise InputError("height", highest_m, "a number", "math.inf where there is no top")
    bands = rgb_wavelengths() if wavelengths_nm is None else wavelengths_nm
    return float(extinction(air, np.array([highest_m]), bands).min())
