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

Footfalls, wisps and grains are rows of arrays; ``row`` says which puff a wisp or grain is of.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from scenes.figures.gait import GRAVITY
from scenes.ground.relief import Ground
from scenes.particles import puffs as growth
from scenes.particles.footfalls import Footfalls, Legs, Walkers, landing, random_units
from scenes.particles.plume import points_in_ball, smoothstep

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


_BEFORE_S = 1e4
"""Time before 0 from which on footfalls have numbers above 0 [s]."""

_PUFF, _WISP = 1 + WISPS * (1 + GRAINS), 1 + GRAINS


class PartIds(NamedTuple):
    """Footfall, wisp and grain of each part, (n,) each; −1 where it is none."""

    footfall: np.ndarray
    wisp: np.ndarray
    grain: np.ndarray


def footfall_number(legs: Legs, falls: Footfalls) -> Ints:
    """Number of each footfall among those of its walker, (n,)."""
    return falls.number * legs.strike.shape[1] + falls.leg


def decode(legs: Legs, owner: Ints, number: Ints) -> Footfalls:
    """Decode footfalls of walkers by their numbers; the inverse of ``footfall_number``."""
    cycle, leg = np.divmod(number, legs.strike.shape[1])
    return Footfalls(owner, leg, cycle)


def puff_id(legs: Legs, footfall: Ints) -> Ints:
    """Compute the part numbers of the puffs of footfalls, (n,)."""
    return 1 + (footfall + _earliest(legs)) * _PUFF


def wisp_id(puff: Ints, wisp: Ints) -> Ints:
    """Compute the part numbers of wisps of puffs, (n,)."""
    return puff + 1 + wisp * _WISP


def grain_id(wisp: Ints, grain: Ints) -> Ints:
    """Compute the part numbers of grains of wisps, (n,)."""
    return wisp + 1 + grain


def decode_ids(legs: Legs, part: Ints) -> PartIds:
    """Decode footfall, wisp and grain of parts by their numbers."""
    footfall, rest = np.divmod(part - 1, _PUFF)
    wisp, grain = np.divmod(rest - 1, _WISP)
    return PartIds(footfall - _earliest(legs), np.where(rest == 0, -1, wisp), grain - 1)


def _earliest(legs: Legs) -> int:
    return math.ceil(_BEFORE_S / float(legs.period.min())) * legs.strike.shape[1]


@dataclass(frozen=True, eq=False)
class Air:
    """What carries dust, and what it lies on.

    wind_m_s, downwind (2,)  speed of the wind near the ground [m/s], and unit vector of its way
    seed, word               key of the random numbers of one species' dust
    """

    ground: Ground
    wind_m_s: float
    downwind: np.ndarray
    seed: np.uint64
    word: np.uint64


class Puffs(NamedTuple):
    """State of m puffs at one time, (m,) each.

    base (m, 3) middle, on the ground; slope (m, 2) of that; radius, height [m]
    age     time since the footfall, 0 before it [s]
    area    of its wisps over the full one, but for what has settled
    struck  (m, 2) where the foot struck [m]
    key, footfall   number of its walker, and of its footfall among that walker's
    """

    base: np.ndarray
    slope: np.ndarray
    radius: np.ndarray
    height: np.ndarray
    age: np.ndarray
    area: np.ndarray
    struck: np.ndarray
    key: np.ndarray
    footfall: np.ndarray

    @property
    def mean_area(self) -> Reals:
        """Return the expected area of their wisps over full ones, (m,)."""
        return growth.mean_area(self.height, self.age, self.area)

    @property
    def origin(self) -> Points:
        """Return the points that distances are measured to: half-way up, (m, 3) [m]."""
        up = np.zeros((len(self.base), 3))
        up[:, 2] = self.height / 2
        return self.base + up


