"""Footfalls of walkers, which raise dust, and the colour of the dust that they raise.

Footfall k of a leg is when its walker's phase, counted on through all cycles, comes to k + strike.
The walker was then at that point of its patrol (``scenes.field.species_field``), and the foot over
the footprint that ``scenes.rig.rig`` has for it as it lands.

The colour of dust follows from that of the ground that it comes from. A layer of grains that
scatter a share w of what they meet, evenly to all sides, sends back ρ = (1 − γ)/(1 + γ) of the
light, γ = √(1 − w): the diffusive reflectance of B. Hapke, "Bidirectional reflectance spectroscopy
1. Theory", J. Geophys. Res. 86:3039 (1981). Turned round, the colour ρ of the ground gives w of one
grain: brighter and paler, as raised dust is. What is drawn stands for a wad of many finer grains,
which shade each other, though less than in a deep layer: it has the geometric mean of both."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Reals
from lod.camera import Corner
from scenes.field.species_field import PatrolOrbit
from scenes.ground.relief import Relief
from scenes.ground.shading import GROUND_MATERIALS, SNOW, ground_colours
from scenes.particles.system import SHADES
from scenes.rig.rig import Motion, print_and_swing


@dataclass(frozen=True, eq=False)
class Legs:
    """Legs of prototypes, (v, l) each; ``walks`` is false for legs that a prototype lacks.

    walks          whether the foot strikes the ground as its walker goes on
    strike         phase at which it does
    ahead, aside   where the middle of its sole is then, from the body, in mid-stance [m]
    stance         how far its print is ahead of mid-stance then, at the prototype's stride [m]
    stride, period (v,) of each prototype [m, s]
    """

    walks: np.ndarray
    strike: np.ndarray
    ahead: np.ndarray
    stance: np.ndarray
    aside: np.ndarray
    stride: np.ndarray
    period: np.ndarray

    @staticmethod
    def of(motions: Sequence[Motion]) -> "Legs":
        """Return the legs of prototypes that move by these key frames."""
        most = max(len(motion.feet) for motion in motions)
        columns = np.zeros((5, len(motions), max(most, 1)))
        for row, motion in enumerate(motions):
            feet, n = motion.feet, len(motion.feet)
            landed = [print_and_swing(0.0, duty)[0] for duty in feet.duty.tolist()]
            sole = feet.home + feet.sole.mean(axis=1)
            columns[0, row, :n] = motion.stride > 0
            columns[1, row, :n] = feet.strike
            columns[2, row, :n], columns[4, row, :n] = sole.T
            columns[3, row, :n] = motion.stride * np.array(landed)
        sizes = (np.array([getattr(m, k) for m in motions]) for k in ("stride", "period"))
        return Legs(columns[0] > 0, *columns[1:], *sizes)

    @property
    def reach(self) -> Reals:
        """Return the farthest of each prototype's soles from the body as they strike, (v,) [m]."""
        longest = np.abs(self.ahead) + np.abs(self.stance)
        return np.where(self.walks, np.hypot(longest, self.aside), 0.0).max(axis=1)

    @property
    def fastest(self) -> Reals:
        """Return the speed of each prototype at its own stride, (v,) [m/s]; none exceeds it."""
        return self.stride / self.period

    def slots(self, life_s: float) -> int:
        """Number of footfalls of a leg of which one at least is older than a puff's life."""
        walking = self.period[self.walks.any(axis=1)]
        return 1 if not len(walking) else math.ceil(life_s / float(walking.min())) + 1


@dataclass(frozen=True, eq=False)
class Walkers:
    """Walkers on their patrols, (n,) each, in a frame at a grid corner.

    corner         grid corner of the frame
    home           (n, 2) point about which each patrols [m]
    prototype      row of its prototype
    stride_factor  its stride as a share of its prototype's
    rounds         its patrol
    key            number that no other walker has
    """

    corner: Corner
    home: np.ndarray
    prototype: np.ndarray
    stride_factor: np.ndarray
    rounds: PatrolOrbit
    key: np.ndarray

    def __len__(self) -> int:
        return len(self.prototype)


