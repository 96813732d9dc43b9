"""What colour the ground is: grass, lush to dry, in patches of every size, and earth where steep.

A function of the place alone; a mesh too coarse for the small patches gets the colour without them,
about their mean. Albedo is linear Rec.709, chosen by eye.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.camera import Corner
from scenes.terrain_noise import Octaves, octave_sums, octaves_at, unit_rms

LUSH = np.array((0.072, 0.135, 0.031))
DRY = np.array((0.165, 0.178, 0.066))
EARTH = np.array((0.150, 0.112, 0.072))

_EXPONENTS = range(10, -4, -1)
"""Patches from 1024 m to 0.125 m across."""

_FALL = 0.92
"""RMS of each octave of patches beside the one twice as large: close to equal, as in vegetation."""

_DRYNESS, _SHADE = 0x445259, 0x53484144


def ground_colours(
    seed: int,
    corner: Corner,
    xy: Float64[np.ndarray, "n 2"],
    rise: Reals,
    slope: Reals,
    shortest: Reals,
) -> Points:
    """Albedo of the ground at ``xy``, (n, 3), from patches no smaller than ``shortest`` [m].

    rise   height in units of the relief's RMS: ridges are drier than hollows
    slope  tangent of the steepness: steep ground is drier, and beyond 0.6 bare
    """
    dryness = _patches(seed ^ _DRYNESS, corner, xy, shortest)
    shade = _patches(seed ^ _SHADE, corner, xy, shortest)
    dry = _step(-1.9, 2.3, dryness + 0.35 * rise + 1.2 * slope)[:, None]
    bare = _step(0.45, 0.85, slope + 0.06 * shade)[:, None]
    colour = LUSH + (DRY - LUSH) * dry
    colour = colour + (EARTH - colour) * bare
    return np.clip(colour * np.exp(0.16 * shade)[:, None], 0.0, 1.0)


def _patches(seed: int, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals) -> Reals:
    """Noise of RMS 1 with patches of every size."""
    return octave_sums(_octaves(seed, corner), xy, shortest, limit_value=True)[:, 0]


@lru_cache(maxsize=64)
def _octaves(seed: int, corner: Corner) -> Octaves:
    weights = _FALL ** np.arange(len(_EXPONENTS))
    return octaves_at(corner, seed, _EXPONENTS, weights / np.linalg.norm(weights) / unit_rms())


def _step(low: float, high: float, x: Reals) -> Reals:
    """0 below ``low``, 1 above ``high``, smoothly between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)
