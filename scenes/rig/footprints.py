"""Where is the print of each leg relative to the body, and how far has its foot swung, at a phase?

A print recedes evenly under the body while the foot stands on it, and the foot swings to the next
one, a stride ahead. All prints scale with the stride; how the foot rolls does not.
"""

from dataclasses import dataclass, replace

import numpy as np
from numba import njit

from lod.arrays import ArrayData, FlagArray, FloatArray, IntArray, check_columns
from lod.errors import InputError


@dataclass(frozen=True, eq=False)
class Feet(ArrayData):
    """The legs of an object that stand on the ground, (l,), in any order.

    legs   (l, 3) joints: hip, knee, ankle
    sticks_out (l,) whether its hip turns aside about z, not about x
    bend   (l,) +1 where a positive angle about y flexes the knee, −1 where a negative one does
    strike (l,) phase at which the foot lands; duty (l,) share of the cycle that it stands, above 0
    home   (l, 2) where the print is in mid-stance, in the object's own frame [m]
    steepest (l,) slope that the sole follows; what is steeper, it only touches
    sole   (l, 3, 2) three points that the sole rests on, from its print, in the same axes [m]
    """

    legs: IntArray
    sticks_out: FlagArray
    bend: FloatArray
    strike: FloatArray
    duty: FloatArray
    home: FloatArray
    steepest: FloatArray
    sole: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        n = len(self.legs)
        check_columns("feet", self, legs=(n, 3), bend=(n,), strike=(n,), duty=(n,), home=(n, 2))
        check_columns("feet", self, steepest=(n,), sole=(n, 3, 2), sticks_out=(n,))
        if not np.all((self.duty > 0) & (self.duty <= 1)):
            raise InputError("feet.duty", self.duty.tolist(), "above 0, at most 1")
        if n and np.abs(np.linalg.det(_edges(self.sole))).min() < 1e-12:
            raise InputError("feet.sole", "points in a line", "three points that span a plane")

    def __len__(self) -> int:
        return len(self.legs)

    @property
    def plane(self) -> np.ndarray:
        """Compute matrices (l, 3, 3) from heights at three points to print height and slopes."""
        points = np.concatenate((np.ones((len(self), 3, 1)), self.sole), axis=2)
        return np.linalg.inv(points)

    def scaled(self, factor: float) -> "Feet":
        """Return the feet with every length multiplied by ``factor``."""
        return replace(self, home=self.home * factor, sole=self.sole * factor)


def _edges(sole: np.ndarray) -> np.ndarray:
    return sole[:, 1:] - sole[:, :1]


NO_FEET = Feet(
    np.zeros((0, 3)), *(np.zeros(0),) * 4, np.zeros((0, 2)), np.zeros(0), np.zeros((0, 3, 2))
)


@njit(cache=True, inline="always")
def print_and_swing(own, duty):  # type: ignore[no-untyped-def]
    """Compute how far the last print is ahead of mid-stance, and the foot has swung on [strides].

    The swing goes from 0, while the foot stands, to 1 at the next print. ``own`` is the phase after
    landing, 0 to 1, and ``duty`` the share of the cycle that the foot stands.
    """
    u = (own - duty) / (1.0 - duty) if own > duty else 0.0
    return duty / 2 - own, u * u * (3.0 - 2.0 * u)
