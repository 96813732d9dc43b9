"""How faint a contrast does an eye in front of a display see, at which frequency?

The eye is Barten's (``lod.vision.barten``).
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from lod.errors import InputError
from lod.vision.barten import (
    contrast_sensitivity,
    optics_sigma,
    pupil_diameter,
    retinal_illuminance,
)

SQUARE_WAVE_GAIN = 4 / math.pi
"""Fundamental of a square wave over its own modulation. Bars are seen this much better than a
sinusoid of the same modulation (Campbell & Robson, J. Physiol. 197, 1968, p. 551)."""

_KNOTS = 2048
_LOWEST_CPD = 0.05
_FADED = 1e-6
"""Share of a contrast that the eye's optics leave at the highest frequency of the table."""


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

    def __post_init__(self) -> None:
        _positive("display.pixels_per_degree", self.pixels_per_degree, "try 67")
        _positive("display.luminance", self.luminance, "try 100")
        _positive("display.field", self.field_deg, "try 53")
        if self.field_deg > 180:
            raise InputError("display.field", self.field_deg, "at most 180 degrees", "try 53")

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

    def __post_init__(self) -> None:
        _positive("eye.blur", self.blur_arcmin, "try 0.5")
        if not (math.isfinite(self.aberration_arcmin) and self.aberration_arcmin >= 0):
            raise InputError("eye.aberration", self.aberration_arcmin, "finite, >= 0", "try 0.08")
        _positive("eye.signal_to_noise", self.signal_to_noise, "try 3")
        _positive("eye.integration", self.integration_s, "try 0.1")
        _positive("eye.efficiency", self.efficiency, "try 0.03")
        if self.efficiency > 1:
            raise InputError("eye.efficiency", self.efficiency, "a share, at most 1", "try 0.03")


def optical_sigma(display: Display, eye: Eye) -> float:
    """Compute σ of the line spread of the eye's optics, at the pupil of this display [degrees].

    It is √(σ₀² + (C_ab·pupil)²) (Barten 1999, ch. 3), with Le Grand's formula of the pupil.
    """
    pupil_mm = pupil_diameter(display.luminance, display.field_deg)
    return optics_sigma(eye.blur_arcmin / 60, eye.aberration_arcmin / 60, pupil_mm)


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
    highest = math.sqrt(-math.log(_FADED) / 2) / (math.pi * sigma)
    frequency = np.geomspace(min(_LOWEST_CPD, highest / 1000), highest, _KNOTS)
    pupil_mm = pupil_diameter(display.luminance, display.field_deg)
    value = contrast_sensitivity(
        frequency,
        sigma,
        eye.signal_to_noise,
        eye.integration_s,
        display.field_deg,
        eye.efficiency,
        retinal_illuminance(display.luminance, pupil_mm),
    )
    return Sensitivity(frequency, SQUARE_WAVE_GAIN * value)


def envelope(value: Reals) -> Reals:
    """Compute the decreasing envelope of a band-pass curve: the maximum from each value on, (k,).

    A feature that is coarser than the peak is still seen by its edges, which have frequencies
    there.
    """
    return np.maximum.accumulate(value[::-1])[::-1]


def _positive(where: str, value: float, cure: str) -> None:
    if not (math.isfinite(value) and value > 0):
        raise InputError(where, value, "finite and above 0", cure)
