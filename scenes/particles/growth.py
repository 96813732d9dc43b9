"""Life of the puffs of a plume: birth, drift, growth and death as functions of seed and time.

No frame needs another, and time may run any way.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from scenes.noise import hash_name
from scenes.particles.kinds import SHORTEST_LIFE, PlumeKind
from scenes.particles.shapes import points_in_ball, random_units, smoothstep

SMALLEST, LARGEST = 0.7, 1.3
"""Range of the particles' sizes, over the mean."""

_WAKING, _DYING = 0.12, 0.4
"""Shares of life over which particles grow to full size, and shrink to nothing."""

_GROWTH, _BENT, _SLOWING = 0.7, 1.6, 0.85
"""Exponents of age by which a puff spreads, drifts ever faster, and rises ever slower."""

_LEAST_SIZE = 1e-3
"""Least size of a particle at birth and death, as a share of its full size."""


class Puffs(NamedTuple):
    """State of n puffs at one time.

    age (n,)        share of life that is over
    middle (n, 3), radius (n,)  of each puff [m]
    size (n,)       factor on the size of its particles, above 0 and at most 1
    """

    age: np.ndarray
    middle: np.ndarray
    radius: np.ndarray
    size: np.ndarray


@dataclass(frozen=True)
class Growth:
    """Law by which the puffs of one plume live.

    size         factor on every length
    azimuth_deg  where the wind blows to, clockwise from north [degrees]
    """

    kind: PlumeKind
    name: str
    seed: int
    size: float
    azimuth_deg: float

    def live(self, time_s: float) -> Ints:
        """Return the birth numbers of the puffs that live at a time, ascending."""
        rate, life = self.kind.rate, self.kind.life_s
        births = np.arange(math.floor((time_s - life) * rate) - 1, math.floor(time_s * rate) + 2)
        born, lives = self.lifetimes(births)
        return births[(born <= time_s) & (time_s < born + lives)]

    def lifetimes(self, births: Ints) -> tuple[Reals, Reals]:
        """Return the times of birth and lengths of life of puffs, (n,) each [s]."""
        u = random_units(births, 0 * births, self.seed, hash_name(self.name))
        lives = self.kind.life_s * (SHORTEST_LIFE + (1 - SHORTEST_LIFE) * u[:, 1])
        return (births + u[:, 0]) / self.kind.rate, lives

    def puffs(self, time_s: float, births: Ints, base: Float64[np.ndarray, "3"]) -> Puffs:
        """Return the puffs of these births at a time, alive or not.

        base (3,)  point that the plume rises from [m]
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
        """Place particles in puffs of radius 1, (n, 3), with sizes over the mean, (n,)."""
        u = random_units(birth, number + 1, self.seed, hash_name(self.name))
        return points_in_ball(u), SMALLEST + (LARGEST - SMALLEST) * u[:, 3]

    def areas(self, births: Ints) -> tuple[Float64[np.ndarray, "u k"], Ints]:
        """Compute areas (u, k) of all particles of distinct puffs, and each birth's row of them,
        (n,).

        A particle of size 1 has area 1.
        """
        distinct, row = np.unique(births, return_inverse=True)
        n = self.kind.particles
        every = np.tile(np.arange(n), len(distinct))
        sizes = self.members(np.repeat(distinct, n), every)[1]
        return (sizes**2).reshape(len(distinct), n), row

    def axis(self, age: Reals) -> Points:
        """Compute the path of a puff by age in a plume of size 1 that does not wind, (n, 3) [m]."""
        wind = math.radians(self.azimuth_deg)
        away = self.kind.lean * age**_BENT
        up = self.kind.height * age**_SLOWING
        return np.stack((away * math.sin(wind), away * math.cos(wind), up), axis=1)
