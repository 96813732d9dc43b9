"""What an eye sees: its contrast sensitivity before a display, and classes of inherent contrast.

The eye is that of Barten, "Contrast Sensitivity of the Human Eye and Its Effects on Image Quality"
(SPIE, 1999), chapter 3, operation by operation as in colour-science (BSD;
``colour.contrast.barten1999``), which tests hold it against: importing that package takes seconds
and 0.1 GB in whatever process renders.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.arrays import ArrayData, FloatArray, Ints, Reals
from lod.errors import InputError


def pupil_diameter(luminance: float, field_deg: float) -> float:
    """Compute the diameter of the pupil [mm] by Le Grand's formula.

    ``luminance`` [cd/m²] is that of a square field of side ``field_deg`` [degrees].
    """
    return float(5 - 3 * np.tanh(0.4 * np.log10(luminance * field_deg * field_deg / 40**2)))


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
    largest_deg, most_cycles = 12.0, 15.0  # X_max, N_max: what the eye integrates over
    photon_rate = 1.2274 * 10**6  # p: per second, square degree and troland, for white light
    neural_noise = 3 * 10**-8  # Φ₀ [s·deg²]
    inhibited_cpd = 7.0  # u₀: frequency below which lateral inhibition acts
    optics = np.exp(-2 * np.pi**2 * sigma_deg**2 * u**2)
    size = (1 / field_deg**2 + 1 / largest_deg**2 + u**2 / most_cycles**2) ** -0.5
    photons = 1 / (n * photon_rate * illuminance_td)
    neural = neural_noise / (1 - np.exp(-((u / inhibited_cpd) ** 2)))
    noise = 2 / integration_s * (1 / (size * size)) * (photons + neural)
    return np.asarray((optics / signal_to_noise) / np.sqrt(noise))


SQUARE_WAVE_GAIN = 4 / math.pi
"""Fundamental of a square wave over its own modulation. Bars are seen this much better than a
sinusoid of the same modulation (Campbell & Robson, J. Physiol. 197, 1968, p. 551)."""


@dataclass(frozen=True)
class Display:
    """The screen on which the whole picture is looked at, pixel for pixel.

    pixels_per_degree  pixels to a degree of the viewer's sight; 67 is a 0.7 m wide 4K screen at
                       0.7 m
    luminance          mean over the picture, to which the eye adapts [cd/m²]
    field_deg          side of the square that the picture fills [degrees]
    """

    pixels_per_degree: float = 67.0
    luminance: float = 100.0
    field_deg: float = 53.0

    @property
    def pixel_angle(self) -> float:
        """Return the angle of one pixel at the viewer's eye [rad]."""
        return math.radians(1 / self.pixels_per_degree)


@dataclass(frozen=True)
class Eye:
    """An eye; by default Barten's standard observer: 20 to 30 years old, good sight (1999, ch. 3).

    blur_arcmin        σ₀ of the line spread where the pupil is small
    aberration_arcmin  C_ab: growth of σ with the pupil [arcmin/mm]
    signal_to_noise    k at which a pattern is seen half of the time
    integration_s      T over which the eye gathers light [s]
    efficiency         share of the photons that count
    """

    blur_arcmin: float = 0.5
    aberration_arcmin: float = 0.08
    signal_to_noise: float = 3.0
    integration_s: float = 0.1
    efficiency: float = 0.03


def optical_sigma(display: Display, eye: Eye) -> float:
    """Compute σ of the line spread of the eye's optics, at the pupil of this display [degrees].

    It is √(σ₀² + (C_ab·pupil)²) (Barten 1999, ch. 3), with Le Grand's formula of the pupil.
    """
    pupil_mm = pupil_diameter(display.luminance, display.field_deg)
    return float(np.hypot(eye.blur_arcmin / 60, eye.aberration_arcmin / 60 * pupil_mm))


