"""Where points and sticks of many posed objects are: a compiled walk over their joints.

``PoseTables`` lays the rigs and motions of all prototypes of a species end to end; ``Instances``
say where each object stands and how far through its cycle it is. The walk takes pairs (object,
point) or (object, stick), those of one object together. It marks the joints that these ride on,
then poses them in one loop, parents first: slerp between two keys, product with the parent joint,
offset. Legs are bent so that feet stand where ``foot_placement`` puts them (``leg_ik``). What is
called once a joint receives no arrays that it could do without: passing one costs as much as a
rotation.

Same input, same bytes: no arithmetic depends on the number of threads.
"""

import math

import numpy as np
from numba import njit

from lod.arrays import Ints, Points
from lod.threads import map_chunks
from scenes.rig.leg_ik import set_rotation, solve_foot
from scenes.rig.pose_tables import Instances, PoseTables
from scenes.rig.rotations import Vectors, quaternion_product, rotate_vector, slerp_weights


def pose_sticks(
    pose_tables: PoseTables,
    instances: Instances,
    rows: Ints,
    sticks: Ints,
    start: Vectors,
    end: Vectors,
    start_joint: np.ndarray,
    end_joint: np.ndarray,
) -> tuple[Points, Points]:
    """Both ends of sticks, (m, 3) each [m]: row ``sticks`` of the table, of object ``rows``,
    (m,) each.

    start, end (k, 3), start_joint, end_joint (k,): the table of rigged sticks (joint −1 = the
        object's frame).
    """
    ends = ((start, start_joint), (end, end_joint))
    both = np.empty((2, len(rows), 3))
    _pose_ends(
        pose_tables.tables, pose_tables.max_joints, *instances.columns(), rows, sticks, ends, both
    )
    return both[0], both[1]


def pose_points(
    pose_tables: PoseTables,
    instances: Instances,
    rows: Ints,
    points: Ints,
    place: Vectors,
    joint: np.ndarray,
) -> Points:
    """Points that ride on joints, (m, 3) [m]: row ``points`` of the table, of object ``rows``.

    place (k, 3), joint (k,): the table (joint −1 = the object's frame).
    """
    columns, ends, found = instances.columns(), ((place, joint),), np.empty((1, len(rows), 3))

    def run(first: int, last: int) -> None:
        of, out = (rows[first:last], points[first:last]), found[:, first:last]
        _pose_ends(pose_tables.tables, pose_tables.max_joints, *columns, *of, ends, out)

    map_chunks(run, len(rows), _SHORTEST_RUN)
    return found[0]


@njit(cache=True, nogil=True)
def _pose_ends(t, most, origin, cos, sin, prototype, phase, feet, rows, items, ends, out):  # type: ignore[no-untyped-def]
    """Every end of the items into ``out`` (ends, m, 3). ``ends``: places and joints of items."""
    frame, state = pose_buffers(most)
    m = 0
    while m < len(rows):
        o, first = rows[m], m
        at = origin[o, 0], origin[o, 1], origin[o, 2], cos[o], sin[o]
        stance = begin_pose(t, frame, state, prototype[o], phase[o], at)
        while m < len(rows) and rows[m] == o:
            for _, on in ends:
                mark_joint(t.joint, stance, state, on[items[m]] + 1)
            m += 1
        pose_marked(t, frame, state, stance, feet, o, 1, stance[2])
        e = 0
        for place, on in ends:
            _place_ends(frame, items, place, on, out[e], first, m)
            e += 1


_SHORTEST_RUN = 16384
"""Points for which another thread is worth its start."""

_UNKNOWN, _WANTED, POSED = 0, 1, 2
"""How far the frame of a joint is."""

IDENTITY = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
"""The matrix that turns nothing."""

NO_POSE = (0, 0, 0, 0, 0, 0.0, 0.0, 0.0)
"""What ``begin_pose`` gives, before anything stands."""


@njit(cache=True)
def rotation_matrix(frame, row):  # type: ignore[no-untyped-def]
    """Rotation matrix of a frame, row by row: for many points of a joint it costs least."""
    x, y, z, w = frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6]
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    wx, wy, wz = w * x, w * y, w * z
    top = 1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)
    middle = 2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)
    return *top, *middle, 2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)


@njit(cache=True)
def transform_point(frame, row, turn, x, y, z):  # type: ignore[no-untyped-def]
    """Where (x, y, z) of a frame is, given its rotation matrix."""
    a, b, c, d, e, f, g, h, i = turn
    return (
        frame[row, 0] + a * x + b * y + c * z,
        frame[row, 1] + d * x + e * y + f * z,
        frame[row, 2] + g * x + h * y + i * z,
    )


