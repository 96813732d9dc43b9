"""Posing by arrays: joints and sticks of many objects at once, each at its own phase, compiled.

A ``Cast`` lays the rigs and motions of all prototypes of a species end to end; ``Bodies`` say
where each object stands and how far through its cycle it is. The walks take pairs (object, joint)
or (object, stick), those of one object together, and evaluate every joint that is needed once an
object: slerp between two keys, product with the joint above, offset. On sloping ground the legs
are bent so that feet stand on it (``rig_plant``).

Same input, same bytes: one thread, no reordered arithmetic.
"""

import math

import numpy as np
from numba import njit

from lod.arrays import Ints, Points
from scenes.rig_cast import Bodies as Bodies
from scenes.rig_cast import Cast as Cast
from scenes.rig_plant import plant_leg, room_to_reach
from scenes.rig_turns import Turns, Vectors, slerp_weights, times, turn


def pose_joints(cast: Cast, bodies: Bodies, rows: Ints, joints: Ints) -> tuple[Points, Turns]:
    """Origin (m, 3) [m] and turn (m, 4) of joints, in the frame's coordinates.

    rows, joints (m,): objects and joints within their prototype; those of one object together,
        for speed.
    """
    return _pose_joints(cast.tables, cast.most_joints, *bodies.columns(), rows, joints)


def pose_sticks(
    cast: Cast,
    bodies: Bodies,
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
    table = (start, end, start_joint, end_joint)
    return _pose_sticks(cast.tables, cast.most_joints, *bodies.columns(), rows, sticks, table)


def pose_points(
    cast: Cast,
    bodies: Bodies,
    rows: Ints,
    points: Ints,
    place: Vectors,
    joint: np.ndarray,
) -> Points:
    """Points that ride on joints, (m, 3) [m]: row ``points`` of the table, of object ``rows``.

    place (k, 3), joint (k,): the table (joint −1 = the object's frame).
    """
    return _pose_points(
        cast.tables, cast.most_joints, *bodies.columns(), rows, points, place, joint
    )


@njit(cache=True)
def _pose_joints(t, most, origin, cos, sin, variant, phase, gradient, rows, joints):  # type: ignore[no-untyped-def]
    frame, done = scratch(most)
    places, facing = np.empty((len(rows), 3)), np.empty((len(rows), 4))
    m = 0
    while m < len(rows):
        o = rows[m]
        at = origin[o, 0], origin[o, 1], origin[o, 2], cos[o], sin[o]
        stance = stand(t, frame, done, variant[o], phase[o], at, gradient[o, 0], gradient[o, 1])
        while m < len(rows) and rows[m] == o:
            row = joints[m] + 1
            reach_joint(t, frame, done, stance, row)
            for c in range(3):
                places[m, c] = frame[row, c]
            for c in range(4):
                facing[m, c] = frame[row, 3 + c]
            m += 1
    return places, facing


@njit(cache=True)
def _pose_points(t, most, origin, cos, sin, variant, phase, gradient, rows, points, place, on):  # type: ignore[no-untyped-def]
    frame, done = scratch(most)
    out = np.empty((len(rows), 3))
    m = 0
    while m < len(rows):
        o, first = rows[m], m
        at = origin[o, 0], origin[o, 1], origin[o, 2], cos[o], sin[o]
        stance = stand(t, frame, done, variant[o], phase[o], at, gradient[o, 0], gradient[o, 1])
        while m < len(rows) and rows[m] == o:
            reach_joint(t, frame, done, stance, on[points[m]] + 1)
            m += 1
        _put(frame, points, place, on, out, first, m)
    return out


@njit(cache=True)
def _pose_sticks(t, most, origin, cos, sin, variant, phase, gradient, rows, sticks, table):  # type: ignore[no-untyped-def]
    start, end, joint0, joint1 = table
    frame, done = scratch(most)
    starts, ends = np.empty((len(rows), 3)), np.empty((len(rows), 3))
    m = 0
    while m < len(rows):
        o, first = rows[m], m
        at = origin[o, 0], origin[o, 1], origin[o, 2], cos[o], sin[o]
        stance = stand(t, frame, done, variant[o], phase[o], at, gradient[o, 0], gradient[o, 1])
        while m < len(rows) and rows[m] == o:
            reach_joint(t, frame, done, stance, joint0[sticks[m]] + 1)
            reach_joint(t, frame, done, stance, joint1[sticks[m]] + 1)
            m += 1
        _put(frame, sticks, start, joint0, starts, first, m)
        _put(frame, sticks, end, joint1, ends, first, m)
    return starts, ends


@njit(cache=True)
def matrix(frame, row):  # type: ignore[no-untyped-def]
    """Rotation matrix of a frame, row by row: for many points of a joint it costs least."""
    x, y, z, w = frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6]
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    wx, wy, wz = w * x, w * y, w * z
    top = 1 - 2 * (yy + zz), 2 * (xy - wz), 2 * (xz + wy)
    middle = 2 * (xy + wz), 1 - 2 * (xx + zz), 2 * (yz - wx)
    return *top, *middle, 2 * (xz - wy), 2 * (yz + wx), 1 - 2 * (xx + yy)


