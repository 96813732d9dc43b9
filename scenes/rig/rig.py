"""What a rig is: joints of one object, their limits, and the sticks that ride on them.

The frame of the object: origin where it stands on the ground, z up, x the way it faces, y to its
left. A joint sits at ``offset`` in the frame of its parent and turns there; joint −1 is the
object's own frame.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Points, check_columns, frozen
from lod.errors import InputError
from lod.shapes import StickTable
from scenes.rig.rotations import (
    Quaternions,
    Vectors,
    from_euler,
    quaternion_product,
    rotate_vector,
    rotate_vectors,
    to_euler,
)

_SLACK_DEG = 1e-6


@dataclass(frozen=True, eq=False)
class Rig(ArrayData):
    """The joints of one object, parents before children.

    name    of every joint
    parent  (j,) −1 for joints that sit in the object's own frame
    offset  (j, 3) origin in the parent's frame [m]
    rest    (j, 4) rotation of each joint as the object stands, (x, y, z, w)
    low, high (j, 3) least and greatest angle about x, y, z, in Rz·Ry·Rx [degrees]
    shift_low, shift_high (3,) how far the joints of the object's own frame may move as it walks on
        the spot: bob and sway [m]
    """

    name: tuple[str, ...]
    parent: IntArray
    offset: FloatArray
    rest: FloatArray
    low: FloatArray
    high: FloatArray
    shift_low: FloatArray
    shift_high: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        _check(self)

    def __len__(self) -> int:
        return len(self.name)

    def row(self, name: str) -> int:
        """Find the row of the joint of that name. Raises InputError where there is none."""
        if name not in self.name:
            raise InputError("joint", name, f"one of {', '.join(self.name)}")
        return self.name.index(name)

    def frames(
        self,
        rotations: Quaternions | None = None,
        shift: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    ) -> tuple[Vectors, Quaternions]:
        """Compute origin (…, j, 3) [m] and rotation (…, j, 4) of every joint in the object's frame.

        turns: (…, j, 4) rotation of every joint in its parent, at rest by default
        shift: (…, 3) added to the origins of joints that sit in the object's frame [m]
        """
        local = self.rest if rotations is None else rotations
        before = local.shape[:-2]
        poses = math.prod(before)
        shifts = np.broadcast_to(np.asarray(shift, np.float64), (*before, 3)).reshape(poses, 3)
        flat = frozen(local.reshape(poses, len(self), 4), np.float64)
        origin, turn = _frames(self.parent, self.offset, flat, frozen(shifts, np.float64))
        return origin.reshape(*before, len(self), 3), turn.reshape(local.shape)

    def limit_excess(self, rotations: Quaternions) -> Float64[np.ndarray, "..."]:
        """Compute how far each joint is beyond its limits, (…, j) [degrees], 0 within them."""
        angle = to_euler(rotations)
        # The same turn has a second set of angles, (x ± 180, ±180 − y, z ± 180).
        other = angle * np.array((1.0, -1.0, 1.0)) + 180.0
        return np.minimum(self._outside(angle), self._outside(other))

    def _outside(self, angle: np.ndarray) -> np.ndarray:
        middle = (self.low + self.high) / 2
        near = middle + (angle - middle + 180.0) % 360.0 - 180.0
        return np.maximum(0, np.maximum(self.low - near, near - self.high)).max(axis=-1)

    def random_turns(self, rng: np.random.Generator, count: int) -> Quaternions:
        """Draw random poses within limits, (count, j, 4): uniform angles, and limits themselves."""
        share = np.clip(rng.uniform(-0.25, 1.25, (count, len(self), 3)), 0, 1)
        return from_euler(self.low + share * (self.high - self.low))

    def scaled(self, factor: float) -> "Rig":
        """Return the rig with every length multiplied by ``factor``."""
        lengths = (self.offset * factor, self.shift_low * factor, self.shift_high * factor)
        offset, shift_low, shift_high = lengths
        angles = (self.rest, self.low, self.high)
        return Rig(self.name, self.parent, offset, *angles, shift_low, shift_high)


@dataclass(frozen=True, eq=False)
class RiggedSticks(StickTable):
    """Sticks of every part, each end in the frame of a joint (−1 = the object's own frame).

    start_joint, end_joint (k,): the frames that start and end are in
    """

    start_joint: IntArray
    end_joint: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in ("start_joint", "end_joint"):
            joints = getattr(self, key)
            if joints.shape != self.tint.shape or np.any(joints < -1):
                raise InputError(f"sticks.{key}", joints.shape, "a joint, or -1, for every stick")

    def posed(self, origin: Vectors, turn: Quaternions) -> StickTable:
        """Return the sticks in the object's frame, given the frames of all joints."""
        start, end = (
            to_object_frame(origin, turn, joint, point)
            for joint, point in ((self.start_joint, self.start), (self.end_joint, self.end))
        )
        return StickTable(self.first, start, end, self.start_radius, self.end_radius, self.tint)


def to_object_frame(origin: Vectors, turn: Quaternions, joint: Ints, point: Points) -> Points:
    """Transform points (k, 3) [m] from the frames of joints (k,) to the object's frame."""
    if not len(origin):  # a rig without joints
        return point
    row = np.maximum(joint, 0)
    at = origin[row] + rotate_vectors(turn[row], point)
    return np.where((joint < 0)[:, None], point, at)


@njit(cache=True)
def _frames(parent, offset, rotations, shift):  # type: ignore[no-untyped-def]
    """Compute origins (m, j, 3) and turns (m, j, 4) of m poses from turns and shifts (m, 3)."""
    m, j = rotations.shape[:2]
    origin, facing = np.empty((m, j, 3)), np.empty((m, j, 4))
    for o in range(m):
        for k in range(j):
            up, x, y, z = parent[k], offset[k, 0], offset[k, 1], offset[k, 2]
            q = rotations[o, k, 0], rotations[o, k, 1], rotations[o, k, 2], rotations[o, k, 3]
            at = shift[o, 0], shift[o, 1], shift[o, 2]
            if up >= 0:
                at = origin[o, up, 0], origin[o, up, 1], origin[o, up, 2]
                above = facing[o, up, 0], facing[o, up, 1], facing[o, up, 2], facing[o, up, 3]
                x, y, z = rotate_vector(*above, x, y, z)
                q = quaternion_product(*above, *q)
            origin[o, k, 0], origin[o, k, 1], origin[o, k, 2] = at[0] + x, at[1] + y, at[2] + z
            facing[o, k, 0], facing[o, k, 1], facing[o, k, 2], facing[o, k, 3] = q
    return origin, facing


def _check(rig: Rig) -> None:
    j = len(rig.name)
    check_columns("rig", rig, parent=(j,), offset=(j, 3), rest=(j, 4), low=(j, 3), high=(j, 3))
    check_columns("rig", rig, shift_low=(3,), shift_high=(3,))
    for row in np.flatnonzero((rig.parent >= np.arange(j)) | (rig.parent < -1)):
        rule = "a joint stands after its parent; -1 is the object's frame"
        raise InputError(f"rig.parent[{row}]", int(rig.parent[row]), rule)
    if np.any(rig.low > rig.high) or np.any(rig.shift_low > rig.shift_high):
        raise InputError("rig.low", "a limit above its upper limit", "low is at most high")
    if np.abs(np.linalg.norm(rig.rest, axis=1) - 1).max(initial=0) > 1e-9:
        raise InputError("rig.rest", "a quaternion not of length 1", "a turn is a unit quaternion")
    outside = rig.limit_excess(rig.rest)
    for row in np.flatnonzero(outside > _SLACK_DEG):
        arrived = np.round(to_euler(rig.rest[row]), 2).tolist()
        rule = f"stands between {rig.low[row].tolist()} and {rig.high[row].tolist()} degrees"
        raise InputError(f"rig.rest[{rig.name[row]}]", arrived, rule)
