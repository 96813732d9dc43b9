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

SLOWEST = 0.1
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


def planted_phase(motion: Motion, phase: float, before: Step, after: Step) -> float:
    """Return the phase at which feet that stand keep their prints as the stride changes [cycles].

    Prints scale with the stride, those ahead and those behind; so the phase goes on or back by as
    much as leaves the mean of those that stand where it is. Who stood sets off in mid-stance, in
    which a print lies beside the body, as at rest.
    """
    if after.eighths == 0 or not _stands(motion):
        return phase
    if before.eighths == 0:
        return min(_mid_stances(motion), key=lambda each: abs((each - phase + 0.5) % 1.0 - 0.5))
    kept = before.stride_factor * before.eighths / (after.stride_factor * after.eighths)
    middle = prints_ahead(motion, phase)
    return (phase + middle - min(max(middle * kept, -0.5), 0.5)) % 1.0


def prints_ahead(motion: Motion, phase: float) -> float:
    """Compute how far ahead of mid-stance the prints of those feet lie that stand [strides].

    It is the mean of them, and 0 where none stands.
    """
    own = [((phase - strike) % 1.0, duty) for strike, duty in _stands(motion)]
    ahead = [duty / 2 - at for at, duty in own if at <= duty]
    return sum(ahead) / len(ahead) if ahead else 0.0


@lru_cache(maxsize=256)
def _stands(motion: Motion) -> tuple[tuple[float, float], ...]:
    """List the phase at which each leg lands, and the share of the cycle that it stands."""
    return tuple(zip(motion.feet.strike.tolist(), motion.feet.duty.tolist(), strict=True))


@lru_cache(maxsize=256)
def _mid_stances(motion: Motion) -> tuple[float, ...]:
    """Find the phases of mid-stance of a leg at which all that stand are nearest to theirs."""
    off = {}
    for first, share in _stands(motion):
        phase = (first + share / 2) % 1.0
        own = [((phase - strike) % 1.0, duty) for strike, duty in _stands(motion)]
        off[phase] = max(abs(at - duty / 2) for at, duty in own if at <= duty)
    return tuple(phase for phase, most in off.items() if most < min(off.values()) + 1e-9)


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
