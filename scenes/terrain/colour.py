"""Albedo of the ground: patches of every size from moist to dry, rock where steep, and snow.

The albedo is a function of the place alone; a mesh too coarse for the small patches gets the colour
without them, which is about their mean. Albedo is linear Rec.709, chosen by eye.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Points, Reals
from lod.camera import Corner
from scenes.noise.lattice import unit_rms
from scenes.noise.octaves import Octaves, octaves_at, twin_values


@dataclass(frozen=True)
class GroundMaterials:
    """Materials of the ground, and where each of them lies.

    moist, dry, steep   albedo in hollows, on ridges, and where it is too steep for either
    steep_from, steep_to   tangents of the slope between which that sets in
    snow_line   height above which snow lies, in units of the relief's RMS; None = nowhere
    """

    moist: tuple[float, float, float]
    dry: tuple[float, float, float]
    steep: tuple[float, float, float]
    steep_from: float
    steep_to: float
    snow_line: float | None = None


GROUND_MATERIALS = {
    "grassy": GroundMaterials(
        (0.072, 0.135, 0.031), (0.165, 0.178, 0.066), (0.150, 0.112, 0.072), 0.45, 0.85
    ),
    "bare": GroundMaterials(
        (0.150, 0.118, 0.085), (0.260, 0.225, 0.175), (0.200, 0.190, 0.178), 0.35, 0.75
    ),
    "snowy": GroundMaterials(
        (0.060, 0.098, 0.030), (0.140, 0.135, 0.070), (0.155, 0.147, 0.138), 0.40, 0.80, -0.1
    ),
}
"""Grass and earth; gravel and rock; alpine grass and rock under snow."""

SNOW = (0.80, 0.83, 0.87)
_SNOW_EDGE = 0.5
"""Range of heights over which snow thins out, in units of the relief's RMS."""

_SNOW_FROM, _SNOW_TO = 0.75, 1.15
"""Tangents of the slopes on which snow begins to slide, and on which none stays."""

_SIDES = 2.0 ** np.arange(10, -4, -1)
"""Sizes of patches, from 1024 m to 0.125 m across."""

_FALL = 0.92
"""Ratio of the RMS of octaves of patches to that of patches twice as large, as in vegetation."""

_PATCHES = 0x50415443485459
"""Word by which the patches' random numbers differ from others of the same seed."""


def ground_colours(
    seed: int,
    corner: Corner,
    xy: Float64[np.ndarray, "n 2"],
    rise: Reals,
    slope: Reals,
    shortest: Reals,
    materials: GroundMaterials,
) -> Points:
    """Albedo of the ground at ``xy``, (n, 3), from patches no smaller than ``shortest`` [m].

    rise   height in units of the relief's RMS: ridges are drier than hollows
    slope  tangent of the steepness: steep ground is drier, and the steepest bare
    """
    noise = twin_values(_octaves(seed ^ _PATCHES, corner), xy, shortest)
    snow_line = math.inf if materials.snow_line is None else materials.snow_line
    albedos = np.array((materials.moist, materials.dry, materials.steep, SNOW))
    edges = materials.steep_from, materials.steep_to, snow_line - _SNOW_EDGE / 2
    return np.asarray(_coloured(noise, rise, slope, albedos, edges))


@njit(cache=True, nogil=True)
def _coloured(noise, rise, slope, albedos, edges):  # type: ignore[no-untyped-def]
    """Albedo (n, 3) from the dryness and brightness of patches, noise of unit RMS (n, 2).

    albedos  (4, 3) of moist, dry and steep ground, and of snow
    edges    tangents between which steep ground sets in; height above which snow does
    """
    colours = np.empty((len(rise), 3))
    for i in range(len(rise)):
        dryness, shade = noise[i, 0], noise[i, 1]
        dry = _step(-1.9, 2.3, dryness + 0.35 * rise[i] + 1.2 * slope[i])
        bare = _step(edges[0], edges[1], slope[i] + 0.06 * shade)
        snow = _step(edges[2], edges[2] + _SNOW_EDGE, rise[i] + 0.2 * dryness)
        if snow > 0.0:
            snow *= 1.0 - _step(_SNOW_FROM, _SNOW_TO, slope[i] + 0.1 * shade)
        bright = math.exp(0.16 * shade)
        for k in range(3):
            colour = albedos[0, k] + (albedos[1, k] - albedos[0, k]) * dry
            colour = (colour + (albedos[2, k] - colour) * bare) * bright
            colours[i, k] = min(max(colour + (albedos[3, k] - colour) * snow, 0.0), 1.0)
    return colours


@njit(cache=True)
def _step(low: float, high: float, x: float) -> float:
    """Smooth step from 0 below ``low`` to 1 above ``high``."""
    if not low < x:
        return 0.0
    t = min((x - low) / (high - low), 1.0)
    return t * t * (3.0 - 2.0 * t)


@lru_cache(maxsize=64)
def _octaves(seed: int, corner: Corner) -> Octaves:
    weights = _FALL ** np.arange(len(_SIDES))
    return octaves_at(corner, seed, _SIDES, weights / np.linalg.norm(weights) / unit_rms())
