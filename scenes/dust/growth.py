"""Life of a puff of dust from its footfall on: it is thrown up, spreads, drifts, settles, thins.

A puff is a low dome of wisps, each of grains of one size. All of it is a function of its age.

    spreads   its radius grows as age^0.6: near the √age of diffusion (G. I. Taylor, Proc. London
              Math. Soc. s2-20:196, 1922), faster while what threw it up lasts
    rises     to its height, slower and slower, e-fold in RISE_S
    drifts    some way behind the walker, then as the air does; with the wind, as fast as that is
              near the ground
    settles   each wisp at the speed of its grains by Stokes' law, v = ρ·g·d²/(18·μ): 2 cm/s for
              quartz of 15 µm, 0.3 m/s for 60 µm
    thins     air mixes in until nothing is seen of it, at LIFE_S

How much is thrown up, how far and how high is chosen by eye, as Reeves chose (SIGGRAPH '83);
lengths are shares of the stride, 1.4 m for a person. A drawn grain stands for many finer ones.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from scenes.figures.gait import GRAVITY
from scenes.particles.shapes import smoothstep

LIFE_S = 3.5
RISE_S = 0.5

YOUNG, OLD = 0.06, 0.34
"""Radius of a puff as the foot strikes and at the end."""

LOW, HIGH = 0.02, 0.24
"""Height of a puff as the foot strikes and at the end."""

WAKE = 0.12
"""Distance that a puff follows the walker."""

STIR_M_S = 0.1
"""Largest speed of the air where there is no wind, in any direction [m/s]."""

WISP = 0.1
"""Size of a wisp over its puff's."""

GRAIN = 6.6e-4
"""Radius of a grain."""

WISPS, GRAINS = 256, 128
"""Wisps of a puff, and grains of a wisp."""

WISPS_EACH, GRAINS_EACH = 16, 4
"""Wisps and grains that one larger grain replaces in the leaf appearance of puffs and of wisps."""

FAINTEST = 0.35
"""Area of the faintest puff over that of the thickest."""

STEEPEST = 0.7
"""Largest slope of a trail and of a puff on the ground: loose ground's angle of repose, 35°."""

LEAST_AREA = 1e-6
"""Least area, over the full one, of what is not there yet or no longer."""

_FINEST_M, _COARSEST_M = 12e-6, 70e-6
_DENSITY, _VISCOSITY = 2650.0, 1.81e-5
"""Density of quartz [kg/m³], and viscosity of air of 15 °C [Pa·s]."""

_ROUGHNESS_M, _CROWNS_M, _ANKLES_M = 0.01, 10.0, 0.3
_WAKING_S, _WAKE_S, _GROWTH = 0.25, 0.6, 0.6
_STRATA = 5


class PuffShape(NamedTuple):
    """Shapes of m puffs: radius, height, way after the walker [m], and area over the full one."""

    radius: np.ndarray
    height: np.ndarray
    wake: np.ndarray
    area: np.ndarray


def puff_shapes(age_s: Reals, stride: Reals) -> PuffShape:
    """Compute shapes of puffs by age, from 0 to LIFE_S [s], and their walkers' stride [m], (m,)."""
    s = age_s / LIFE_S
    radius = YOUNG + (OLD - YOUNG) * s**_GROWTH
    height = LOW + (HIGH - LOW) * -np.expm1(-age_s / RISE_S)
    wake = WAKE * -np.expm1(-age_s / _WAKE_S)
    area = smoothstep(age_s / _WAKING_S) * (1 - s) ** 1.5
    return PuffShape(stride * radius, stride * height, stride * wake, area)


def settling_speed(u: Reals) -> Reals:
    """Compute the speeds at which grains settle by Stokes' law, from uniform numbers, (m,) [m/s].

    Their sizes are log-uniform.
    """
    diameter = _FINEST_M * (_COARSEST_M / _FINEST_M) ** u
    return _DENSITY * GRAVITY * diameter**2 / (18 * _VISCOSITY)


def wind_near_ground(wind_m_s: float) -> float:
    """Compute the speed of the wind where dust is, from that at the height of crowns [m/s].

    It follows the logarithmic profile over bare ground (Oke, "Boundary Layer Climates", 2nd ed.
    1987, ch. 2).
    """
    above = np.log(np.array((_ANKLES_M, _CROWNS_M)) / _ROUGHNESS_M)
    return float(wind_m_s * above[0] / above[1])


class WispState(NamedTuple):
    """State of m wisps.

    up      height above the ground [m]
    squash  height over that of a round wisp
    area    area over the full one
    """

    up: np.ndarray
    squash: np.ndarray
    area: np.ndarray


def wisp_states(height: Reals, age_s: Reals, area: Reals, u: Reals, v: Reals) -> WispState:
    """Compute wisps of puffs by height [m], age [s], area and two uniform numbers each, (m,)."""
    start = WISP + (1 - WISP) * u**2  # more of it lower down
    up = np.maximum(start * height - settling_speed(v) * age_s, 0.0)
    squash = np.minimum(up / (WISP * height), 1.0)
    return WispState(up, squash, np.maximum(area * smoothstep(squash), LEAST_AREA))


def mean_area(height: Reals, age_s: Reals, area: Reals) -> Reals:
    """Compute the expected area of wisps of puffs over full ones, by height, age and area, (m,)."""
    middles = (np.arange(_STRATA) + 0.5) / _STRATA
    total = np.zeros(len(height))
    for u in middles:
        for v in middles:
            total += wisp_states(
                height, age_s, area, np.full(len(height), u), np.full(len(height), v)
            ).area
    return total / _STRATA**2


def random_offset(radius: Reals, u: Reals, v: Reals) -> Float64[np.ndarray, "m 2"]:
    """Compute the offsets of wisps from the middle of puffs of these radii, (m, 2) [m]."""
    turn, out = 2 * np.pi * u, radius * np.sqrt(v)
    return out[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
