"""What a puff of dust does from its footfall on: it is thrown up, spreads, drifts, settles and
thins.

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
lengths are shares of the stride, 1.4 m for a person. What drawn grains stand for is finer by far.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from scenes.gait.gait import GRAVITY
from scenes.particles.shapes import smoothstep

LIFE_S = 3.5
RISE_S = 0.5

YOUNG, OLD = 0.06, 0.34
"""Radius of a puff as the foot strikes and at the end."""

LOW, HIGH = 0.02, 0.24
"""Its height."""

WAKE = 0.12
"""How far it follows the walker."""

STIR_M_S = 0.1
"""Greatest speed of the air where it is calm, any way [m/s]."""

WISP = 0.1
"""Size of a wisp beside its puff's."""

GRAIN = 6.6e-4
"""Radius of a grain."""

WISPS, GRAINS = 256, 128
"""Wisps of a puff, and grains of a wisp."""

WISPS_EACH, GRAINS_EACH = 16, 4
"""Wisps, and grains, for which one larger grain stands in the leaf look of puffs, and of wisps."""

FAINTEST = 0.35
"""Area of the faintest puff beside the thickest: no two footfalls are alike."""

STEEPEST = 0.7
"""Slope beyond which a trail does not follow the ground, and a puff does not tilt: loose ground is
no steeper than its angle of repose, 35°."""

LEAST_AREA = 1e-6
"""Least area of what is not there yet, or no longer, beside its full one."""

_FINEST_M, _COARSEST_M = 12e-6, 70e-6
_DENSITY, _VISCOSITY = 2650.0, 1.81e-5
"""Grains [m]; quartz [kg/m³], air of 15 °C [Pa·s]."""

_ROUGHNESS_M, _CROWNS_M, _ANKLES_M = 0.01, 10.0, 0.3
_WAKING_S, _WAKE_S, _GROWTH = 0.25, 0.6, 0.6
_STRATA = 5


class PuffShape(NamedTuple):
    """Puffs at some age: radius, height, way after the walker, (m,) each [m]; and area beside the
    full one, (m,).
    """

    radius: np.ndarray
    height: np.ndarray
    wake: np.ndarray
    area: np.ndarray


def puff_shapes(age_s: Reals, stride: Reals) -> PuffShape:
    """Puffs so old, from 0 to LIFE_S, (m,) each."""
    s = age_s / LIFE_S
    radius = YOUNG + (OLD - YOUNG) * s**_GROWTH
    height = LOW + (HIGH - LOW) * -np.expm1(-age_s / RISE_S)
    wake = WAKE * -np.expm1(-age_s / _WAKE_S)
    area = smoothstep(age_s / _WAKING_S) * (1 - s) ** 1.5
    return PuffShape(stride * radius, stride * height, stride * wake, area)


def settling_speed(u: Reals) -> Reals:
    """Speeds of settling of grains from uniform numbers, by Stokes' law; sizes log-uniform."""
    diameter = _FINEST_M * (_COARSEST_M / _FINEST_M) ** u
    return _DENSITY * GRAVITY * diameter**2 / (18 * _VISCOSITY)


def wind_near_ground(wind_m_s: float) -> float:
    """Speed of the wind where dust is, from that at the height of crowns: the logarithmic profile
    over bare ground (Oke, "Boundary Layer Climates", 2nd ed. 1987, ch. 2) [m/s].
    """
    above = np.log(np.array((_ANKLES_M, _CROWNS_M)) / _ROUGHNESS_M)
    return float(wind_m_s * above[0] / above[1])


class WispState(NamedTuple):
    """Wisps above the ground (m,) [m], how high beside round ones (m,), and their areas beside the
    full one, (m,).
    """

    up: np.ndarray
    squash: np.ndarray
    area: np.ndarray


def wisp_states(height: Reals, age_s: Reals, area: Reals, u: Reals, v: Reals) -> WispState:
    """Wisps of puffs so high and thick, row by row, from two uniform numbers each."""
    start = WISP + (1 - WISP) * u**2  # more of it lower down
    up = np.maximum(start * height - settling_speed(v) * age_s, 0.0)
    squash = np.minimum(up / (WISP * height), 1.0)
    return WispState(up, squash, np.maximum(area * smoothstep(squash), LEAST_AREA))


def mean_area(height: Reals, age_s: Reals, area: Reals) -> Reals:
    """Mean area of the wisps of puffs so high and thick beside full ones, (m,)."""
    middles = (np.arange(_STRATA) + 0.5) / _STRATA
    total = np.zeros(len(height))
    for u in middles:
        for v in middles:
            total += wisp_states(
                height, age_s, area, np.full(len(height), u), np.full(len(height), v)
            ).area
    return total / _STRATA**2


def random_offset(radius: Reals, u: Reals, v: Reals) -> Float64[np.ndarray, "m 2"]:
    """How far wisps of puffs so wide are from the middle, (m, 2) [m], from two uniform numbers."""
    turn, out = 2 * np.pi * u, radius * np.sqrt(v)
    return out[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
