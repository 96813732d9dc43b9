"""What stands between a scene and whoever looks at its picture: air, lens, display and eye (§2.1).

A view carries its viewing conditions. They give the weighted distance W(d) of each class of
inherent contrast, and so the limit distances D = W⁻¹(D in clear air with an ideal eye).

A picture has two kinds of viewer, so there are two readings:

acuity      An eye looks at the picture on the stated display. Its blur counts in θ_eff, and what is
            too fine for the contrast it has left is gone (``weighted_distance``).
no acuity   Nobody knows who will look, or how closely. Every detail stays as fine as asked; only
            what the air has left too little contrast to be seen *at any size* is gone: past the d
            where C₀·exp(−βd)·max S = 1, S the standard observer's sensitivity on the display.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.arrays import Ints, Reals
from lod.errors import InputError
from lod.vision.blur_cascade import BlurWidths
from lod.vision.contrast import CONTRAST_CLASSES
from lod.vision.defocus import Defocus, defocus_limits
from lod.vision.eye import Display, Eye, sensitivity
from lod.vision.weighted_distance import (
    MIN_EXTINCTION,
    UNWEIGHTED,
    WeightedDistance,
    weighted_distance,
)

STANDARD_DISPLAY, STANDARD_EYE = Display(), Eye()


@dataclass(frozen=True)
class ViewingConditions:
    """Air, display and eye of one view.

    widths      the blurs at the camera; m = τ·(their effective width)
    extinction  β along the path, the least where it varies [1/m]; 0 = clear
    display, eye  where the picture is looked at, and by whom
    acuity      whether the eye's fineness counts, or only its threshold of contrast
    defocus     the lens that the picture is taken through; None = everything is sharp
    """

    widths: BlurWidths
    extinction: float = 0.0
    display: Display = STANDARD_DISPLAY
    eye: Eye = STANDARD_EYE
    acuity: bool = True
    defocus: Defocus | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.extinction) and self.extinction >= 0):
            raise InputError("extinction", self.extinction, "finite and at least 0 /m")

    def weighted(self, contrast: float, m: float) -> WeightedDistance:
        """Give W for parts of inherent contrast C₀ at detail angle m [rad]."""
        if self.acuity:
            air = self.extinction
            return weighted_distance(contrast, air, m, self.widths, self.display, self.eye)
        return extinction_cutoff(contrast, self.extinction, self.display, self.eye)


@lru_cache(maxsize=256)
def extinction_cutoff(
    contrast: float, extinction: float, display: Display, eye: Eye
) -> WeightedDistance:
    """Give W(d) = d up to ln(C₀·max S)/β, where C₀ is gone at any size; infinite beyond."""
    if math.isinf(contrast) or extinction < MIN_EXTINCTION:
        return UNWEIGHTED
    gone = math.log(contrast * float(sensitivity(display, eye).value.max())) / extinction
    knots = np.array([0.0, gone] if gone > 0 else [0.0])
    return WeightedDistance(knots, knots, math.inf)


def perceptual_limits(
    conditions: ViewingConditions, clear: Reals, contrast: Ints, m: float
) -> Reals:
    """Compute D = W⁻¹(D in clear air) of parts in these classes of contrast, (n,) [m].

    ``clear`` (n,) holds their limit distances in clear air [m], ``contrast`` rows of
    CONTRAST_CLASSES. A part must pass both of air and eye and of the lens, so that the lesser of
    their limits decides.
    """
    seen = clear.copy()
    for row in np.unique(contrast):
        of_class = contrast == row
        seen[of_class] = conditions.weighted(CONTRAST_CLASSES[row], m).inverse(clear[of_class])
    if conditions.defocus is None:
        return seen
    return np.minimum(seen, defocus_limits(conditions.defocus, conditions.widths.effective, clear))
