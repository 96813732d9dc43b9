"""Which arrays posing reads: the rigs and motions of a species, and the instances to be posed."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, check_columns, frozen
from lod.errors import InputError
from scenes.rig.footprints import print_and_swing
from scenes.rig.keyframes import Motion
from scenes.rig.leg_ik import LegTables, bone_lengths, joint_limit_arcs
from scenes.rig.rig import Rig
from scenes.rig.rigged_prototype import RiggedPrototype

STRAIGHTEST = 0.9985
"""How far a leg stretches at most, as a share of its length, where its motion stretches it less."""

_MIN_ANGLE = 1e-9
"""Least angle between two keys: weights are the shares themselves there [rad]."""

FIRST_JOINT, JOINTS, FIRST_KEY, KEYS, FIRST_SHIFT, FIRST_LEG, LEGS, FIRST_HIP = range(8)
"""Columns of ``PoseColumns.prototypes``: first rows and numbers of a prototype's own rows."""

PARENT, MOVES, KNEE_OF_HIP, ANKLE_OF_HIP, LEG_OF_HIP = range(5)
"""Columns of ``PoseColumns.joint``."""

ANGLE, PER_SINE = 4, 5
"""Columns of ``PoseColumns.keys`` after the quaternion."""

AT_HIP_X, AT_HIP_Y, AT_HIP_Z, FROM_PRINT_X, FROM_PRINT_Y, FROM_PRINT_Z = range(6)
"""Columns of ``PoseColumns.hip``."""


class PoseColumns(NamedTuple):
    """Tables of all prototypes end to end, as compiled kernels read them.

    prototypes (v, 8) rows of each prototype: FIRST_JOINT, JOINTS, …
    joint  (j, 5) PARENT within the prototype; whether any key differs (MOVES); knee, ankle and
        number of the leg whose hip this is, else −1
    offset (j, 3) from the parent [m]
    keys   (t, 6) quaternion of each key and joint, the angle to the next key and one over its sine;
        prototypes that move alike, of several sizes, share these rows
    shift  (s, 3) of each key [m]
    legs   what bends legs, row by row of all legs
    sole   (l, 3, 2), plane (l, 3, 3): as in Feet
    hip    (k, 6) of each key and leg: where the hip is in the object's frame (AT_HIP_X, …), and the
        vector from the print to the ankle (FROM_PRINT_X, …) [m]
    """

    prototypes: np.ndarray
    joint: np.ndarray
    offset: np.ndarray
    keys: np.ndarray
    shift: np.ndarray
    legs: LegTables
    sole: np.ndarray
    plane: np.ndarray
    hip: np.ndarray


@dataclass(frozen=True, eq=False)
class PoseTables:
    """The rigs and motions of a species' prototypes, ready to be posed."""

    columns: PoseColumns
    max_joints: int
    max_legs: int

    @staticmethod
    def of(prototypes: tuple[RiggedPrototype, ...]) -> "PoseTables":
        """Lay the prototypes end to end."""
        if not prototypes:
            raise InputError("prototypes", 0, "at least one prototype")
        rigs, motions = [p.rig for p in prototypes], [p.motion for p in prototypes]
        pairs = list(zip(rigs, motions, strict=True))
        rows, keys = _prototype_rows(rigs, motions)
        legs = LegTables(
            leg=_joined([_leg_rows(rig, motion) for rig, motion in pairs]),
            bones=_joined([bone_lengths(rig, motion) for rig, motion in pairs]),
            arc=_joined([joint_limit_arcs(rig, motion) for rig, motion in pairs]),
            ankle=_joined([_ankle_rows(rig, motion) for rig, motion in pairs]),
        )
        columns = PoseColumns(
            prototypes=frozen(rows, np.int64),
            joint=_joined([_joint_rows(rig, motion) for rig, motion in pairs], np.int64),
            offset=_joined([rig.offset for rig in rigs]),
            keys=frozen(keys, np.float64),
            shift=_joined([np.vstack((m.shift, m.shift[:1])) for m in motions]),
            legs=legs,
            sole=_joined([motion.feet.sole for motion in motions]),
            plane=_joined([motion.feet.plane for motion in motions]),
            hip=_joined([_hip_rows(rig, motion) for rig, motion in pairs]),
        )
        return PoseTables(columns, int(rows[:, JOINTS].max()), int(rows[:, LEGS].max()))


class InstanceColumns(NamedTuple):
    """The arrays of ``Instances``, read-only, as compiled kernels take them."""

    origin: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    prototype: np.ndarray
    phase: np.ndarray
    foot_contacts: np.ndarray


PRINT_X, PRINT_Y, PRINT_Z, AHEAD, SLOPE_X, SLOPE_Y = range(6)
"""Columns of ``Instances.foot_contacts``."""


@dataclass(frozen=True, eq=False)
class Instances(ArrayData):
    """The objects that are to be posed.

    origin (n, 3) where each stands, in the frame's coordinates [m]; cos, sin (n,) of its heading
    prototype (n,) its row in the pose tables; phase (n,) of its motion [cycles]
    foot_contacts (n, legs, 6) of each foot: where its print is, PRINT_X, PRINT_Y and PRINT_Z [m];
        how far that is AHEAD of the prototype's own [m]; and the rotation that tilts the ground
        under it, SLOPE_X and SLOPE_Y of a quaternion whose z is 0

    Raises InputError where shapes do not match or a number is not finite.
    """

    origin: FloatArray
    cos: FloatArray
    sin: FloatArray
    prototype: IntArray
    phase: FloatArray
    foot_contacts: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        n = len(self.prototype)
        check_columns("instances", self, origin=(n, 3), cos=(n,), sin=(n,), phase=(n,))
        contacts = self.foot_contacts
        if contacts.ndim != 3 or contacts.shape[::2] != (n, 6):
            rule = f"its shape is ({n}, legs, 6)"
            raise InputError("instances.foot_contacts", contacts.shape, rule)

    def __len__(self) -> int:
        return len(self.prototype)

    def columns(self) -> InstanceColumns:
        """Return the arrays for compiled kernels, with phases within one cycle."""
        within = frozen(self.phase - np.floor(self.phase), np.float64)
        facing = self.origin, self.cos, self.sin
        return InstanceColumns(*facing, self.prototype, within, self.foot_contacts)


