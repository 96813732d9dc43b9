"""Inherent contrast: how much a part stands out with no air before it, in a few classes."""

import math
from itertools import pairwise

import numpy as np

from lod.arrays import Ints, Reals
from lod.errors import InputError

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
    values = (luminance, surroundings, np.asarray(airlight, np.float64))
    if not all((v >= 0).all() for v in values):
        raise InputError("luminance", "a negative number or NaN", "every luminance is at least 0")
    if not all(np.isfinite(v).all() for v in values[:2]):
        raise InputError("luminance", "a number that is not finite", "parts shine finitely")
    mean = (luminance + surroundings) / 2
    difference = np.abs(luminance - surroundings)
    weakest = 2 * np.minimum(mean, values[2])
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0.0, 0.0, difference / weakest)


def contrast_class(contrast: Reals, classes: tuple[float, ...] = CONTRAST_CLASSES) -> Ints:
    """Find the class of each contrast, (n,) rows of ``classes``: the least that is not below it.

    Contrasts are rounded up, so that nothing visible is dropped. Raises InputError unless the
    classes rise from above 0 to infinity, and for a contrast below 0.
    """
    if not (classes and 0 < classes[0] and classes[-1] == math.inf):
        raise InputError("contrast classes", classes, "from above 0 to infinity")
    if not all(a < b for a, b in pairwise(classes)):
        raise InputError("contrast classes", classes, "each above the one before")
    if not (contrast >= 0).all():
        raise InputError("contrast", "a negative number or NaN", "a contrast is at least 0")
    return np.searchsorted(np.array(classes), contrast, side="left").astype(np.int64)
