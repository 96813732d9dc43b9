"""Where and when do walkers' feet strike the ground, and so raise dust?

Footfall k of a leg is when its walker's phase, counted on through all cycles, comes to k + strike.
The walker was then at that point of its patrol (``scenes.figures.patrol``), and the foot over the
footprint that ``scenes.rig.rig`` has for it as it lands.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Ints, Reals
from lod.camera import Corner
from scenes.figures.patrol import PatrolOrbit
from scenes.noise import philox4x64, unit_float
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


def fastest(legs: Legs) -> Reals:
    """Compute the speed of each prototype at its own stride, (v,) [m/s]: no walker exceeds it."""
    return legs.stride / legs.period


@njit(cache=True)
def object_keys(cell_x, cell_y, index, seed, word):  # type: ignore[no-untyped-def]
    """Number of each object of a field by its cell and index, (n,) int64."""
    found = np.empty(len(index), np.int64)
    for i in range(len(index)):
        x, y, block = np.uint64(cell_x[i]), np.uint64(cell_y[i]), np.uint64(index[i])
        found[i] = np.int64(philox4x64(x, y, block, np.uint64(0), seed, word)[0])
    return found


@njit(cache=True)
def random_units(key, footfall, number, seed, word):  # type: ignore[no-untyped-def]
    """Four random numbers in [0, 1) for each (key, footfall, number), (m,) int64 each, (m, 4)."""
    u = np.empty((len(key), 4))
    for i in range(len(key)):
        who, which, block = np.uint64(key[i]), np.uint64(footfall[i]), np.uint64(number[i])
        words = philox4x64(who, which, block, np.uint64(1), seed, word)
        for k in range(4):
            u[i, k] = unit_float(words[k])
    return u
