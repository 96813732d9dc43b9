"""Where walkers that circle their homes are at a time: in closed form, so any frame stands alone.

A walker goes round a circle about its home at an even speed, and the ground it covers drives its
gait: one cycle of the motion a stride. Where homes are a Poisson process and starts and
directions are drawn for each home alone, the walkers are at any time a Poisson process of the same
density (displacement theorem: Kingman, "Poisson Processes", 1993, §5.5), so the law's predictions
hold for them unchanged.

The motion was made for a straight path. On a circle of radius ρ a print that is x ahead and y
aside of the body moves under the foot by about (x²/2 + x·y)/ρ while it stands; which is little
where a circle is many strides round.
"""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, Reals
from lod.errors import InputError

MIN_STRIDE_FACTOR = 0.82
"""Stride of the walker with the shortest steps, as a share of its prototype's."""


@dataclass(frozen=True, eq=False)
class Walkers(ArrayData):
    """Walkers at one time: offset (n, 2) from their homes [m], cos and sin (n,) of their headings,
    phase (n,) of their motion [cycles].
    """

    offset: FloatArray
    cos: FloatArray
    sin: FloatArray
    phase: FloatArray


class PatrolOrbit(NamedTuple):
    """Circles about their homes on which n walkers patrol, (n,) each.

    radius     of the circle [m]; one for all may be given
    heading    at time 0, anticlockwise from x [rad]; clockwise: which way round
    phase      at time 0 [cycles]
    stride, period  of each one's motion [m, s]; those without a stride stay at home, facing
        ``heading``
    """

    radius: Reals | float
    heading: Reals
    clockwise: np.ndarray
    phase: Reals
    stride: Reals
    period: Reals

    def take(self, rows: np.ndarray) -> "PatrolOrbit":
        """Return the orbits at ``rows``."""
        return PatrolOrbit(self.radius, *(each[rows] for each in self[1:]))

    def at(self, time_s: float | Reals) -> Walkers:
        """Return the walkers at a time, or each at a time of its own, (n,) [s]; any may be below 0.

        Raises InputError for a time that is not finite, or a radius that is not above 0.
        """
        radius = np.broadcast_to(np.asarray(self.radius, np.float64), self.heading.shape)
        if not (np.isfinite(time_s).all() and np.isfinite(radius).all() and np.all(radius > 0)):
            arrived = float(np.max(time_s, initial=0.0)), float(radius.min(initial=math.inf))
            raise InputError("patrol", arrived, "a finite time, a radius above 0 m")
        facing: Reals = self.heading
        away: Reals | float = 0.0
        if (walks := self.stride > 0).any():
            rotations = np.where(self.clockwise, -1.0, 1.0)
            # Whole rounds and whole cycles drop out before they cost any digits.
            rounds = np.fmod(time_s * (self.stride / self.period) / (2 * np.pi * radius), 1.0)
            facing = self.heading + rotations * 2 * np.pi * rounds
            away = np.where(walks, radius, 0.0) * rotations
        cos, sin = np.cos(facing), np.sin(facing)
        offset = np.stack((away * sin, -away * cos), axis=1)
        phase = np.mod(self.phase + np.fmod(time_s / self.period, 1.0), 1.0)
        return Walkers(offset, cos, sin, phase)


def stride_factors(u: Reals) -> tuple[Reals, Reals]:
    """Return each one's stride and period as shares of its prototype's, from uniform numbers (n,).

    By the rule that gaits are made by (``gait``): stride goes as Froude^0.3 and speed as its root,
    so that one whose stride is s times as long takes s^(−2/3) times as long over it.
    """
    stride = MIN_STRIDE_FACTOR + (1.0 - MIN_STRIDE_FACTOR) * u
    return stride, stride ** (-2 / 3)
