"""Places and areas of puffs of dust at a time, and of their wisps and grains.

Footfalls, wisps and grains are rows of arrays; ``row`` says which puff a wisp or grain is of.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from scenes.dust import growth
from scenes.dust.footfalls import Footfalls, Legs, Walkers, landing, random_units
from scenes.dust.growth import LIFE_S, WISP, WISPS, WispState
from scenes.dust.part_ids import footfall_number
from scenes.particles.shapes import points_in_ball
from scenes.terrain.ground import Ground


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
