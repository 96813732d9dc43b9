"""How puffs of particles are born, wander, spread and die: functions of (seed, birth, time) alone.

No frame needs another, and time may run any way.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from scenes.noise.philox import hash_name
from scenes.particles.kinds import SHORTEST_LIFE, PlumeKind
from scenes.particles.shapes import points_in_ball, random_units, smoothstep

SMALLEST, LARGEST = 0.7, 1.3
"""Sizes of particles beside each other."""

_WAKING, _DYING = 0.12, 0.4
"""Shares of life over which particles come to size, and dwindle."""

_GROWTH, _BENT, _SLOWING = 0.7, 1.6, 0.85
"""Powers of age: how a puff spreads, drifts ever faster, and rises ever slower."""

_LEAST_SIZE = 1e-3
"""Least size of what is just born, or has just died, as a share of its full size."""


class Puffs(NamedTuple):
    """Puffs at some time: share of life gone (n,), middle (n, 3) [m], radius (n,) [m], and size
    (n,) of their particles beside the largest they get to, above 0.
    """

    age: np.ndarray
    middle: np.ndarray
    radius: np.ndarray
    size: np.ndarray


@dataclass(frozen=True)
class Growth:
    """The puffs of one plume: its kind, its name and seed, its size, and where the wind blows to,
    clockwise from north [degrees].
    """

    kind: PlumeKind
    name: str
    seed: int
    size: float
    azimuth_deg: float

    def live(self, time_s: float) -> Ints:
        """Birth numbers of the puffs that live at a time, in a row."""
        rate, life = self.kind.rate, self.kind.life_s
        births = np.arange(math.floor((time_s - life) * rate) - 1, math.floor(time_s * rate) + 2)
        born, lives = self.lifetimes(births)
        return births[(born <= time_s) & (time_s < born + lives)]

    def lifetimes(self, births: Ints) -> tuple[Reals, Reals]:
        """When puffs are born and how long each lives, (n,) each [s]."""
        u = random_units(births, 0 * births, self.seed, hash_name(self.name))
        lives = self.kind.life_s * (SHORTEST_LIFE + (1 - SHORTEST_LIFE) * u[:, 1])
        return (births + u[:, 0]) / self.kind.rate, lives

    def puffs(self, time_s: float, births: Ints, base: Float64[np.ndarray, "3"]) -> Puffs:
        """Puffs as they are at a time, alive or not, of a plume that rises from ``base`` (3,); in
        metres.
        """
        kind, u = self.kind, random_units(births, 0 * births, self.seed, hash_name(self.name))
        born, lives = self.lifetimes(births)
        age = (time_s - born) / lives
        s = np.maximum(age, 0.0)
        mouth = kind.mouth * np.sqrt(u[:, 2])
        wander, turn = kind.wander * s, 2 * np.pi * (u[:, 4] + (0.5 + u[:, 5]) * s)
        middle = self.axis(s)
        middle[:, 0] += mouth * np.cos(2 * np.pi * u[:, 3]) + wander * np.cos(turn)
        middle[:, 1] += mouth * np.sin(2 * np.pi * u[:, 3]) + wander * np.sin(turn)
        radius = kind.young + (kind.old - kind.young) * s**_GROWTH
        size = np.maximum(smoothstep(s / _WAKING) * smoothstep((1 - s) / _DYING), _LEAST_SIZE)
        at = base + self.size * middle
        return Puffs(age, at, self.size * np.maximum(radius, _LEAST_SIZE), size)

    def members(self, birth: Ints, number: Ints) -> tuple[Points, Reals]:
        """Where particles are in puffs of radius 1, (n, 3), and their sizes, (n,)."""
        u = random_units(birth, number + 1, self.seed, hash_name(self.name))
        return points_in_ball(u), SMALLEST + (LARGEST - SMALLEST) * u[:, 3]

    def areas(self, births: Ints) -> tuple[Float64[np.ndarray, "u k"], Ints]:
        """Areas of all particles of each puff, those of size 1 being 1; and its row for each."""
        distinct, row = np.unique(births, return_inverse=True)
        n = self.kind.particles
        every = np.tile(np.arange(n), len(distinct))
        sizes = self.members(np.repeat(distinct, n), every)[1]
        return (sizes**2).reshape(len(distinct), n), row

    def axis(self, age: Reals) -> Points:
        """The way of a puff without its own wandering, from the ground, in sizes, (n, 3)."""
        wind = math.radians(self.azimuth_deg)
        away = self.kind.lean * age**_BENT
        up = self.kind.height * age**_SLOWING
        return np.stack((away * math.sin(wind), away * math.cos(wind), up), axis=1)