def _joined(tables: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    """Put tables one below the other, read-only."""
    return frozen(np.concatenate(tables), dtype)


def _prototype_rows(rigs: list[Rig], motions: list[Motion]) -> tuple[np.ndarray, np.ndarray]:
    """Make the table of prototypes (v, 8), and the keys of all motions (t, 6)."""
    joints = np.array([len(rig) for rig in rigs])
    keys = np.array([len(motion.rotations) for motion in motions])
    legs = np.array([len(motion.feet) for motion in motions])
    counts = joints, keys + 1, legs, (keys + 1) * legs
    first_joint, first_shift, first_leg, first_hip = map(_starts, counts)
    first_key, key_rows = _shared_keys(motions)
    columns = first_joint, joints, first_key, keys, first_shift, first_leg, legs, first_hip
    return np.stack(columns, axis=1), key_rows


def _starts(counts: np.ndarray) -> np.ndarray:
    """Find the first row of each table, laid end to end, from their numbers of rows."""
    return np.cumsum(counts) - counts


def _joint_rows(rig: Rig, motion: Motion) -> np.ndarray:
    rows = np.full((len(rig), 5), -1)
    rows[:, 0] = rig.parent
    rows[:, 1] = (np.abs(motion.rotations - motion.rotations[:1]) > 1e-15).any(axis=(0, 2))
    for number, (hip, knee, ankle) in enumerate(motion.feet.legs):
        rows[hip, 2:] = knee, ankle, number
    return rows


def _leg_rows(rig: Rig, motion: Motion) -> np.ndarray:
    feet = motion.feet
    bones = np.linalg.norm(rig.offset[feet.legs[:, 1:]], axis=-1).sum(axis=1)
    same = np.full(len(feet), motion.stride)
    middle = feet.home.sum(axis=0) / max(len(feet), 1)
    away = np.linalg.norm(feet.home - middle, axis=1) + motion.stride / 2
    highest = feet.steepest * away
    origin, _ = rig.frames(motion.rotations, motion.shift)
    posed = np.linalg.norm(origin[:, feet.legs[:, 2]] - origin[:, feet.legs[:, 0]], axis=-1)
    longest = np.maximum(STRAIGHTEST * bones, posed.max(axis=0) * (1 + 1e-9))
    columns = (
        feet.strike,
        feet.duty,
        *feet.home.T,
        same,
        longest,
        feet.steepest,
        highest,
        np.full(len(feet), float(motion.tilts)),
    )
    return np.stack(columns, axis=1)


def _ankle_rows(rig: Rig, motion: Motion) -> np.ndarray:
    ankles, functions = motion.feet.legs[:, 2], (np.tan, np.sin, np.tan)
    low, high = (np.radians(np.clip(limit[ankles], -90, 90)) for limit in (rig.low, rig.high))
    return np.stack(
        [f(side[:, k]) for side in (low, high) for k, f in enumerate(functions)], axis=1
    )


def _hip_rows(rig: Rig, motion: Motion) -> np.ndarray:
    """Place hips, and ankles from their prints, at every key and at key 0 again, (k, 6)."""
    feet, keys = motion.feet, len(motion.rotations)
    origin, _ = rig.frames(motion.rotations, motion.shift)
    own = (np.arange(keys)[:, None] / keys - feet.strike) % 1.0
    ahead = np.array([[sum(print_and_swing(o, d)) for o, d in zip(row, feet.duty, strict=True)]
                      for row in own]).reshape(keys, len(feet))  # fmt: skip
    prints = np.zeros((keys, len(feet), 3))
    prints[..., :2] = feet.home
    prints[..., 0] += motion.stride * ahead
    rows = np.concatenate((origin[:, feet.legs[:, 0]], origin[:, feet.legs[:, 2]] - prints), axis=2)
    return np.concatenate((rows, rows[:1])).reshape(-1, 6)


def _shared_keys(motions: list[Motion]) -> tuple[np.ndarray, np.ndarray]:
    """Find the first row of each motion's keys, and make all rows: equal keys stand there once."""
    first: dict[bytes, int] = {}
    rows, starts, count = [np.zeros((0, 6))], [], 0
    for motion in motions:
        name = motion.rotations.tobytes()
        if name not in first:
            first[name] = count
            rows.append(_key_rows(motion))
            count += len(rows[-1])
        starts.append(first[name])
    return np.array(starts), np.concatenate(rows)


def _key_rows(motion: Motion) -> np.ndarray:
    """Make the rows of a motion: its keys, and the way from each to the next.

    Key 0 stands again at the end, and every quaternion has the sign of the key before it.
    """
    cos = (motion.rotations[-1:] * motion.rotations[:1]).sum(axis=-1, keepdims=True)
    rotations = np.concatenate((motion.rotations, motion.rotations[:1] * np.copysign(1.0, cos)))
    after = np.concatenate((rotations[1:], rotations[-1:]))
    cos = (rotations * after).sum(axis=-1, keepdims=True)
    sine = np.linalg.norm(after - cos * rotations, axis=-1, keepdims=True)
    angle = np.maximum(np.arctan2(sine, cos), _MIN_ANGLE)
    return np.concatenate((rotations, angle, 1.0 / np.sin(angle)), axis=-1).reshape(-1, 6)
