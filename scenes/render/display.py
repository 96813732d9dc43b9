"""How scene light becomes a picture for people: exposure, a tone curve, and the sRGB encoding.

The curve is Narkowicz's fit to the ACES filmic curve ("ACES Filmic Tone Mapping Curve",
2015), on each channel. Pictures are for looking at; measure the EXR.
"""

import math

import numpy as np

from lod.errors import InputError

KEY = 0.18
"""Where the exposure puts the log-average luminance (Reinhard et al. 2002, equations 1 and 2)."""

_DARKEST = 1e-4


def display(rgb: np.ndarray, exposure: float) -> np.ndarray:
    """Linear Rec.709 times ``exposure``, through the curve, as 8-bit sRGB, (h, w, 3)."""
    if not (math.isfinite(exposure) and exposure > 0):
        raise InputError("exposure", exposure, "a factor above 0", "try 1")
    from colour.models import eotf_inverse_sRGB

    x = np.maximum(rgb.astype(np.float64), 0.0) * exposure
    toned = np.clip(x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14), 0.0, 1.0)
    return np.rint(np.asarray(eotf_inverse_sRGB(toned)) * 255).astype(np.uint8)


def exposure_of(rgb: np.ndarray) -> float:
    """The factor that brings a picture's log-average luminance to KEY; 1 for a black picture."""
    from colour import RGB_COLOURSPACES

    luminance = rgb.astype(np.float64) @ RGB_COLOURSPACES["sRGB"].matrix_RGB_to_XYZ[1]
    lit = luminance[luminance > _DARKEST]
    return KEY / math.exp(float(np.log(lit).mean())) if len(lit) else 1.0
