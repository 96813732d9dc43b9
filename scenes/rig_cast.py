"""What the compiled walks of ``rig_pose`` read: the cast of a species, and the bodies to be
posed.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.arrays import freeze
from lod.errors import InputError
from scenes.rig import Rig
from scenes.rig_motion import Motion
from scenes.rig_prototype import RiggedPrototype


class Tables(NamedTuple):
    """What the walks read. Rows of joints and keys are those of all prototypes end to end.

    cast  (v, 5) of each prototype: its first joint, joints, first key row, keys, first row of
        shift
    joint (j, 4) parent within the prototype, whether any key differs, knee and ankle where this is
        a leg's hip, else −1
    offset (j, 4) from the parent, and the bend of the leg
    turns (t, 6) quaternion of each key and joint, and the angle to the next key and its sine
    shift (s, 3) of each key
    """

    cast: np.ndarray
    joint: np.ndarray
    offset: np.ndarray
    turns: np.ndarray
    shift: np.ndarray


@dataclass(frozen=True, eq=False)
class Cast:
    """The rigs and motions of a species' prototypes, ready for the walks."""

    tables: Tables
    most_joints: int

    @staticmethod
    def of(prototypes: tuple[RiggedPrototype, ...]) -> "Cast":
        """Lay them end to end."""
        if not prototypes:
            raise InputError("prototypes", 0, "at least one prototype")
        rigs, motions = [p.rig for p in prototypes], [p.motion for p in prototypes]
        sizes = np.array([len(rig) for rig in rigs])
        keys = np.array([len(motion.turns) for motion in motions])
        pairs = list(zip(rigs, motions, strict=True))
        firsts = (_starts(count)[:-1] for count in (sizes, (keys + 1) * sizes, keys + 1))
        first_joint, first_key, first_shift = firsts
        tables = Tables(
            cast=np.stack((first_joint, sizes, first_key, keys, first_shift), axis=1),
            joint=np.concatenate([_joint_rows(rig, motion) for rig, motion in pairs]),
            offset=np.concatenate([_offset_rows(rig, motion) for rig, motion in pairs]),
            turns=np.concatenate([_key_rows(motion) for motion in motions]),
            shift=np.concatenate([np.vstack((m.shift, m.shift[:1])) for m in motions]),
        )
        return Cast(tables, int(sizes.max()))


@dataclass(frozen=True, eq=False)
class Bodies:
    """Objects to be posed.

    origin (n, 3) where each stands, in the frame's coordinates [m]; cos, sin (n,) of its heading
    variant (n,) its prototype in the cast; phase (n,) of its motion [cycles]
    gradient (n, 2) of the ground it stands on, along the frame's x and y [m/m]; 0 = level
    """

    origin: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    variant: np.ndarray
    phase: np.ndarray
    gradient: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, origin=np.float64, cos=np.float64, sin=np.float64, variant=np.int64)
        freeze(self, phase=np.float64, gradient=np.float64)
        n = len(self.variant)
        shapes = {"origin": (n, 3), "cos": (n,), "sin": (n,), "phase": (n,), "gradient": (n, 2)}
        for key, shape in shapes.items():
            if getattr(self, key).shape != shape:
                raise InputError(f"bodies.{key}", getattr(self, key).shape, f"its shape is {shape}")
        if not np.isfinite(self.phase).all():
            raise InputError("bodies.phase", "a number that is not finite", "every phase is finite")

    def __len__(self) -> int:
        return len(self.variant)

    def columns(self) -> tuple[np.ndarray, ...]:
        """What the walks read; phases within one cycle."""
        places = (self.origin, self.cos, self.sin, self.variant)
        return *places, self.phase - np.floor(self.phase), self.gradient


def _starts(counts: np.ndarray) -> np.ndarray:
    return np.concatenate(([0], np.cumsum(counts)))


def _joint_rows(rig: Rig, motion: Motion) -> np.ndarray:
    rows = np.full((len(rig), 4), -1)
    rows[:, 0] = rig.parent
    rows[:, 1] = (np.abs(motion.turns - motion.turns[:1]) > 1e-15).any(axis=(0, 2))
    for hip, knee, ankle in motion.legs:
        rows[hip, 2:] = knee, ankle
    return rows


def _offset_rows(rig: Rig, motion: Motion) -> np.ndarray:
    bend = np.zeros((len(rig), 1))
    bend[motion.legs[:, 0], 0] = motion.bend
    return np.hstack((rig.offset, bend))


def _key_rows(motion: Motion) -> np.ndarray:
    """Keys, with key 0 again at the end and every sign as the key before; and the way to the
    next.
    """
    cos = (motion.turns[-1:] * motion.turns[:1]).sum(axis=-1, keepdims=True)
    turns = np.concatenate((motion.turns, motion.turns[:1] * np.copysign(1.0, cos)))
    after = np.concatenate((turns[1:], turns[-1:]))
    cos = (turns * after).sum(axis=-1, keepdims=True)
    sine = np.linalg.norm(after - cos * turns, axis=-1, keepdims=True)
    return np.concatenate((turns, np.arctan2(sine, cos), sine), axis=-1).reshape(-1, 6)
