"""Where points of many posed objects are: a compiled walk over their joints.

``PoseTables`` lays the rigs and motions of all prototypes of a species end to end; ``Instances``
say where each object stands and how far through its cycle it is. The walk takes pairs (object,
point), those of one object together. It marks the joints that these ride on, then poses them in one
loop, parents first: slerp between two keys, product with the parent joint, offset. Legs are bent so
that feet stand where ``foot_placement`` puts them (``leg_ik``).

Same input, same bytes: no arithmetic depends on the number of threads.
"""

import math
from typing import NamedTuple

import numpy as np

from lod.arrays import Ints, Points, frozen
from lod.errors import InputError
from lod.kernels import ONE, ZERO, map_chunks, njit
from scenes.rig.leg_ik import (
    AHEAD,
    PRINT_Z,
    SLOPE_X,
    SLOPE_Y,
    LegRows,
    LegTables,
    ankle_limits,
    bone_lengths,
    joint_limit_arcs,
    leg_rows,
    set_rotation,
    solve_foot,
)
from scenes.rig.rig import (
    Motion,
    Rig,
    Vectors,
    print_and_swing,
    quaternion_product,
    rotate_vector,
    slerp_weights,
)
from scenes.rig.rigged_prototype import RiggedPrototype

_MIN_ANGLE = 1e-9  # least angle between two keys: weights are the shares themselves there [rad]

FIRST_JOINT, JOINTS, FIRST_KEY, KEYS, FIRST_SHIFT, FIRST_LEG, LEGS, FIRST_HIP = range(8)
"""Columns of ``PoseTables.prototypes``: first rows and numbers of a prototype's own rows."""

PARENT, MOVES, KNEE_OF_HIP, ANKLE_OF_HIP, LEG_OF_HIP = range(5)  # columns of ``PoseTables.joint``
ANGLE, PER_SINE = 4, 5  # columns of ``PoseTables.keys`` after the quaternion

AT_HIP_X, AT_HIP_Y, AT_HIP_Z, FROM_PRINT_X, FROM_PRINT_Y, FROM_PRINT_Z = range(6)
"""Columns of ``PoseTables.hip``."""