class Footfalls(NamedTuple):
    """Footfalls by walker, leg, and number of the gait cycle, (m,) each."""

    owner: np.ndarray
    leg: np.ndarray
    number: np.ndarray

    def take(self, rows: np.ndarray) -> "Footfalls":
        """Return the footfalls at these rows."""
        return Footfalls(*(each[rows] for each in self))


class Landing(NamedTuple):
    """Times, places and headings of footfalls.

    time_s (m,)     time of each [s]
    xy (m, 2)       middle of its sole [m]
    heading (m, 2)  unit vector of the walker's way
    """

    time_s: np.ndarray
    xy: np.ndarray
    heading: np.ndarray


def footfalls(walkers: Walkers, legs: Legs, owner: Ints, slots: int, time_s: float) -> Footfalls:
    """Return the last ``slots`` footfalls of every leg of these walkers.

    Those of a walker are in an order in which each keeps its place until it is the oldest, and the
    next one takes it.
    """
    most = legs.strike.shape[1]
    who = np.repeat(owner, most * slots)
    leg = np.tile(np.repeat(np.arange(most), slots), len(owner))
    slot = np.tile(np.arange(slots), len(owner) * most)
    cycles = walkers.rounds.phase + time_s / walkers.rounds.period
    newest = np.floor(cycles[who] - legs.strike[walkers.prototype[who], leg]).astype(np.int64)
    return Footfalls(who, leg, newest - np.mod(newest - slot, slots))


def landing(walkers: Walkers, legs: Legs, of: Footfalls) -> Landing:
    """Compute the times and places of footfalls."""
    prototype, rounds = walkers.prototype[of.owner], walkers.rounds.take(of.owner)
    where = prototype, of.leg
    time_s = (of.number + legs.strike[where] - rounds.phase) * rounds.period
    body = rounds.at(time_s)
    ahead = legs.ahead[where] + walkers.stride_factor[of.owner] * legs.stance[where]
    aside = legs.aside[where]
    x = body.cos * ahead - body.sin * aside
    y = body.sin * ahead + body.cos * aside
    at = walkers.home[of.owner] + body.offset + np.stack((x, y), axis=1)
    return Landing(time_s, at, np.stack((body.cos, body.sin), axis=1))


_ACROSS_M = 0.25
"""Size of the smallest patches of the ground's colour that show in a puff [m]."""


@dataclass(frozen=True, eq=False)
class Soil:
    """Ground that dust comes from: its relief, and the name of its cover."""

    relief: Relief
    cover: str

    @cached_property
    def ground(self) -> Float64[np.ndarray, "t 3"]:
        """List the colours of the ground that are told apart: moist to dry, steep, snow, (t, 3)."""
        materials = GROUND_MATERIALS[self.cover]
        share = np.linspace(0, 1, SHADES)[:, None]
        between = np.array(materials.moist) * (1 - share) + np.array(materials.dry) * share
        others = [materials.steep] + [SNOW] * (materials.snow_line is not None)
        return np.concatenate((between, others))

    @property
    def tints(self) -> Float64[np.ndarray, "t 3"]:
        """Return the colours of the dust of each colour of the ground, (t, 3)."""
        return np.sqrt(self.ground * self.grain)

    @property
    def grain(self) -> Float64[np.ndarray, "t 3"]:
        """Return the single-scattering albedo of a grain of each colour of the ground, (t, 3)."""
        return 1 - ((1 - self.ground) / (1 + self.ground)) ** 2

    def tint(self, corner: Corner, xy: Float64[np.ndarray, "m 2"]) -> Ints:
        """Return the row of the nearest colour of the ground at points [m] from a corner, (m,)."""
        relief, size = self.relief, np.full(len(xy), _ACROSS_M)
        rise = relief.height(corner, xy) / (relief.amplitude or 1.0)
        slope = np.hypot(*relief.slopes(corner, xy, 2 * size).T)
        materials = GROUND_MATERIALS[self.cover]
        hidden = np.zeros(len(xy))
        colour = ground_colours(relief.seed, corner, xy, rise, slope, hidden, size, materials)
        away = colour[:, None] - self.ground
        return np.asarray((away**2).sum(axis=2).argmin(axis=1))