@njit(cache=True)
def _place_ends(frame, sticks, points, joints, out, first, last):  # type: ignore[no-untyped-def]
    """Place one end of sticks first to last."""
    row, turn = 0, rotation_matrix(frame, 0)
    for m in range(first, last):
        k = sticks[m]
        if joints[k] + 1 != row:
            row = joints[k] + 1
            turn = rotation_matrix(frame, row)
        place = transform_point(frame, row, turn, points[k, 0], points[k, 1], points[k, 2])
        out[m, 0], out[m, 1], out[m, 2] = place


@njit(cache=True)
def pose_buffers(most):  # type: ignore[no-untyped-def]
    """Room to pose one object of up to ``most`` joints: frames, and how far each of them is.

    Row 0 of the frames is the object's own, row j + 1 that of joint j; the last is its bob.
    """
    return np.zeros((most + 2, 7)), np.zeros(most + 1, np.int8)


@njit(cache=True)
def begin_pose(t, frame, state, v, p, at):  # type: ignore[no-untyped-def]
    """Begin an object of prototype v at phase p: its own frame and bob."""
    x, y, z, cos, sin = at
    frame[0, 0], frame[0, 1], frame[0, 2], frame[0, 3], frame[0, 4] = x, y, z, 0.0, 0.0
    frame[0, 5] = math.copysign(math.sqrt(max(0.0, (1.0 - cos) / 2)), sin)
    frame[0, 6] = math.sqrt(max(0.0, (1.0 + cos) / 2))
    keys, n, first = t.pose_tables[v, 3], t.pose_tables[v, 1], t.pose_tables[v, 0]
    state[0], state[1 : n + 1] = POSED, _UNKNOWN
    along = p * keys
    k = min(int(along), keys - 1)
    share, bob, s = along - k, len(frame) - 1, t.pose_tables[v, 4] + k
    for c in range(3):
        frame[bob, c] = (1 - share) * t.shift[s, c] + share * t.shift[s + 1, c]
    return v, first, n, t.pose_tables[v, 2], k * n, share, cos, sin


@njit(cache=True, inline="always")
def mark_joint(joint, stance, state, row):  # type: ignore[no-untyped-def]
    """Mark the joint in a row of ``frame``, and all that it rides on, as wanted; gives the first
    row that is.
    """
    lowest = row
    while state[row] == _UNKNOWN:
        state[row], lowest = _WANTED, row
        row = joint[stance[1] + row - 1, 0] + 1
    return lowest


@njit(cache=True)
def pose_marked(t, frame, state, stance, feet, o, lowest, highest):  # type: ignore[no-untyped-def]
    """Pose the joints of object ``o`` that are wanted, from row to row, parents first; with a hip,
    all of its leg.

    feet (n, legs, 6): as in ``Instances``.
    """
    joint, offset, rotations = t.joint, t.offset, t.rotations
    v, first, _, _, _, _, cos, sin = stance
    row = lowest
    while row <= highest:
        if state[row] != _WANTED:
            row += 1
            continue
        leg = joint[first + row - 1, 4]
        plants = leg >= 0 and not _is_level(feet, o, leg, frame[0, 2])
        # With a hip that stands on ground of its own its knee and ankle.
        k = row
        while True:
            _pose_joint(joint, offset, rotations, frame, stance, k)
            state[k] = POSED
            if not plants or k == joint[first + row - 1, 3] + 1:
                break
            k = joint[first + row - 1, 2 if k == row else 3] + 1
        if plants:
            rows = row, joint[first + row - 1, 2] + 1, k, joint[first + row - 1, 0] + 1
            legs = t.leg, t.bones, t.arc, t.ankle
            solve_foot(frame, rows, legs, t.pose_tables[v, 5] + leg, feet, o, leg, cos, sin)
        row += 1


@njit(cache=True, inline="always")
def _pose_joint(joint, offset, rotations, frame, stance, row):  # type: ignore[no-untyped-def]
    """The frame of a joint from that of its parent, which is done: slerp, product, offset."""
    _, first, joints, keys, key, share, _, _ = stance
    at, a = first + row - 1, keys + row - 1
    if joint[at, 1]:
        a += key
        b = a + joints
        g, h = slerp_weights(share, rotations[a, 4], rotations[a, 5])
        qx, qy = (
            g * rotations[a, 0] + h * rotations[b, 0],
            g * rotations[a, 1] + h * rotations[b, 1],
        )
        qz, qw = (
            g * rotations[a, 2] + h * rotations[b, 2],
            g * rotations[a, 3] + h * rotations[b, 3],
        )
    else:
        qx, qy, qz, qw = rotations[a, 0], rotations[a, 1], rotations[a, 2], rotations[a, 3]
    up = joint[at, 0] + 1
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
def _is_level(feet, o, leg, z):  # type: ignore[no-untyped-def]
    """Whether a foot stands as its prototype's does: on level ground, at the same stride."""
    stands = feet[o, leg, 2] == z and feet[o, leg, 3] == 0.0
    return stands and feet[o, leg, 4] == 0.0 and feet[o, leg, 5] == 0.0
