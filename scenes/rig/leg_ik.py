"""How a leg posed for level ground is bent so that its foot stands on its own print.

``foot_placement`` gives for each foot where its print is, how far that is ahead of the prototype's
own (for strides of its own), and how the ground under it slopes. The foot moves with its print and
turns with the slope about it, as one stiff piece with the path that it rolls along: it rolls over
its heel and ball as on the level, and a foot that stands does not slide. Hip and knee follow by
two-bone inverse kinematics, as ``gait.hip_and_knee_angles`` makes a gait's own poses: bones hang
straight down at angles 0, the knee turns about y by the law of cosines, and the hip about y into
the direction of the ankle, and aside about x (about z for legs that stick out); its third angle
stays as posed.

No joint goes further than its limits: every angle is clamped as it is found, and what follows makes
the best of it. At its own limits an ankle gives: a foot that lands heel first on a steep rise lands
with its toes up by less. What is high above the ground (hocks, fetlocks) leans with slopes along
the way and not with those across it, and its limits are wide enough for it. Angles are cosines and
sines throughout: no inverse function is called.
"""

import math
from typing import NamedTuple

import numpy as np

from lod.kernels import njit
from scenes.rig.rig import Motion, Rig, quaternion_product, rotate_vector, to_euler

STRAIGHTEST = 0.9985
"""How far a leg stretches at most, as a share of its length, where its motion stretches it less."""

STRIKE, DUTY, HOME_X, HOME_Y, STRIDE, REACH, STEEPEST, MAX_RISE, ACROSS = range(9)
"""Columns of ``LegTables.leg``."""

PRINT_X, PRINT_Y, PRINT_Z, AHEAD, SLOPE_X, SLOPE_Y = range(6)
"""Columns of ``Instances.foot_contacts``."""

UPPER, LOWER, BEND, STICKS_OUT, FIXED_COS, FIXED_SIN = range(6)  # columns of ``LegTables.bones``
HIP_X, HIP_Y, HIP_Z, KNEE = range(4)  # rows of a leg's arcs: the angles that stay within them


class LegTables(NamedTuple):
    """Tables from which legs are bent, (l, …) of all legs of all prototypes.

    leg   (l, 9) phase at which the foot lands (STRIKE), share of the cycle that it stands (DUTY),
        where its print is in mid-stance (HOME_X, HOME_Y) [m], STRIDE [m], how far it stretches
        (REACH) [m], STEEPEST slope that the sole follows, farthest that its print is up or down
        (MAX_RISE) [m], and what share of the slope ACROSS its way the foot follows
    bones (l, 6) lengths (UPPER, LOWER) [m], BEND, whether it STICKS_OUT, cosine and sine of the
        hip's angle that stays as posed (FIXED_COS, FIXED_SIN)
    arc   (l, 4, 4) of HIP_X … KNEE: cosine and sine of the middle, and of how far to either side
    ankle (l, 6) limits: least tan x, sin y, tan z, then greatest
    """

    leg: np.ndarray
    bones: np.ndarray
    arc: np.ndarray
    ankle: np.ndarray


class LegRows(NamedTuple):
    """Rows of the joint frames of one leg; ``carrier`` is what the hip rides on."""

    hip: int
    knee: int
    ankle: int
    carrier: int


def leg_rows(rig: Rig, motion: Motion) -> np.ndarray:
    """Compute the rows of ``LegTables.leg``, (l, 9)."""
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


def ankle_limits(rig: Rig, motion: Motion) -> np.ndarray:
    """Compute the rows of ``LegTables.ankle``, (l, 6)."""
    ankles, functions = motion.feet.legs[:, 2], (np.tan, np.sin, np.tan)
    low, high = (np.radians(np.clip(limit[ankles], -90, 90)) for limit in (rig.low, rig.high))
    return np.stack(
        [f(side[:, k]) for side in (low, high) for k, f in enumerate(functions)], axis=1
    )


def bone_lengths(rig: Rig, motion: Motion) -> np.ndarray:
    """Compute the rows of ``LegTables.bones``, (l, 6)."""
    feet = motion.feet
    length = np.linalg.norm(rig.offset[feet.legs[:, 1:]], axis=-1)
    angle = []  # of the hip about z, or x where the leg sticks out, in its first key
    for hip, sticks_out in zip(feet.legs[:, 0].tolist(), feet.sticks_out.tolist(), strict=True):
        # A rotation has two sets of Euler angles: the one within the joint's limits counts.
        one = to_euler(motion.rotations[0, hip])
        other = one * np.array((1.0, -1.0, 1.0)) + 180.0
        middle = (rig.low[hip] + rig.high[hip]) / 2
        sets = [middle + (each - middle + 180.0) % 360.0 - 180.0 for each in (one, other)]
        excess = [np.maximum(rig.low[hip] - s, s - rig.high[hip]).max() for s in sets]
        angle.append(float(sets[int(np.argmin(excess))][0 if sticks_out else 2]))
    fixed = np.radians(angle)
    columns = (*length.T, feet.bend, feet.sticks_out, np.cos(fixed), np.sin(fixed))
    return np.stack(columns, axis=1).astype(np.float64)


