"""Poses at a phase of a motion, by NumPy: the readable reference of ``scenes.rig.pose``."""

import numpy as np

from scenes.rig.rig import Motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype


def motion_at(motion: Motion, phase: float) -> tuple[np.ndarray, np.ndarray]:
    """Rotations (j, 4) and shift (3,) at a phase [cycles]."""
    along = (phase % 1.0) * len(motion.rotations)
    key = min(int(along), len(motion.rotations) - 1)
    after, share = (key + 1) % len(motion.rotations), along - key
    shift = (1 - share) * motion.shift[key] + share * motion.shift[after]
    return slerp(motion.rotations[key], motion.rotations[after], share), shift


def at_phase(prototype: RiggedPrototype, phase: float) -> Prototype:
    """The object at a phase of its motion."""
    return prototype.posed(*motion_at(prototype.motion, phase))


def slerp(a: np.ndarray, b: np.ndarray, share: float) -> np.ndarray:
    """Spherical interpolation from a (share 0) to b (share 1), the short way (Shoemake 1985)."""
    cos = (a * b).sum(axis=-1, keepdims=True)
    b, cos = np.where(cos < 0, -b, b), np.abs(cos)
    sine = np.linalg.norm(b - cos * a, axis=-1, keepdims=True)
    angle = np.arctan2(sine, cos)
    near = sine < 1e-9
    safe = np.where(near, 1.0, sine)
    first = np.where(near, 1 - share, np.sin((1 - share) * angle) / safe)
    second = np.where(near, share, np.sin(share * angle) / safe)
    return first * a + second * b
