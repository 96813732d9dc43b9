"""Excess FLIP: how far is a picture from another, beyond the noise that both have?

FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020) is what is
perceived when two pictures are flipped between, 0 to 1 a pixel; here its mean over the picture.
Two noisy renders of one scene differ too. So, with seeds a and b,

    excess = FLIP(tested, a; reference, b) − FLIP(reference, a; reference, b),

and the second term is the noise floor. It is the mean over independent pairs of seeds, and its
bounds are one-sided (Student's t): the truth is above the upper bound in 5 % of experiments, and
below the lower bound in 5 %, so both together are a two-sided 90 % interval. FLIP does not add up:
noise hides part of a difference, so the excess is only worth quoting where the floor is low
(FLOOR). Functions here touch no files.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import stats

from lod.arrays import Reals
from lod.errors import InputError

PIXELS_PER_DEGREE = 67.0
"""The usual fineness of a display before a viewer: a 0.7 m wide 4K screen at 0.7 m."""

LEAST_PAIRS = 8
"""The fewest pairs of seeds of which an excess is estimated."""

FLOOR = 0.01
"""The highest noise floor at which an excess is quoted."""

ONE_SIDED_CONFIDENCE = 0.95
"""The probability that one bound alone is on the right side of the truth."""

Picture = Float[np.ndarray, "_ _ 3"]
"""A picture as it is displayed: sRGB-encoded, 0 to 1, exposure and tone curve applied."""


@dataclass(frozen=True)
class ExcessFlip:
    """An excess of FLIP over its noise floor, means over pairs of seeds.

    excess     the mean excess
    low, high  its one-sided 95 % bounds: the truth is past each of them in 1 of 20 experiments
    floor      FLIP of the reference against itself with another seed
    pairs      how many independent pairs of seeds there are
    """

    excess: float
    low: float
    high: float
    floor: float
    pairs: int


def one_sided_excess(tested: Reals, noise: Reals) -> ExcessFlip:
    """Compute the excess and its one-sided bounds from both terms of each pair, (pairs,) each.

    Raises InputError for fewer than LEAST_PAIRS pairs.
    """
    if len(tested) < LEAST_PAIRS:
        raise InputError("pairs", len(tested), f"at least {LEAST_PAIRS} pairs of seeds")
    excess = tested - noise
    error = float(excess.std(ddof=1)) / math.sqrt(len(excess))
    mean, reach = (
        float(excess.mean()),
        float(stats.t.ppf(ONE_SIDED_CONFIDENCE, len(excess) - 1)) * error,
    )
    return ExcessFlip(mean, mean - reach, mean + reach, float(noise.mean()), len(excess))


def mean_flip(
    test: Picture, reference: Picture, pixels_per_degree: float = PIXELS_PER_DEGREE
) -> float:
    """Return the mean FLIP of two displayed pictures, by its authors' evaluator.

    Raises InputError for pictures of different shapes and for values outside 0 to 1.
    """
    return _evaluated(test, reference, pixels_per_degree, False)[1]


def flip_by_pixel(test: Picture, reference: Picture) -> Reals:
    """Return FLIP of every pixel of two displayed pictures, row by row, (h·w,).

    Raises as ``mean_flip`` does.
    """
    return _evaluated(test, reference, PIXELS_PER_DEGREE, False)[0].astype(np.float64).ravel()


def flip_map(
    test: Picture, reference: Picture, pixels_per_degree: float = PIXELS_PER_DEGREE
) -> Picture:
    """Return FLIP of every pixel in its authors' colours: dark where it is 0, bright where it is 1.

    Raises InputError for pictures of different shapes and for values outside 0 to 1.
    """
    return _evaluated(test, reference, pixels_per_degree, True)[0]


def _evaluated(
    test: Picture, reference: Picture, pixels_per_degree: float, coloured: bool
) -> tuple[np.ndarray, float]:
    """Return the map of FLIP and its mean."""
    import flip_evaluator

    for name, picture in (("test", test), ("reference", reference)):
        if picture.shape != reference.shape:
            raise InputError(name, picture.shape, f"both pictures are {reference.shape}")
        if not (np.isfinite(picture).all() and picture.min() >= 0 and picture.max() <= 1):
            raise InputError(name, "a value outside 0 to 1", "pictures are sRGB, 0 to 1")
    pair = (np.ascontiguousarray(p, np.float32) for p in (reference, test))
    settings = {"ppd": float(pixels_per_degree)}
    found, mean, _ = flip_evaluator.evaluate(*pair, "LDR", True, coloured, True, settings)
    return np.asarray(found), float(mean)
