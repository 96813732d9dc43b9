"""The bands in which a variant renders, and how they make linear Rec.709.

An _rgb variant has three, each with an effective wavelength; a _spectral variant has as many as
``EDGES_NM`` leaves room for, and each holds the integral of the radiance over it.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.air import rgb_wavelengths
from lod.arrays import freeze

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
