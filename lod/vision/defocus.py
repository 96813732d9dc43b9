"""Defocus: one more blur of the cascade, which depends on the distance, and what it hides (§2.1).

A thin lens spreads a point at distance z along its axis over a disc of the angle A·|1/z − 1/s|. A
uniform disc of diameter a has the standard deviation a/4 on each axis (Bracewell, "The Fourier
Transform and Its Applications", ch. 8), so its full width √12·σ is DISC_WIDTH·a = (√3/2)·a, and

    θ_eff(d)² = θ² + θ_defocus(d)²,    θ all other blurs together,

is to the metric a weighted distance: P + R > τ·θ_eff(d)·d while D_c > W(d) = d·θ_eff(d)/θ.

**The picture's corners.** The lens is focused on a plane, and the metric measures d along the ray:
what is seen at distance d is between z = d·cos φ and z = d, φ the angle from the axis to the
picture's corner. Nothing visible may be dropped, so that θ_defocus(d) is the least over these:

    (√3/2)·A·max(1/d − 1/s, 1/s − k/d, 0),    k = 1/cos φ.

**Near the eye** W does not increase: what is nearer than the focus is blurred more the nearer it
is. With q = (√3/2)·A/θ and p = 1/s, W² = d² + q²(1 − p·d)² is least at d* = q²p/(1 + q²p²) < s. A
limit distance needs an increasing W, and the largest one below it is W(d*) for all d < d*: parts
for which D_c > W(d*) are displayed all the way to the eye as if they were at d*, and all others
never. From d* on the limit D = W⁻¹(D_c) is the larger root of a quadratic equation.
"""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.errors import InputError
from lod.thin_lens import ThinLens

DISC_WIDTH = math.sqrt(3.0) / 2
"""Full width √12·σ of a uniform disc over its diameter."""


@dataclass(frozen=True)
class Defocus:
    """A lens, and how much farther along the ray than along the axis things are at most.

    corner  1/cos of the angle from the axis to the corners of the picture, at least 1
    """

    lens: ThinLens
    corner: float = 1.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.corner) and self.corner >= 1):
            raise InputError("corner", self.corner, "1/cos of an angle: finite and at least 1")

    @property
    def vergence(self) -> float:
        """Return p = 1/s [1/m]; 0 where the focus is at infinity."""
        return 1 / self.lens.focus_m

    def ratio(self, theta: float) -> float:
        """Return q = (√3/2)·A/θ [m], θ all other blurs together [rad]."""
        return DISC_WIDTH * self.lens.diameter_m / theta

    def sharpest_m(self, theta: float) -> float:
        """Compute d*, the distance at which W is least [m]."""
        q, p = self.ratio(theta), self.vergence
        return q * q * p / (1 + q * q * p * p)


def defocus_width(defocus: Defocus, distance: Reals) -> Reals:
    """Compute the least full width √12·σ of the blur at distances d > 0 in the picture, (n,)."""
    p, nearness = defocus.vergence, 1 / distance
    beside = np.maximum(nearness - p, p - defocus.corner * nearness)
    return DISC_WIDTH * defocus.lens.diameter_m * np.maximum(beside, 0.0)


def defocused_distance(defocus: Defocus, theta: float, distance: Reals) -> Reals:
    """Compute W of each distance, which nowhere decreases, (n,) [m]."""
    q, p = defocus.ratio(theta), defocus.vergence
    d = np.maximum(distance, defocus.sharpest_m(theta))
    beside = np.maximum(np.maximum(1 - p * d, p * d - defocus.corner), 0.0)
    return np.hypot(d, q * beside)


def defocus_limits(defocus: Defocus, theta: float, clear: Reals) -> Reals:
    """Compute D = W⁻¹(D_c), (n,) [m]: 0 for what is nowhere sharp enough to be displayed.

    ``clear`` (n,) holds limit distances D_c without this lens [m], theta all other blurs [rad].
    """
    q, p, k = defocus.ratio(theta), defocus.vergence, defocus.corner
    slope = 1 + (q * p) ** 2
    least = q / math.sqrt(slope)

    def root(corner: float) -> Reals:
        inside = np.maximum(clear**2 * slope - (q * corner) ** 2, 0.0)
        return (q * q * p * corner + np.sqrt(inside)) / slope

    with np.errstate(invalid="ignore"):
        near, far = root(1.0), root(k)
    focus = defocus.lens.focus_m
    seen = np.where(clear <= focus, near, np.where(clear <= k * focus, clear, far))
    return np.where(clear > least, np.minimum(seen, clear), 0.0)
