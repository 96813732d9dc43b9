"""Albedo of the ground: patches of every size from moist to dry, rock where steep, and snow.

The albedo is a function of the place alone. Where patches and slopes are too small to be drawn, it
is the mean over them: they count as normally distributed, and a smooth step that is blurred by a
normal distribution is about a smooth step again, whose variance is the sum of both. Albedo is
linear Rec.709, chosen by eye.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Points, Reals
from lod.camera import Corner
from scenes.noise import Octaves, left_out_variance, octaves_at, twin_values, unit_rms


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

_LEVEL = 1e-6
"""Half the variance of slopes below which none count as hidden."""

_PATCHES = 0x50415443485459
"""Word by which the patches' random numbers differ from others of the same seed."""


def ground_colours(
    seed: int,
    corner: Corner,
    xy: Float64[np.ndarray, "n 2"],
    rise: Reals,
    slope: Reals,
    hidden: Reals,
    shortest: Reals,
    materials: GroundMaterials,
) -> Points:
    """Mean albedo of the ground about ``xy``, (n, 3); patches under ``shortest`` [m] are left out.

    rise    height in units of the relief's RMS: ridges are drier than hollows
    slope   tangent of the steepness: steep ground is drier, and the steepest bare
    hidden  variance on each axis of the slopes that ``slope`` is without
    """
    octaves = _octaves(seed ^ _PATCHES, corner)
    noise = twin_values(octaves, xy, shortest)
    vague = left_out_variance(shortest, octaves.side, (octaves.weight * unit_rms()) ** 2)
    snow_line = math.inf if materials.snow_line is None else materials.snow_line
    albedos = np.array((materials.moist, materials.dry, materials.steep, SNOW))
    edges = materials.steep_from, materials.steep_to, snow_line - _SNOW_EDGE / 2
    return np.asarray(_mean_colours(noise, vague, rise, slope, hidden, albedos, edges))


@njit(cache=True, nogil=True)
def _mean_colours(noise, vague, rise, slope, hidden, albedos, edges):  # type: ignore[no-untyped-def]
    """Mean albedo (n, 3) over hidden slopes: five steepnesses, each with half their variance.

    vague  variance of dryness and of brightness that the noise (n, 2) is without
    The steepnesses are those of Stroud's seven points (of degree 5 for the normal distribution).
    """
    colours = np.zeros((len(rise), 3))
    for i in range(len(rise)):
        half, patch = hidden[i] / 2, (noise[i, 0], noise[i, 1], vague[i])
        if half < _LEVEL:
            _add_colour(colours[i], 1.0, patch, rise[i], slope[i], half, albedos, edges)
            continue
        aside, s = math.sqrt(half), slope[i]
        for k in range(5):
            if k == 0:
                share, steep = 1 / 2, s
            elif k < 3:
                share, steep = 1 / 12, abs(s + (2.0 if k == 1 else -2.0) * aside)
            else:
                along = s + (1.0 if k == 3 else -1.0) * aside
                share, steep = 1 / 6, math.sqrt(along * along + 3.0 * half)
            _add_colour(colours[i], share, patch, rise[i], steep, half, albedos, edges)
    return colours


@njit(cache=True)
def _add_colour(colour, share, patch, rise, slope, hidden, albedos, edges):  # type: ignore[no-untyped-def]
    """Add ``share`` of the mean albedo (3,) of a patch at a rise and a slope.

    patch    its dryness and brightness, and the variance that both are without
    hidden   variance on each axis of the slopes about this one
    albedos  (4, 3) of moist, dry and steep ground, and of snow
    edges    tangents between which steep ground sets in; height above which snow does
    """
    dryness, shade, vague = patch
    # Mean and variance of the length of a slope in two dimensions (Rice), to first order.
    if hidden > 0.0:
        square = slope * slope
        slope = math.sqrt(square + hidden * (square + math.pi / 2 * hidden) / (square + hidden))
        hidden = square + 2.0 * hidden - slope * slope
    dry = _step(-1.9, 2.3, dryness + 0.35 * rise + 1.2 * slope, vague + 1.44 * hidden)
    bare = _step(edges[0], edges[1], slope + 0.06 * shade, 0.0036 * vague + hidden)
    snow = _step(edges[2], edges[2] + _SNOW_EDGE, rise + 0.2 * dryness, 0.04 * vague)
    if snow > 0.0:
        slid = _step(_SNOW_FROM, _SNOW_TO, slope + 0.1 * shade, 0.01 * vague + hidden)
        snow *= 1.0 - slid
    bright = math.exp(0.16 * shade + 0.0128 * vague)
    for k in range(3):
        ground = albedos[0, k] + (albedos[1, k] - albedos[0, k]) * dry
        ground = (ground + (albedos[2, k] - ground) * bare) * bright
        colour[k] += share * min(max(ground + (albedos[3, k] - ground) * snow, 0.0), 1.0)


@njit(cache=True)
def _step(low: float, high: float, x: float, variance: float) -> float:
    """Smooth step from 0 below ``low`` to 1 above ``high``, blurred by a variance of ``x``."""
    if variance > 0.0 and math.isfinite(low):
        # The smooth step is the sum of a density with a variance of a 20th of its squared width.
        more = (math.sqrt((high - low) ** 2 + 20.0 * variance) - (high - low)) / 2
        low, high = low - more, high + more
    if not low < x:
        return 0.0
    t = min((x - low) / (high - low), 1.0)
    return t * t * (3.0 - 2.0 * t)


@lru_cache(maxsize=64)
def _octaves(seed: int, corner: Corner) -> Octaves:
    weights = _FALL ** np.arange(len(_SIDES))
    return octaves_at(corner, seed, _SIDES, weights / np.linalg.norm(weights) / unit_rms())