@njit(cache=True)
def at_point(frame, row, turn, x, y, z):  # type: ignore[no-untyped-def]
    """Where (x, y, z) of a frame is, given its rotation matrix."""
    a, b, c, d, e, f, g, h, i = turn
    return (
        frame[row, 0] + a * x + b * y + c * z,
        frame[row, 1] + d * x + e * y + f * z,
        frame[row, 2] + g * x + h * y + i * z,
    )


@njit(cache=True)
def _put(frame, sticks, points, joints, out, first, last):  # type: ignore[no-untyped-def]
    """Place one end of sticks first to last."""
    row, turn = 0, matrix(frame, 0)
    for m in range(first, last):
        k = sticks[m]
        if joints[k] + 1 != row:
            row = joints[k] + 1
            turn = matrix(frame, row)
        place = at_point(frame, row, turn, points[k, 0], points[k, 1], points[k, 2])
        out[m, 0], out[m, 1], out[m, 2] = place


@njit(cache=True)
def scratch(most):  # type: ignore[no-untyped-def]
    """Room to pose one object of up to ``most`` joints: frames, and which of them are done.

    Row 0 of the frames is the object's own, row j + 1 that of joint j; the last is its bob.
    """
    return np.zeros((most + 2, 7)), np.zeros(most + 1, np.bool_)


@njit(cache=True)
def stand(t, frame, done, v, p, at, gx, gy):  # type: ignore[no-untyped-def]
    """Begin an object of prototype v at phase p: its own frame and bob, and how it stands."""
    cast, joint, offset, turns, shift = t
    x, y, z, cos, sin = at
    frame[0, 0], frame[0, 1], frame[0, 2], frame[0, 3], frame[0, 4] = x, y, z, 0.0, 0.0
    frame[0, 5] = math.copysign(math.sqrt(max(0.0, (1.0 - cos) / 2)), sin)
    frame[0, 6] = math.sqrt(max(0.0, (1.0 + cos) / 2))
    keys, n, first = cast[v, 3], cast[v, 1], cast[v, 0]
    done[0], done[1 : n + 1] = True, False
    along = p * keys
    k = min(int(along), keys - 1)
    key, share, bob, s = cast[v, 2] + k * n, along - k, len(frame) - 1, cast[v, 4] + k
    for c in range(3):
        frame[bob, c] = (1 - share) * shift[s, c] + share * shift[s + 1, c]
    drop = 0.0
    if gx != 0.0 or gy != 0.0:
        drop = _drop(joint, offset, turns, frame, first, n, key, share, gx, gy)
        frame[bob, 2] += drop
    return first, n, key, share, drop, gx, gy