@dataclass(frozen=True, eq=False)
class Sensitivity(ArrayData):
    """Contrast sensitivity of an eye to bars: 1 / the least modulation it sees.

    frequency (k,) equal steps of log frequency, upwards [cycles/degree of the viewer's sight]
    value     (k,) sensitivity; band-pass, before any envelope is taken
    """

    frequency: FloatArray
    value: FloatArray


@lru_cache(maxsize=64)
def sensitivity(display: Display, eye: Eye) -> Sensitivity:
    """Tabulate Barten's contrast sensitivity times 4/π (bars, not sinusoids) for one display.

    The table ends at the frequency of which the eye's own optics leave a millionth.
    """
    sigma = optical_sigma(display, eye)
    highest = math.sqrt(-math.log(1e-6) / 2) / (math.pi * sigma)
    frequency = np.geomspace(min(0.05, highest / 1000), highest, 2048)
    pupil_mm = pupil_diameter(display.luminance, display.field_deg)
    light = retinal_illuminance(display.luminance, pupil_mm)
    gathering = eye.signal_to_noise, eye.integration_s, display.field_deg, eye.efficiency
    value = contrast_sensitivity(frequency, sigma, *gathering, light)
    return Sensitivity(frequency, SQUARE_WAVE_GAIN * value)


def envelope(value: Reals) -> Reals:
    """Compute the decreasing envelope of a band-pass curve: the maximum from each value on, (k,).

    A feature that is coarser than the peak is still seen by its edges, which have frequencies
    there.
    """
    return np.maximum.accumulate(value[::-1])[::-1]


CONTRAST_CLASSES = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, math.inf)
"""Upper bounds of the classes of inherent contrast C₀.

The least one keeps parts that match their surroundings from vanishing close to the eye. Without air
no contrast exceeds 1; bright things before darker air do. Parts of the last class are never dropped
for lack of contrast.
"""

NEVER_LOST = len(CONTRAST_CLASSES) - 1
"""The last class of contrast, which no air takes away."""


def inherent_contrast(
    luminance: Reals, surroundings: Reals, airlight: Reals | float = math.inf
) -> Reals:
    """Compute C₀ such that the modulation left at optical depth δ is at most C₀·exp(−δ), (n,).

    Through air of transmittance T a luminance Y becomes Y·T + A·(1 − T), A being the airlight of
    the horizon (Koschmieder, 1924). Of the modulation M₀ = |Y − Y_b|/(Y + Y_b) of a part and its
    surroundings, with Ȳ their mean, that leaves M₀·T/(T + (A/Ȳ)·(1 − T)), at most
    M₀·T·max(1, Ȳ/A). So

        C₀ = |Y − Y_b| / (2·min(Ȳ, A)).

    It is modulation because Barten's sensitivity is to modulation, which is half of Weber's
    |Y − Y_b|/Y_b where that is small, and never above 1. All in one unit of luminance; an infinite
    A says that air is brighter than anything seen through it.
    """
    if not all((np.asarray(v) >= 0).all() for v in (luminance, surroundings, airlight)):
        raise InputError("luminance", "a negative number or NaN", "every luminance is at least 0")
    if not (np.isfinite(luminance).all() and np.isfinite(surroundings).all()):
        raise InputError("luminance", "a number that is not finite", "parts shine finitely")
    difference = np.abs(luminance - surroundings)
    weakest = 2 * np.minimum((luminance + surroundings) / 2, airlight)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0.0, 0.0, difference / weakest)


def contrast_class(contrast: Reals) -> Ints:
    """Find the class of each contrast, (n,) rows of CONTRAST_CLASSES: the least not below it.

    Contrasts are rounded up, so that nothing visible is dropped. Raises InputError for a contrast
    below 0.
    """
    if not (contrast >= 0).all():
        raise InputError("contrast", "a negative number or NaN", "a contrast is at least 0")
    return np.searchsorted(np.array(CONTRAST_CLASSES), contrast, side="left").astype(np.int64)
