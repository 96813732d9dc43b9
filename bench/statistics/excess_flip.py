"""Excess FLIP: how far a picture is from another beyond the noise that both have. Pure, no files.

FLIP (Andersson et al., "FLIP: A Difference Evaluator for Alternating Images", HPG 2020) is what is
perceived when two pictures are flipped between, 0 to 1 a pixel; here its mean over the picture.
Two noisy renders of one scene differ too. So, with seeds a and b,

    excess = FLIP(tested, a; reference, b) − FLIP(reference, a; reference, b),

and the second term is the noise floor. It is taken over independent pairs of seeds and quoted with
one-sided 95 % bounds (Student's t). FLIP does not add up: noise hides part of a difference, so the
excess is only worth quoting where the floor is low (FLOOR).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float
from scipy import stats

from lod.arrays import Reals
from lod.errors import InputError

PIXELS_PER_DEGREE = 67.0
"""Of the viewer's sight, unless said otherwise: a 0.7 m wide 4K screen at 0.7 m."""

LEAST_PAIRS = 8
FLOOR = 0.01
"""The highest noise floor at which an excess is quoted."""

CONFIDENCE = 0.95

Picture = Float[np.ndarray, "_ _ 3"]
"""As it is displayed: sRGB-encoded, 0 to 1, exposure and tone curve applied."""

Trio = tuple[Picture, Picture, Picture]
"""Tested with seed a, reference with seed a, reference with seed b."""


@dataclass(frozen=True)
class ExcessFlip:
    """Means over pairs of seeds.

    excess, low, high   and its one-sided 95 % bounds: each is passed in 1 of 20 experiments
    floor               FLIP of the reference against itself with another seed
    pairs               independent pairs of seeds
    """

    excess: float
    low: float
    high: float
    floor: float
    pairs: int

    @property
    def within_noise(self) -> bool:
        """Whether it is shown to be no more than the floor, and that to be low enough."""
        return self.floor <= FLOOR and self.high <= self.floor

    @property
    def beyond_noise(self) -> bool:
        """Whether it is shown to be more than the floor."""
        return self.low > self.floor


def excess_flip(trios: Sequence[Trio], pixels_per_degree: float = PIXELS_PER_DEGREE) -> ExcessFlip:
    """The excess over these pairs of seeds, at least LEAST_PAIRS of them."""
    tested, noise = [], []
    for picture, same, other in trios:
        tested.append(mean_flip(picture, other, pixels_per_degree))
        noise.append(mean_flip(same, other, pixels_per_degree))
    return over_noise(np.array(tested), np.array(noise))


def over_noise(tested: Reals, noise: Reals) -> ExcessFlip:
    """The excess from its two terms, FLIP of each pair of seeds, (pairs,) each."""
    if len(tested) < LEAST_PAIRS:
        raise InputError("pairs", len(tested), f"at least {LEAST_PAIRS} pairs of seeds")
    excess = tested - noise
    error = float(excess.std(ddof=1)) / math.sqrt(len(excess))
    mean, reach = float(excess.mean()), float(stats.t.ppf(CONFIDENCE, len(excess) - 1)) * error
    return ExcessFlip(mean, mean - reach, mean + reach, float(noise.mean()), len(excess))


def mean_flip(
    test: Picture, reference: Picture, pixels_per_degree: float = PIXELS_PER_DEGREE
) -> float:
    """Mean FLIP of two displayed pictures, by its authors' own evaluator."""
    return _evaluated(test, reference, pixels_per_degree, False)[1]


def flip_map(
    test: Picture, reference: Picture, pixels_per_degree: float = PIXELS_PER_DEGREE
) -> Picture:
    """FLIP of every pixel in its authors' colours: dark for none, bright for the largest."""
    return _evaluated(test, reference, pixels_per_degree, True)[0]


def _evaluated(
    test: Picture, reference: Picture, pixels_per_degree: float, coloured: bool
) -> tuple[np.ndarray, float]:
    """Map and mean."""
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
