"""Inherent contrast of parts: their own luminance against the backgrounds that they can have.

Luminance is in units of that of white horizontal ground in sun and sky. A part has the mean albedo
of its leaf appearance, under any irradiance from SHADED to LIT. Its background is the ground, from
the darkest in shade to the driest in the sun, or the sky at the horizon, which is also the
airlight, from HORIZONS' least to its greatest. The greatest contrast of all these counts, so that
nothing visible is dropped. It is seldom below 1/2, because the sky may be behind anything: objects
get the classes 1, 2 and 5.

A whole has at least the class of its parts, because they are in the cut only together with it.
"""

from itertools import product

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Reals
from lod.eye import contrast_class, inherent_contrast
from lod.shapes import StickTable
from scenes.sticks.outline_area import mean_outline_areas

SHADED, LIT = 0.1, 2.3
"""Irradiance of the darkest and the brightest face; that of horizontal ground is 1. Sky alone is
0.16 of sun and sky together at turbidity 2, and an upright face sees half of it; a face square to
a sun of 20° gets 2.3 (this project's own measurement of Mitsuba's ``sunsky``)."""

HORIZONS = (0.25, 2.0)
"""Luminance of the sky at the horizon, which is the airlight: from its least over all azimuths,
turbidities and suns of 20° and more, 0.24, to that about a sun of 10° (measured as above)."""

GROUND = (0.08, 0.2)
"""Albedo of the ground, from lush grass in a hollow to dry grass on a ridge.

The colours are in scenes.terrain.colour.
"""

LUMINANCE = (0.2126, 0.7152, 0.0722)
"""Weights of linear Rec.709 red, green and blue (ITU-R BT.709)."""


def greatest_contrast(albedo: Reals) -> Reals:
    """Compute the greatest inherent contrast C₀ of parts of these mean albedos (n,), (n,)."""
    found = np.zeros_like(albedo)
    for light, horizon in product((SHADED, LIT), HORIZONS):
        behind = (SHADED * GROUND[0], LIT * GROUND[1], horizon)
        for luminance in behind:
            against = np.full_like(albedo, luminance)
            found = np.maximum(found, inherent_contrast(light * albedo, against, horizon))
    return found


GROUND_CONTRAST = int(contrast_class(greatest_contrast(np.array(GROUND))).max())
"""Contrast class of the ground: a bump in the sun against shaded ground, or against the sky."""


def part_contrast(parent: Ints, leaf: StickTable, tints: Float64[np.ndarray, "t 3"]) -> Ints:
    """Compute the class of every part from its leaf appearance, (n,) rows of CONTRAST_CLASSES.

    ``parent`` (n,) is the row of each part's whole, as in Hierarchy; ``tints`` are linear Rec.709.
    """
    weight = mean_outline_areas(leaf)
    shine = weight * (tints @ np.array(LUMINANCE))[leaf.tint]
    parts = len(parent)
    shone, covered = (np.bincount(leaf.owner, column, parts) for column in (shine, weight))
    found = contrast_class(greatest_contrast(shone / covered))
    for row in range(parts - 1, 0, -1):
        found[parent[row]] = max(found[parent[row]], found[row])
    return found
