"""The second layer of the air: mist that fills a valley and thins out upwards."""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.atmosphere.extinction import (
    Bands,
    extinction_from_visibility,
    particle_extinction,
)
from lod.errors import InputError


@dataclass(frozen=True)
class Mist:
    """Mist of one thickness up to its base, and e times thinner every ``scale_m`` above it.

    visibility_m  Koschmieder visibility in the mist alone, at and below the base [m]
    base_m        height of the base above the datum [m]
    scale_m       height over which β falls by a factor of e [m]
    """

    visibility_m: float
    base_m: float
    scale_m: float

    def __post_init__(self) -> None:
        extinction_from_visibility(self.visibility_m)
        if not math.isfinite(self.base_m):
            raise InputError("mist.base", self.base_m, "a finite height above the datum")
        if not (math.isfinite(self.scale_m) and self.scale_m > 0):
            raise InputError("mist.scale", self.scale_m, "finite and above 0 m", "try 50m")


def mist_extinction(mist: Mist, wavelengths_nm: Bands) -> Bands:
    """Compute β of the mist at its base [1/m].

    Mist is droplets alone, which follow Ångström's law for its own visibility.
    """
    at_550 = extinction_from_visibility(mist.visibility_m)
    return particle_extinction(mist.visibility_m, at_550, wavelengths_nm)


def relative_extinction(mist: Mist, height_m: Reals) -> Reals:
    """Compute β at each height over β at the base: exp(−(z − z₀)/H) above it, 1 below, (n,)."""
    return np.exp(-np.maximum(height_m - mist.base_m, 0.0) / mist.scale_m)


def mean_relative_extinction(mist: Mist, start_m: Reals, end_m: Reals) -> Reals:
    """Compute the exact mean of ``relative_extinction`` over straight paths between heights, (n,).

    On a straight path the height is linear in the length, so this is the mean over height. It is 1
    over a stretch below the base, and exp(−u/H)·(1 − exp(−h/H))/(h/H) over one from u to u + h
    above it.
    """
    low = np.minimum(start_m, end_m) - mist.base_m
    high = np.maximum(start_m, end_m) - mist.base_m
    rise = high - low
    low_above, high_above = np.maximum(low, 0.0), np.maximum(high, 0.0)
    level = rise == 0.0
    share_above = np.where(level, 1.0, (high_above - low_above) / np.where(level, 1.0, rise))
    x = (high_above - low_above) / mist.scale_m
    mean_above = np.exp(-low_above / mist.scale_m) * np.where(
        x > 0.0, -np.expm1(-x) / np.where(x > 0.0, x, 1.0), 1.0
    )
    return 1.0 - share_above + share_above * mean_above


def base_equivalent_length(mist: Mist, start_m: Reals, rise: Reals) -> Reals:
    """Compute the metres at the base that hold as much mist as an endless path upwards, (n,) [m].

    The path starts at the height ``start_m`` and rises by ``rise`` > 0 a metre. The result is
    exact: (z₀ − z)/rise up to the base, where the path begins below it, and
    H/rise·exp(−(z − z₀)/H) from where it is above.
    """
    below = np.maximum(mist.base_m - start_m, 0.0)
    return (below + mist.scale_m * relative_extinction(mist, start_m)) / rise