class PoseTables(NamedTuple):
    """The rigs and motions of a species' prototypes end to end, as compiled kernels read them.

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
    max_joints, max_legs  most joints and legs of any prototype
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
    max_joints: int
    max_legs: int

    @staticmethod
    def of(prototypes: tuple[RiggedPrototype, ...]) -> "PoseTables":
        """Lay the prototypes end to end."""
        if not prototypes:
            raise InputError("prototypes", 0, "at least one prototype")
        rigs, motions = [p.rig for p in prototypes], [p.motion for p in prototypes]
        pairs = list(zip(rigs, motions, strict=True))
        joints = np.array([len(rig) for rig in rigs])
        keys = np.array([len(motion.rotations) for motion in motions])
        legs = np.array([len(motion.feet) for motion in motions])
        first_joint, first_shift, first_leg, first_hip = (
            np.cumsum(count) - count for count in (joints, keys + 1, legs, (keys + 1) * legs)
        )
        first_key, key_rows = _shared_keys(motions)
        rows = first_joint, joints, first_key, keys, first_shift, first_leg, legs, first_hip
        return PoseTables(
            prototypes=frozen(np.stack(rows, axis=1), np.int64),
            joint=_joined([_joint_rows(rig, motion) for rig, motion in pairs], np.int64),
            offset=_joined([rig.offset for rig in rigs]),
            keys=frozen(key_rows, np.float64),
            shift=_joined([np.vstack((m.shift, m.shift[:1])) for m in motions]),
            legs=LegTables(
                leg=_joined([leg_rows(rig, motion) for rig, motion in pairs]),
                bones=_joined([bone_lengths(rig, motion) for rig, motion in pairs]),
                arc=_joined([joint_limit_arcs(rig, motion) for rig, motion in pairs]),
                ankle=_joined([ankle_limits(rig, motion) for rig, motion in pairs]),
            ),
            sole=_joined([motion.feet.sole for motion in motions]),
            plane=_joined([motion.feet.plane for motion in motions]),
            hip=_joined([_hip_rows(rig, motion) for rig, motion in pairs]),
            max_joints=int(joints.max()),
            max_legs=int(legs.max()),
        )


class Instances(NamedTuple):
    """The objects that are to be posed, in read-only arrays, as compiled kernels take them.

    origin (n, 3) where each stands, in the frame's coordinates [m]; cos, sin (n,) of its heading
    prototype (n,) its row in the pose tables; phase (n,) of its motion, 0 to 1 [cycles]
    foot_contacts (n, legs, 6) of each foot: where its print is, PRINT_X, PRINT_Y and PRINT_Z [m];
        how far that is AHEAD of the prototype's own [m]; and the rotation that tilts the ground
        under it, SLOPE_X and SLOPE_Y of a quaternion whose z is 0
    """

    origin: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    prototype: np.ndarray
    phase: np.ndarray
    foot_contacts: np.ndarray

    def take(self, rows: np.ndarray) -> "Instances":
        """Select the objects at ``rows``."""
        return Instances(*(frozen(each[rows], each.dtype) for each in self))


def _joined(tables: list[np.ndarray], dtype: type = np.float64) -> np.ndarray:
    return frozen(np.concatenate(tables), dtype)


def _joint_rows(rig: Rig, motion: Motion) -> np.ndarray:
    rows = np.full((len(rig), 5), -1)
    rows[:, 0] = rig.parent
    rows[:, 1] = (np.abs(motion.rotations - motion.rotations[:1]) > 1e-15).any(axis=(0, 2))
    for number, (hip, knee, ankle) in enumerate(motion.feet.legs):
        rows[hip, 2:] = knee, ankle, number
    return rows


def _hip_rows(rig: Rig, motion: Motion) -> np.ndarray:
    """Place hips, and ankles from their prints, at every key and at key 0 again, (k, 6)."""
    feet, keys = motion.feet, len(motion.rotations)
    origin, _ = rig.frames(motion.rotations, motion.shift)
    own = (np.arange(keys)[:, None] / keys - feet.strike) % 1.0
    each = zip(own.ravel(), np.tile(feet.duty, keys), strict=True)
    ahead = np.array([sum(print_and_swing(o, d)) for o, d in each]).reshape(own.shape)
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
        keys, name = motion.rotations, motion.rotations.tobytes()
        if name not in first:
            # Key 0 stands again at the end, and every quaternion has the sign of the one before.
            cos = (keys[-1:] * keys[:1]).sum(axis=-1, keepdims=True)
            rotations = np.concatenate((keys, keys[:1] * np.copysign(1.0, cos)))
            after = np.concatenate((rotations[1:], rotations[-1:]))
            cos = (rotations * after).sum(axis=-1, keepdims=True)
            sine = np.linalg.norm(after - cos * rotations, axis=-1, keepdims=True)
            angle = np.maximum(np.arctan2(sine, cos), _MIN_ANGLE)
            row = np.concatenate((rotations, angle, 1.0 / np.sin(angle)), axis=-1).reshape(-1, 6)
            first[name] = count
            rows.append(row)
            count += len(row)
        starts.append(first[name])
    return np.array(starts), np.concatenate(rows)


_SHORTEST_RUN = 16384  # points for which another thread is worth its start

_UNKNOWN, _MARKED, POSED = 0, 1, 2  # how far the frame of a joint is

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
"""The rotation matrix that rotates nothing, row by row."""


class PoseBuffers(NamedTuple):
    """Scratch arrays in which one object is posed at a time.

    frame (j + 2, 7) origin and quaternion of joint frames in the scene: row 0 is the object's own
        frame, row j + 1 that of joint j; the last row is the object's bob
    state (j + 1,) int8, how far each frame is: unknown, marked or POSED
    """

    frame: np.ndarray
    state: np.ndarray


class Pose(NamedTuple):
    """Rows of the prototype of one object, and its phase, from which its joints are posed.

    keys: first row of its keys; key: rows from there to the key before its phase; share: of the way
    from that key to the next; cos, sin: of its heading
    """

    prototype: int
    first_joint: int
    joints: int
    keys: int
    key: int
    share: float
    cos: float
    sin: float


NO_POSE = Pose(0, 0, 0, 0, 0, 0.0, 0.0, 0.0)  # a pose before any object is begun


def pose_points(
    pose_tables: PoseTables,
    instances: Instances,
    rows: Ints,
    points: Ints,
    place: Vectors,
    joint: np.ndarray,
) -> Points:
    """Pose points that ride on joints, (m, 3) [m]: rows ``points`` of a table, of objects ``rows``.

    place (k, 3), joint (k,): the table (joint −1 = the object's frame). Points of one object stand
        together.
    """
    # Read-only arrays, whatever arrives: of one kind of array one kernel is compiled.
    on, at = frozen(joint, np.int64), frozen(place, np.float64)
    owners, items = frozen(rows, np.int64), frozen(points, np.int64)
    found = np.empty((len(rows), 3))

    def run(first: int, last: int) -> None:
        each = owners[first:last], items[first:last]
        _pose_points(pose_tables, instances, each, at, on, found[first:last])

    map_chunks(run, len(rows), _SHORTEST_RUN)
    return found


@njit(cache=True, nogil=True)
def _pose_points(tables, instances, each, places, joints, out):  # type: ignore[no-untyped-def]
    """Pose every point into ``out`` (m, 3); ``each`` is object (m,) and row of the table (m,)."""
    rows, items = each
    buffers = pose_buffers(tables.max_joints)
    m = 0
    while m < len(rows):
        o, first = rows[m], m
        pose = begin_pose(tables, buffers, instances, o)
        while m < len(rows) and rows[m] == o:
            mark_joint(tables, buffers, pose, joints[items[m]] + 1)
            m += 1
        pose_marked(tables, buffers, pose, instances.foot_contacts, o, ONE, pose.joints)
        _place_points(buffers.frame, items[first:m], places, joints, out[first:m])


@njit(cache=True)
def rotation_matrix(frame, row):  # type: ignore[no-untyped-def]
    """Compute the rotation matrix of a frame, row by row: it costs least for many points."""
    x, y, z, w = frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6]
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    wx, wy, wz = w * x, w * y, w * z
    top = 1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)
    middle = 2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)
    return *top, *middle, 2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)


@njit(cache=True)
def transform_point(frame, row, rotation, x, y, z):  # type: ignore[no-untyped-def]
    """Transform (x, y, z) from a frame to the scene, given the frame's rotation matrix."""
    a, b, c, d, e, f, g, h, i = rotation
    return (
        frame[row, 0] + a * x + b * y + c * z,
        frame[row, 1] + d * x + e * y + f * z,
        frame[row, 2] + g * x + h * y + i * z,
    )


@njit(cache=True)
def _place_points(frame, items, places, joints, out):  # type: ignore[no-untyped-def]
    row, rotation = ZERO, rotation_matrix(frame, ZERO)
    for m in range(len(items)):
        k = items[m]
        if joints[k] + 1 != row:
            row = joints[k] + 1
            rotation = rotation_matrix(frame, row)
        x, y, z = places[k, 0], places[k, 1], places[k, 2]
        out[m, 0], out[m, 1], out[m, 2] = transform_point(frame, row, rotation, x, y, z)


@njit(cache=True)
def pose_buffers(max_joints):  # type: ignore[no-untyped-def]
    """Make PoseBuffers for objects of up to ``max_joints`` joints."""
    return PoseBuffers(np.zeros((max_joints + 2, 7)), np.zeros(max_joints + 1, np.int8))


@njit(cache=True)
def begin_pose(tables, buffers, instances, o):  # type: ignore[no-untyped-def]
    """Begin to pose object ``o``: pose its own frame and bob, and return its Pose."""
    frame, state, cos, sin = buffers.frame, buffers.state, instances.cos[o], instances.sin[o]
    frame[0, 0], frame[0, 1] = instances.origin[o, 0], instances.origin[o, 1]
    frame[0, 2], frame[0, 3], frame[0, 4] = instances.origin[o, 2], 0.0, 0.0
    frame[0, 5] = math.copysign(math.sqrt(max(0.0, (1.0 - cos) / 2)), sin)
    frame[0, 6] = math.sqrt(max(0.0, (1.0 + cos) / 2))
    v = instances.prototype[o]
    rows, shift = tables.prototypes, tables.shift
    keys, n, first = rows[v, KEYS], rows[v, JOINTS], rows[v, FIRST_JOINT]
    state[0], state[1 : n + 1] = POSED, _UNKNOWN
    along = instances.phase[o] * keys
    k = min(int(along), keys - 1)
    share, bob, s = along - k, len(frame) - 1, rows[v, FIRST_SHIFT] + k
    for c in range(3):
        frame[bob, c] = (1 - share) * shift[s, c] + share * shift[s + 1, c]
    return Pose(v, first, n, rows[v, FIRST_KEY], k * n, share, cos, sin)


@njit(cache=True, inline="always")
def mark_joint(tables, buffers, pose, row):  # type: ignore[no-untyped-def]
    """Mark the joint in a row of the frames, and all that it rides on, to be posed.

    Returns the first row that is marked.
    """
    lowest = row
    while buffers.state[row] == _UNKNOWN:
        buffers.state[row], lowest = _MARKED, row
        row = tables.joint[pose.first_joint + row - 1, PARENT] + 1
    return lowest


@njit(cache=True)
def pose_marked(tables, buffers, pose, contacts, o, lowest, highest):  # type: ignore[no-untyped-def]
    """Pose the marked joints of object ``o``, row by row, parents first; with a hip its whole leg.

    contacts (n, legs, 6): ``Instances.foot_contacts``
    """
    joint, frame, state, first = tables.joint, buffers.frame, buffers.state, pose.first_joint
    row = lowest
    while row <= highest:
        if state[row] != _MARKED:
            row += 1
            continue
        leg = joint[first + row - 1, LEG_OF_HIP]
        bends = leg >= 0 and not _is_level(contacts, o, leg, frame[0, 2])
        # With a hip that stands on ground of its own its knee and ankle.
        k = row
        while True:
            _pose_joint(tables, frame, pose, k)
            state[k] = POSED
            if not bends or k == joint[first + row - 1, ANKLE_OF_HIP] + 1:
                break
            k = joint[first + row - 1, KNEE_OF_HIP if k == row else ANKLE_OF_HIP] + 1
        if bends:
            knee, carrier = joint[first + row - 1, KNEE_OF_HIP], joint[first + row - 1, PARENT]
            rows = LegRows(row, knee + 1, k, carrier + 1)
            at = tables.prototypes[pose.prototype, FIRST_LEG] + leg
            solve_foot(frame, rows, tables.legs, at, contacts, o, leg, pose.cos, pose.sin)
        row += 1


@njit(cache=True, inline="always")
def _pose_joint(tables, frame, pose, row):  # type: ignore[no-untyped-def]
    joint, offset, keys = tables.joint, tables.offset, tables.keys
    at, a = pose.first_joint + row - 1, pose.keys + row - 1
    if joint[at, MOVES]:
        a += pose.key
        b = a + pose.joints
        g, h = slerp_weights(pose.share, keys[a, ANGLE], keys[a, PER_SINE])
        qx, qy = g * keys[a, 0] + h * keys[b, 0], g * keys[a, 1] + h * keys[b, 1]
        qz, qw = g * keys[a, 2] + h * keys[b, 2], g * keys[a, 3] + h * keys[b, 3]
    else:
        qx, qy, qz, qw = keys[a, 0], keys[a, 1], keys[a, 2], keys[a, 3]
    up = joint[at, PARENT] + 1
    x, y, z = offset[at, 0], offset[at, 1], offset[at, 2]
    if up == 0:
        bob = len(frame) - 1
        x, y, z = x + frame[bob, 0], y + frame[bob, 1], z + frame[bob, 2]
    ux, uy, uz, uw = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    x, y, z = rotate_vector(ux, uy, uz, uw, x, y, z)
    frame[row, 0], frame[row, 1] = frame[up, 0] + x, frame[up, 1] + y
    frame[row, 2] = frame[up, 2] + z
    set_rotation(frame, row, quaternion_product(ux, uy, uz, uw, qx, qy, qz, qw))


@njit(cache=True, inline="always")
def _is_level(contacts, o, leg, z):  # type: ignore[no-untyped-def]
    stands = contacts[o, leg, PRINT_Z] == z and contacts[o, leg, AHEAD] == 0.0
    return stands and contacts[o, leg, SLOPE_X] == 0.0 and contacts[o, leg, SLOPE_Y] == 0.0
