"""A cyclic motion of a rig: keyframes of every joint, slerped at each object's own phase."""

import math
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals, check_columns, freeze
from lod.errors import InputError
from scenes.rig.footprints import NO_FEET, Feet
from scenes.rig.rig import Rig
from scenes.rig.rotations import Quaternions


@dataclass(frozen=True, eq=False)
class Motion:
    """One cycle of K key poses, evenly spaced in phase; key K is key 0 again.

    rotations (K, j, 4) of every joint in its parent, of one sign from key to key, so that slerp
            takes the short way
    shift   (K, 3) how far the joints of the object's own frame are from where they rest [m]
    stride  how far the object moves ahead in one cycle; 0 for what stays where it is [m]
    period  how long a cycle lasts [s]
    feet    the legs that stand on the ground
    tilts   whether feet follow slopes across their way, too: those of ankles near the ground
    """

    rotations: np.ndarray
    shift: np.ndarray
    stride: float
    period: float
    feet: Feet = NO_FEET
    tilts: bool = False

    def __post_init__(self) -> None:
        keys = np.asarray(self.rotations, np.float64)
        object.__setattr__(self, "rotations", continuous_signs(keys))
        freeze(self, rotations=np.float64, shift=np.float64)
        _check(self)

    @property
    def speed(self) -> float:
        """Compute the ground speed at which the feet do not slide [m/s]."""
        return self.stride / self.period

    def scaled(self, factor: float) -> "Motion":
        """Return the dynamically similar motion of a rig ``factor`` times as large.

        Time then goes as √length: strides are alike at equal speed²/(g·leg length) (Alexander,
        "Stride length and speed for adults, children, and fossil hominids", Am. J. Phys. Anthropol.
        63:23, 1984).
        """
        period = self.period * math.sqrt(factor) if self.stride else self.period
        lengths = (self.shift * factor, self.stride * factor)
        return Motion(self.rotations, *lengths, period, self.feet.scaled(factor), self.tilts)


def rest_motion(rig: Rig) -> Motion:
    """Return the motion of an object that stays at rest, which has one key."""
    return Motion(rig.rest[None], np.zeros((1, 3)), 0.0, 1.0)


def continuous_signs(rotations: Quaternions) -> Quaternions:
    """Return equal rotations (K, j, 4), every quaternion of the same sign as the key before it."""
    dots = (rotations[1:] * rotations[:-1]).sum(axis=-1)
    flips = np.cumprod(np.where(dots < 0, -1.0, 1.0), axis=0)
    return np.concatenate((rotations[:1], rotations[1:] * flips[..., None]))


def key_phases(keys: int) -> Reals:
    """Give the phases of ``keys`` evenly spaced keys, (K,)."""
    return np.arange(keys) / keys


def _check(motion: Motion) -> None:
    keys = len(motion.rotations)
    if motion.rotations.ndim != 3 or keys == 0 or motion.rotations.shape[2] != 4:
        raise InputError("motion.rotations", motion.rotations.shape, "at least one key, (K, j, 4)")
    check_columns("motion", motion, rotations=motion.rotations.shape, shift=(keys, 3))
    if not (math.isfinite(motion.stride) and motion.stride >= 0):
        raise InputError("motion.stride", motion.stride, "finite, at least 0 m")
    if not (math.isfinite(motion.period) and motion.period > 0):
        raise InputError("motion.period", motion.period, "finite, above 0 s")
    legs = motion.feet.legs
    if legs.size and legs.max() >= motion.rotations.shape[1]:
        raise InputError("motion.feet", int(legs.max()), "a joint of the rig")
