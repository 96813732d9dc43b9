"""What colour the ground is: patches of every size from moist to dry, rock where steep, and snow.

A function of the place alone; a mesh too coarse for the small patches gets the colour without them,
about their mean. Albedo is linear Rec.709, chosen by eye.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.camera import Corner
from scenes.terrain_noise import Octaves, octave_sums, octaves_at, unit_rms


@dataclass(frozen=True)
class Cover:
    """What lies on the ground.

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


COVERS = {
    "grassy": Cover(
        (0.072, 0.135, 0.031), (0.165, 0.178, 0.066), (0.150, 0.112, 0.072), 0.45, 0.85
    ),
    "bare": Cover((0.150, 0.118, 0.085), (0.260, 0.225, 0.175), (0.200, 0.190, 0.178), 0.35, 0.75),
    "snowy": Cover(
        (0.060, 0.098, 0.030), (0.140, 0.135, 0.070), (0.155, 0.147, 0.138), 0.40, 0.80, -0.1
    ),
}
"""Grass and earth; gravel and rock; alpine grass and rock under snow."""

SNOW = (0.80, 0.83, 0.87)
_SNOW_EDGE = 0.5
"""Heights over which snow thins out, in units of the relief's RMS."""

_SNOW_FROM, _SNOW_TO = 0.75, 1.15
"""Tangents of the slope from which snow slides, and on which none stays."""

_SIDES = 2.0 ** np.arange(10, -4, -1)
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
    cover: Cover,
) -> Points:
    """Albedo of the ground at ``xy``, (n, 3), from patches no smaller than ``shortest`` [m].

    rise   height in units of the relief's RMS: ridges are drier than hollows
    slope  tangent of the steepness: steep ground is drier, and the steepest bare
    """
    dryness = _patches(seed ^ _DRYNESS, corner, xy, shortest)
    shade = _patches(seed ^ _SHADE, corner, xy, shortest)
    dry = _step(-1.9, 2.3, dryness + 0.35 * rise + 1.2 * slope)[:, None]
    bare = _step(cover.steep_from, cover.steep_to, slope + 0.06 * shade)[:, None]
    colour = np.array(cover.moist) + np.subtract(cover.dry, cover.moist) * dry
    colour = colour + (np.array(cover.steep) - colour) * bare
    colour = colour * np.exp(0.16 * shade)[:, None]
    if cover.snow_line is not None:
        low = cover.snow_line - _SNOW_EDGE / 2
        lies = _step(low, low + _SNOW_EDGE, rise + 0.2 * dryness)
        stays = 1 - _step(_SNOW_FROM, _SNOW_TO, slope + 0.1 * shade)
        colour = colour + (np.array(SNOW) - colour) * (lies * stays)[:, None]
    return np.clip(colour, 0.0, 1.0)


def _patches(seed: int, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals) -> Reals:
    """Noise of RMS 1 with patches of every size."""
    return octave_sums(_octaves(seed, corner), xy, shortest, True, sloped=False)[:, 0]


@lru_cache(maxsize=64)
def _octaves(seed: int, corner: Corner) -> Octaves:
    weights = _FALL ** np.arange(len(_SIDES))
    return octaves_at(corner, seed, _SIDES, weights / np.linalg.norm(weights) / unit_rms())


def _step(low: float, high: float, x: Reals) -> Reals:
    """0 below ``low``, 1 above ``high``, smoothly between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)