def joint_limit_arcs(rig: Rig, motion: Motion) -> np.ndarray:
    """Compute the rows of ``LegTables.arc``, (l, 4, 4)."""
    legs = motion.feet.legs
    joints, axes = legs[:, (0, 0, 0, 1)], np.array((0, 1, 2, 1))
    low, high = np.radians(rig.low[joints, axes]), np.radians(rig.high[joints, axes])
    middle, half = (low + high) / 2, np.minimum((high - low) / 2, np.pi)
    return np.stack((np.cos(middle), np.sin(middle), np.cos(half), np.sin(half)), axis=-1)


@njit(cache=True)
def solve_foot(frame, rows, legs, leg, contacts, o, k, cos, sin):  # type: ignore[no-untyped-def]
    """Bend the leg in ``rows`` of ``frame`` (x, y, z and quaternion) to its contact, in place.

    rows: LegRows; legs: LegTables; leg: the leg's row in them
    contacts: ``Instances.foot_contacts``, of which the k-th of object o is the leg's
    cos, sin: of the object's heading. Row 0 of ``frame`` stands on level ground.
    """
    hip, knee, ankle = rows.hip, rows.knee, rows.ankle
    px, py, pz = contacts[o, k, PRINT_X], contacts[o, k, PRINT_Y], contacts[o, k, PRINT_Z]
    ahead, ax, ay = contacts[o, k, AHEAD], contacts[o, k, SLOPE_X], contacts[o, k, SLOPE_Y]
    slope = ax, ay, 0.0, math.sqrt(1.0 - ax * ax - ay * ay)
    # The ankle from the prototype's own print, turned with the ground, put on the object's.
    ex = frame[ankle, 0] - px + ahead * cos
    ey = frame[ankle, 1] - py + ahead * sin
    ez = frame[ankle, 2] - frame[0, 2]
    px, py, pz = px - frame[hip, 0], py - frame[hip, 1], pz - frame[hip, 2]
    foot = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    x, y, z = rotate_vector(*slope, ex, ey, ez)
    two_bone_ik(frame, rows, legs, leg, x + px, y + py, z + pz)
    set_rotation(frame, ankle, quaternion_product(*slope, *foot))
    _clamp_ankle(frame, knee, ankle, legs.ankle, leg)


@njit(cache=True)
def _clamp_ankle(frame, knee, ankle, limits, leg):  # type: ignore[no-untyped-def]
    """Clamp the ankle's rotation in the knee's frame to its limits, angle by angle of Rz·Ry·Rx.

    limits: ``LegTables.ankle``, of angles of 90° at most.
    """
    ux, uy, uz, uw = frame[knee, 3], frame[knee, 4], frame[knee, 5], frame[knee, 6]
    f = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    x, y, z, w = quaternion_product(-ux, -uy, -uz, uw, *f)
    a, across = 2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)
    c, along = 2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)
    b = 2.0 * (w * y - z * x)
    if across <= 0.0 and along <= 0.0:
        b = math.copysign(2.0, b)  # folded further than 90°, which is beyond any limit here
    a, c = _tangent(a, across, along), _tangent(c, along, across)
    p = min(max(a, limits[leg, 0]), limits[leg, 3])
    q = min(max(b, limits[leg, 1]), limits[leg, 4])
    r = min(max(c, limits[leg, 2]), limits[leg, 5])
    if p == a and q == b and r == c:
        return
    a, c = 1.0 / math.sqrt(1.0 + p * p), 1.0 / math.sqrt(1.0 + r * r)
    sa, ca = _half_angle(a, p * a)
    sb, cb = _half_angle(math.sqrt(1.0 - q * q), q)
    sc, cc = _half_angle(c, r * c)
    clamped = quaternion_product(0.0, 0.0, sc, cc, 0.0, sb, 0.0, cb)
    clamped = quaternion_product(*clamped, sa, 0.0, 0.0, ca)
    set_rotation(frame, ankle, quaternion_product(ux, uy, uz, uw, *clamped))


@njit(cache=True, inline="always")
def _tangent(sine, cosine, other):  # type: ignore[no-untyped-def]
    """Compute the tangent of an angle about x or z, infinite beyond 90°.

    Where both angles are beyond 90°, the rotation is one about y and both are taken the other way.
    """
    if cosine > 0.0 or (cosine < 0.0 and other <= 0.0):
        return sine / cosine
    return math.copysign(math.inf, sine)


