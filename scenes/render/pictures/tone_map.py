"""How scene light becomes a picture for people: exposure, a named tone curve, and sRGB.

The encoding is colour-science's. Pictures are for looking at; measure the EXR.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lod.errors import InputError

KEY = 0.18
"""Where the exposure puts the log-average luminance (Reinhard et al. 2002, equations 1 and 2)."""

_DARKEST = 1e-4


def _filmic(x: np.ndarray) -> np.ndarray:
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


def _reinhard(x: np.ndarray) -> np.ndarray:
    return x * (1 + x / _WHITE**2) / (1 + x)


_WHITE = 4.0
"""Exposed light that ``reinhard`` makes white."""

TONE_CURVES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "filmic": _filmic,
    "reinhard": _reinhard,
    "linear": lambda x: x,
}
"""From exposed light to display light, on each channel, before it is cut off at 1: Narkowicz's fit
to the ACES filmic curve ("ACES Filmic Tone Mapping Curve", 2015); Reinhard et al. 2002, equation 4;
none."""


VIEWS = ("colour", "level")
"""The light of a frame, or the detail level of what is met."""


@dataclass(frozen=True)
class PictureStyle:
    """How pictures for people are made.

    A tone curve by name, stops above the exposure that fits, and what they show, one of VIEWS.
    """

    tone: str = "filmic"
    stops: float = 0.0
    view: str = "colour"

    def __post_init__(self) -> None:
        if self.view not in VIEWS:
            raise InputError("--view", self.view, f"one of {', '.join(VIEWS)}", "try colour")
        if self.tone not in TONE_CURVES:
            raise InputError("--tone", self.tone, f"one of {', '.join(TONE_CURVES)}", "try filmic")
        if not -20 <= self.stops <= 20:
            raise InputError("--exposure", self.stops, "from -20 to 20 stops", "try 0")

    def exposure_of(self, rgb: np.ndarray) -> float:
        """Exposure factor for a picture, and for all that shall look alike."""
        return auto_exposure(rgb) * 2.0**self.stops


DEFAULT_STYLE = PictureStyle()


def to_srgb_8bit(rgb: np.ndarray, exposure: float, tone: str = DEFAULT_STYLE.tone) -> np.ndarray:
    """Tone-map linear Rec.709 times ``exposure`` to 8-bit sRGB, (h, w, 3)."""
    return np.rint(to_srgb(rgb, exposure, tone) * 255).astype(np.uint8)


def to_srgb(rgb: np.ndarray, exposure: float, tone: str = DEFAULT_STYLE.tone) -> np.ndarray:
    """Tone-map linear Rec.709 times ``exposure`` to sRGB from 0 to 1, not rounded, (h, w, 3)."""
    if not (math.isfinite(exposure) and exposure > 0):
        raise InputError("exposure", exposure, "a factor above 0", "try 1")
    from colour.models import eotf_inverse_sRGB

    x = np.maximum(rgb.astype(np.float64), 0.0) * exposure
    return np.asarray(eotf_inverse_sRGB(np.clip(TONE_CURVES[tone](x), 0.0, 1.0)))


def auto_exposure(rgb: np.ndarray) -> float:
    """Factor that brings a picture's log-average luminance to KEY; 1 for a black picture."""
    from colour import RGB_COLOURSPACES

    luminance = rgb.astype(np.float64) @ RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ[1]
    lit = luminance[luminance > _DARKEST]
    return KEY / math.exp(float(np.log(lit).mean())) if len(lit) else 1.0