@njit(cache=True)
def reach_joint(t, frame, done, stance, row):  # type: ignore[no-untyped-def]
    """Pose the joint in a row of ``frame``, and all that it rides on, where that is not done."""
    joint, first = t[1], stance[0]
    while not done[row]:
        up = row
        above = joint[first + up - 1, 0] + 1
        while not done[above]:
            up = above
            above = joint[first + up - 1, 0] + 1
        _pose(t, frame, done, stance, up)


@njit(cache=True)
def _pose(t, frame, done, stance, row):  # type: ignore[no-untyped-def]
    """Pose one joint whose parent is done; with a hip on a slope, all of its leg."""
    _, joint, offset, turns, _ = t
    first, n, key, share, drop, gx, gy = stance
    _evaluate(joint, offset, turns, frame, first, n, key, share, row)
    done[row] = True
    knee, ankle = joint[first + row - 1, 2] + 1, joint[first + row - 1, 3] + 1
    if knee > 0 and (gx != 0.0 or gy != 0.0):
        _evaluate(joint, offset, turns, frame, first, n, key, share, knee)
        _evaluate(joint, offset, turns, frame, first, n, key, share, ankle)
        plant_leg(frame, row, knee, ankle, offset, first - 1, drop, gx, gy)
        done[knee] = done[ankle] = True


@njit(cache=True)
def _drop(joint, offset, turns, frame, first, n, key, share, gx, gy):  # type: ignore[no-untyped-def]
    """How far the body must sink, 0 or below, for every leg to reach the slope [m]."""
    drop = 0.0
    for row in range(1, n + 1):
        if joint[first + row - 1, 2] < 0:
            continue
        depth, up = 0, row
        while up > 0:  # the joints above a hip are few: count them, then come down
            depth, up = depth + 1, joint[first + up - 1, 0] + 1
        for below in range(depth, 0, -1):
            up = row
            for _ in range(below - 1):
                up = joint[first + up - 1, 0] + 1
            _evaluate(joint, offset, turns, frame, first, n, key, share, up)
        knee, ankle = joint[first + row - 1, 2] + 1, joint[first + row - 1, 3] + 1
        _evaluate(joint, offset, turns, frame, first, n, key, share, knee)
        _evaluate(joint, offset, turns, frame, first, n, key, share, ankle)
        room = room_to_reach(frame, row, ankle, offset, first + knee - 1, first + ankle - 1, gx, gy)
        drop = min(drop, room)
    return drop


@njit(cache=True)
def _evaluate(joint, offset, turns, frame, first, n, key, share, row):  # type: ignore[no-untyped-def]
    """Frame of a joint from that of its parent, which is done: slerp, product, offset."""
    at, a = first + row - 1, key + row - 1
    qx, qy, qz, qw = turns[a, 0], turns[a, 1], turns[a, 2], turns[a, 3]
    if joint[at, 1]:
        b = a + n
        u, v = slerp_weights(share, turns[a, 4], turns[a, 5])
        qx, qy = u * qx + v * turns[b, 0], u * qy + v * turns[b, 1]
        qz, qw = u * qz + v * turns[b, 2], u * qw + v * turns[b, 3]
    up = joint[at, 0] + 1
    x, y, z = offset[at, 0], offset[at, 1], offset[at, 2]
    if up == 0:
        bob = len(frame) - 1
        x, y, z = x + frame[bob, 0], y + frame[bob, 1], z + frame[bob, 2]
    ux, uy, uz, uw = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    x, y, z = turn(ux, uy, uz, uw, x, y, z)
    frame[row, 0], frame[row, 1] = frame[up, 0] + x, frame[up, 1] + y
    frame[row, 2] = frame[up, 2] + z
    qx, qy, qz, qw = times(ux, uy, uz, uw, qx, qy, qz, qw)
    frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6] = qx, qy, qz, qw