@njit(cache=True)
def two_bone_ik(frame, rows, legs, leg, x, y, z):  # type: ignore[no-untyped-def]
    """Rotate hip and knee for the ankle to be (x, y, z) from the hip, and place what they carry.

    rows: LegRows of ``frame``; legs: LegTables; leg: the leg's row in them
    """
    hip, knee, ankle, up = rows.hip, rows.knee, rows.ankle, rows.carrier
    bones, arc, longest = legs.bones, legs.arc, legs.leg[leg, REACH]
    upper, lower, sticks_out = bones[leg, UPPER], bones[leg, LOWER], bones[leg, STICKS_OUT] > 0
    distance2 = min(x * x + y * y + z * z, longest * longest)
    cosine = (distance2 - upper * upper - lower * lower) / (2 * upper * lower)
    cosine = min(1.0, max(-1.0, cosine))
    ck, sk = _clamp_to_arc(
        cosine, bones[leg, BEND] * math.sqrt(1.0 - cosine * cosine), arc, leg, KNEE
    )
    along, down = -lower * sk, -(upper + lower * ck)
    # Where the ankle should be, in the frame that the hip turns in.
    ux, uy, uz, uw = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    x, y, z = rotate_vector(-ux, -uy, -uz, uw, x, y, z)
    if sticks_out:
        cx, sx = bones[leg, FIXED_COS], bones[leg, FIXED_SIN]
        ahead = math.sqrt(x * x + y * y)
        cz, sz = _direction(x, y)
        cz, sz = _clamp_to_arc(cz, sz, arc, leg, HIP_Z)
        low = down
    else:
        cz, sz = bones[leg, FIXED_COS], bones[leg, FIXED_SIN]
        ahead, sx = x * cz + y * sz, min(1.0, max(-1.0, (x * sz - y * cz) / down))
        cx, sx = _clamp_to_arc(math.sqrt(1.0 - sx * sx), sx, arc, leg, HIP_X)
        low = down * cx
    cy, sy = _direction(along * ahead + low * z, low * ahead - along * z)
    cy, sy = _clamp_to_arc(cy, sy, arc, leg, HIP_Y)
    hx, hy, hz, hw = quaternion_product(ux, uy, uz, uw, *_from_half_angles(cx, sx, cy, sy, cz, sz))
    set_rotation(frame, hip, (hx, hy, hz, hw))
    _set_child_origin(frame, knee, hip, upper)
    sk, ck = _half_angle(ck, sk)
    set_rotation(frame, knee, quaternion_product(hx, hy, hz, hw, 0.0, sk, 0.0, ck))
    _set_child_origin(frame, ankle, knee, lower)


@njit(cache=True, inline="always")
def _from_half_angles(cx, sx, cy, sy, cz, sz):  # type: ignore[no-untyped-def]
    sx, cx = _half_angle(cx, sx)
    sy, cy = _half_angle(cy, sy)
    sz, cz = _half_angle(cz, sz)
    return (
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    )


@njit(cache=True, inline="always")
def _clamp_to_arc(c, s, arc, leg, which):  # type: ignore[no-untyped-def]
    """Give the cosine and sine of an angle, or of the nearest end of its arc."""
    mc, ms, hc, hs = arc[leg, which, 0], arc[leg, which, 1], arc[leg, which, 2], arc[leg, which, 3]
    if c * mc + s * ms >= hc:
        return c, s
    if s * mc < c * ms:
        hs = -hs
    return mc * hc - ms * hs, ms * hc + mc * hs


@njit(cache=True, inline="always")
def _half_angle(c, s):  # type: ignore[no-untyped-def]
    return math.copysign(math.sqrt(max(0.0, (1.0 - c) / 2)), s), math.sqrt(max(0.0, (1.0 + c) / 2))


@njit(cache=True, inline="always")
def set_rotation(frame, row, q):  # type: ignore[no-untyped-def]
    """Set the quaternion of a frame."""
    frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6] = q


@njit(cache=True, inline="always")
def _direction(x, y):  # type: ignore[no-untyped-def]
    n = math.sqrt(x * x + y * y)
    return (x / n, y / n) if n > 0.0 else (1.0, 0.0)


@njit(cache=True, inline="always")
def _set_child_origin(frame, row, up, length):  # type: ignore[no-untyped-def]
    """Set the origin of a frame that hangs ``length`` m straight down from the frame ``up``."""
    x, y, z, w = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    frame[row, 0] = frame[up, 0] - 2 * length * (x * z + w * y)
    frame[row, 1] = frame[up, 1] - 2 * length * (y * z - w * x)
    frame[row, 2] = frame[up, 2] - length * (1.0 - 2.0 * (x * x + y * y))