def puffs_at(air: Air, walkers: Walkers, legs: Legs, falls: Footfalls, time_s: float) -> Puffs:
    """Compute the puffs of footfalls at a time, even before they are up and after they are gone."""
    fell = landing(walkers, legs, falls)
    age = np.clip(time_s - fell.time_s, 0.0, LIFE_S)
    dome = growth.puff_shapes(age, legs.stride[walkers.prototype[falls.owner]])
    key, number = walkers.key[falls.owner], footfall_number(legs, falls)
    u = random_units(key, number, 0 * key, air.seed, air.word)
    turn = 2 * np.pi * u[:, 0]
    stir = growth.STIR_M_S * u[:, 1, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    blown = (stir + air.wind_m_s * air.downwind) * age[:, None]
    xy = fell.xy + dome.wake[:, None] * fell.heading + blown
    height, slope = _ground_below(air.ground, walkers.corner, xy, dome.radius)
    trail = trail_centres(air, walkers, falls.owner, time_s)
    climb = growth.STEEPEST * np.linalg.norm(xy - trail[:, :2], axis=1)
    height = np.clip(height, trail[:, 2] - climb, trail[:, 2] + climb)
    area = dome.area * (growth.FAINTEST + (1 - growth.FAINTEST) * u[:, 2])
    base, size = np.column_stack((xy, height)), (dome.radius, dome.height)
    return Puffs(base, slope, *size, age, area, fell.xy, key, number)


def trail_centres(air: Air, walkers: Walkers, owner: Ints, time_s: float) -> Points:
    """Compute the points of the ground in the middle of walkers' trails, (m, 3) [m].

    They are where each walker was half a puff's life ago, and as far downwind as the dust of then
    has drifted.
    """
    body = walkers.rounds.take(owner).at(time_s - LIFE_S / 2)
    xy = walkers.home[owner] + body.offset + air.wind_m_s * LIFE_S / 2 * air.downwind
    return np.column_stack((xy, air.ground.height(walkers.corner, xy)))


def _ground_below(
    ground: Ground, corner: Corner, xy: Float64[np.ndarray, "m 2"], radius: Reals
) -> tuple[Reals, Float64[np.ndarray, "m 2"]]:
    """Height and slopes of the ground below puffs, from four points of their edges."""
    sides = np.array(((1, 0), (-1, 0), (0, 1), (0, -1)), np.float64)
    edge = (xy + sides[:, None] * radius[:, None]).reshape(-1, 2)
    east, west, north, south = ground.height(corner, edge).reshape(4, -1)
    slope = np.stack((east - west, north - south), axis=1) / (2 * radius[:, None])
    steep = np.linalg.norm(slope, axis=1)
    slope = slope * (growth.STEEPEST / np.maximum(steep, growth.STEEPEST))[:, None]
    return (east + west + north + south) / 4, slope


def wisps_at(air: Air, puffs: Puffs, row: Ints, wisp: Ints) -> tuple[Points, Reals]:
    """Compute the places of wisps (m, 3) [m], and the area of each over the full one, (m,)."""
    lift, flat = _wisp_states(air, puffs, row, wisp)
    return _places_above_ground(puffs, row, flat, lift.up), lift.area


def grains_at(air: Air, puffs: Puffs, row: Ints, wisp: Ints, grain: Ints) -> tuple[Points, Reals]:
    """Compute the places of grains (m, 3) [m], and the area of each over a full one, (m,)."""
    lift, flat = _wisp_states(air, puffs, row, wisp)
    at = points_in_ball(_random_units(air, puffs, row, 1 + WISPS + wisp * growth.GRAINS + grain))
    flat += WISP * puffs.radius[row, None] * at[:, :2]
    up = lift.up + WISP * puffs.height[row] * lift.squash * at[:, 2]
    return _places_above_ground(puffs, row, flat, up), lift.area


def _wisp_states(
    air: Air, puffs: Puffs, row: Ints, wisp: Ints
) -> tuple[WispState, Float64[np.ndarray, "m 2"]]:
    """Height and area of wisps, and their offsets (m, 2) from the middle of their puffs [m]."""
    u = _random_units(air, puffs, row, 1 + wisp)
    lift = growth.wisp_states(puffs.height[row], puffs.age[row], puffs.area[row], u[:, 2], u[:, 3])
    return lift, growth.random_offset(puffs.radius[row], u[:, 0], u[:, 1])


def _places_above_ground(
    puffs: Puffs, row: Ints, flat: Float64[np.ndarray, "m 2"], up: Reals
) -> Points:
    """Places at offsets ``flat`` from the middle of puffs and heights ``up`` above the ground."""
    at = puffs.base[row].copy()
    at[:, :2] += flat
    at[:, 2] += (puffs.slope[row] * flat).sum(axis=1) + up
    return at


def _random_units(air: Air, puffs: Puffs, row: Ints, number: Ints) -> Float64[np.ndarray, "m 4"]:
    who = puffs.key[row], puffs.footfall[row]
    found: Float64[np.ndarray, "m 4"] = random_units(*who, number, air.seed, air.word)
    return found
