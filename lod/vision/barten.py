"""Barten's contrast sensitivity of the human eye, in closed form.

Barten, "Contrast Sensitivity of the Human Eye and Its Effects on Image Quality" (SPIE, 1999),
chapter 3, operation by operation as in colour-science (``colour.contrast.barten1999``, BSD), which
tests hold it against: importing that package takes seconds and 0.1 GB in whatever process renders.
"""

import math

import numpy as np

from lod.arrays import Reals

_LARGEST_DEG = 12.0
"""X_max: largest angle that the eye integrates over [degrees]."""

_MOST_CYCLES = 15.0
"""N_max: largest number of cycles that the eye integrates over."""

_PHOTONS = 1.2274 * 10**6
"""p: photons per second, square degree and troland, for white light."""

_NEURAL_NOISE = 3 * 10**-8
"""Φ₀: spectral density of neural noise [s·deg²]."""

_INHIBITED_CPD = 7.0
"""u₀: frequency below which lateral inhibition acts [cycles/degree]."""


def pupil_diameter(luminance: float, field_deg: float) -> float:
    """Compute the diameter of the pupil [mm] by Le Grand's formula.

    ``luminance`` [cd/m²] is that of a square field of side ``field_deg`` [degrees].
    """
    return float(5 - 3 * np.tanh(0.4 * np.log10(luminance * field_deg * field_deg / 40**2)))


def optics_sigma(blur_deg: float, aberration_deg: float, pupil_mm: float) -> float:
    """Compute σ of the line spread of the eye's optics, √(σ₀² + (C_ab·pupil)²) [degrees]."""
    return float(np.hypot(blur_deg, aberration_deg * pupil_mm))


def retinal_illuminance(luminance: float, pupil_mm: float) -> float:
    """Compute the light on the retina [troland], with the Stiles–Crawford effect."""
    troland = (math.pi * pupil_mm**2) / 4 * luminance
    return troland * (1 - (pupil_mm / 9.7) ** 2 + (pupil_mm / 12.4) ** 4)


def contrast_sensitivity(
    frequency_cpd: Reals,
    sigma_deg: float,
    signal_to_noise: float,
    integration_s: float,
    field_deg: float,
    efficiency: float,
    illuminance_td: float,
) -> Reals:
    """Compute 1 / the least modulation that is seen of sinusoids in a square field, (k,)."""
    u, n = frequency_cpd, efficiency
    optics = np.exp(-2 * np.pi**2 * sigma_deg**2 * u**2)
    size = (1 / field_deg**2 + 1 / _LARGEST_DEG**2 + u**2 / _MOST_CYCLES**2) ** -0.5
    photons = 1 / (n * _PHOTONS * illuminance_td)
    neural = _NEURAL_NOISE / (1 - np.exp(-((u / _INHIBITED_CPD) ** 2)))
    noise = 2 / integration_s * (1 / (size * size)) * (photons + neural)
    return np.asarray((optics / signal_to_noise) / np.sqrt(noise))
