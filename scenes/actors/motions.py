"""How a body moves at a speed: the stride, the cadence and the share of its walk that it takes.

Stride goes as speed to the power 0.6, as among the walkers of a field (``scenes.gait.patrol``).
Below ``SLOWEST`` of its own speed a walker's strides keep their length and its pose goes over to
that at rest, in steps of an eighth; from there on it stands.
"""

import math
from dataclasses import replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from scenes.models.catalogue import at_rest
from scenes.rig.keyframes import Motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import Quaternions, rotate_vectors

EIGHTHS = 8
"""Steps in which a pose goes from rest (0) to the whole walk."""

SLOWEST = 0.3
"""Speed below which a walker's pose goes over to rest, as a share of its prototype's speed."""

STRIDE_POWER = 0.6
"""Power of the speed as which the stride goes."""

LONGEST_STRIDE = 1.3
"""Longest stride, as a share of the prototype's; faster bodies take more strides."""


class Step(NamedTuple):
    """How a body steps: eighths of its walk, stride as a share, cycles of its motion a second."""

    eighths: int
    stride_factor: float
    cadence: float


def step_at(motion: Motion, speed: float) -> Step:
    """Find how a body with that motion steps at a speed [m/s]."""
    if motion.stride == 0:
        return Step(EIGHTHS, 1.0, 1.0 / motion.period)
    relative = speed / motion.speed
    if relative < 1e-3:
        return Step(0, 1.0, 0.0)
    eighths = min(EIGHTHS, math.ceil(EIGHTHS * relative / SLOWEST))
    factor = min(max(relative, SLOWEST) ** STRIDE_POWER, LONGEST_STRIDE)
    return Step(eighths, factor, speed / (factor * motion.stride * eighths / EIGHTHS))


@lru_cache(maxsize=512)
def with_share(prototype: RiggedPrototype, eighths: int) -> RiggedPrototype:
    """Return the prototype with so many eighths of its motion, the rest of it as it stands."""
    motion, share = prototype.motion, eighths / EIGHTHS
    if eighths == EIGHTHS or motion.stride == 0:
        return prototype
    if eighths == 0:
        return at_rest(prototype)
    rest = np.broadcast_to(prototype.rig.rest, motion.rotations.shape)
    turned = slerp(rest, motion.rotations, share)
    shift, stride = motion.shift * share, motion.stride * share
    less = replace(motion, rotations=turned, shift=shift, stride=stride)
    # Limbs half way between two poses are not half as high: feet stay on the ground, none below it.
    down = share * lowest(prototype, motion) - lowest(prototype, less)
    raised = shift + down[:, None] * (0.0, 0.0, 1.0)
    return prototype.with_motion(replace(less, shift=raised))


def lowest(prototype: RiggedPrototype, motion: Motion) -> np.ndarray:
    """Compute the height of the lowest point of any stick at each key of a motion, (k,) [m]."""
    origin, facing = prototype.rig.frames(motion.rotations, motion.shift)
    low = np.full(len(motion.rotations), np.inf)
    for table in prototype.full_detail_sticks():
        for on, point, radius in (
            (table.start_joint, table.start, table.start_radius),
            (table.end_joint, table.end, table.end_radius),
        ):
            own = on >= 0  # what a body wears itself does not move against it
            at = rotate_vectors(facing[:, on[own]], point[own]) + origin[:, on[own]]
            low = np.minimum(low, (at[..., 2] - radius[own]).min(axis=1, initial=np.inf))
    return low


def slerp(a: Quaternions, b: Quaternions, share: float) -> np.ndarray:
    """Interpolate between rotations (…, 4), the shorter way round (Shoemake 1985)."""
    cosine = (a * b).sum(axis=-1, keepdims=True)
    b, cosine = b * np.copysign(1.0, cosine), np.abs(cosine)
    sine = np.linalg.norm(b - cosine * a, axis=-1, keepdims=True)
    angle = np.maximum(np.arctan2(sine, cosine), 1e-9)
    return (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def pose_at(prototype: RiggedPrototype, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """Compute rotations (j, 4) and shift (3,) [m] of a prototype's motion at a phase [cycles]."""
    motion = prototype.motion
    keys = len(motion.rotations)
    along = (phase % 1.0) * keys
    k = min(int(along), keys - 1)
    rotations = slerp(motion.rotations[k], motion.rotations[(k + 1) % keys], along - k)
    shift = (1 - along + k) * motion.shift[k] + (along - k) * motion.shift[(k + 1) % keys]
    return rotations, shift


def stick_ends(prototype: RiggedPrototype) -> np.ndarray:
    """Compute both ends of every stick at each key, in the object's own frame, (k, e, 3) [m]."""
    motion = prototype.motion
    origin, facing = prototype.rig.frames(motion.rotations, motion.shift)
    ends = []
    for table in prototype.full_detail_sticks():
        for on, point in ((table.start_joint, table.start), (table.end_joint, table.end)):
            own = on >= 0  # what a body wears itself does not move against it
            ends.append(rotate_vectors(facing[:, on[own]], point[own]) + origin[:, on[own]])
    return np.concatenate(ends, axis=1)
