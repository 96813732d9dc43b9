"""A leg that puts its ankle where it must be, as near as the limits of hip and knee let it.

As ``gait.two_links`` makes a gait's own poses: bones hang straight down at angles 0, the knee turns
about y by the law of cosines, and the hip about y into the direction of the ankle, and aside about
x (about z for legs that stick out); its third angle stays as posed. Every angle is kept within its
joint's limits as it is found, and what follows makes the best of it. Angles are cosines and sines
throughout: no inverse function is called.
"""

import math

import numpy as np
from numba import njit

from scenes.rig.keyframes import Motion
from scenes.rig.rig import Rig
from scenes.rig.rotations import quaternion_product, rotate_vector, to_euler

HIP_X, HIP_Y, HIP_Z, KNEE = range(4)
"""Rows of a leg's arcs: what its angles stay within."""


def bone_lengths(rig: Rig, motion: Motion) -> np.ndarray:
    """Of each leg: both bones [m], its bend, whether it sticks out, cosine and sine of the hip's
    angle that stays as posed, (l, 6).
    """
    feet = motion.feet
    length = np.linalg.norm(rig.offset[feet.legs[:, 1:]], axis=-1)
    hips = zip(feet.legs[:, 0].tolist(), feet.sticks_out.tolist(), strict=True)
    angle = [_posed(rig, motion, hip, sticks_out) for hip, sticks_out in hips]
    stays = np.radians(angle)
    columns = (*length.T, feet.bend, feet.sticks_out, np.cos(stays), np.sin(stays))
    return np.stack(columns, axis=1).astype(np.float64)


def joint_limit_arcs(rig: Rig, motion: Motion) -> np.ndarray:
    """What the angles of HIP_X … KNEE stay within: cosine and sine of the middle, and of how far
    to either side, (l, 4, 4).
    """
    legs = motion.feet.legs
    joints, axes = legs[:, (0, 0, 0, 1)], np.array((0, 1, 2, 1))
    low, high = np.radians(rig.low[joints, axes]), np.radians(rig.high[joints, axes])
    middle, half = (low + high) / 2, np.minimum((high - low) / 2, np.pi)
    return np.stack((np.cos(middle), np.sin(middle), np.cos(half), np.sin(half)), axis=-1)


def _posed(rig: Rig, motion: Motion, hip: int, sticks_out: bool) -> float:
    """The hip's angle about z, or x where the leg sticks out, as its first key poses it [degrees].

    The same turn has a second set of angles: the one within the joint's limits is meant.
    """
    angle = to_euler(motion.rotations[0, hip])
    other = angle * np.array((1.0, -1.0, 1.0)) + 180.0
    middle = (rig.low[hip] + rig.high[hip]) / 2
    sets = [middle + (each - middle + 180.0) % 360.0 - 180.0 for each in (angle, other)]
    beyond = [np.maximum(rig.low[hip] - s, s - rig.high[hip]).max() for s in sets]
    return float(sets[int(np.argmin(beyond))][0 if sticks_out else 2])


@njit(cache=True)
def two_bone_ik(frame, rows, bones, arc, leg, longest, x, y, z):  # type: ignore[no-untyped-def]
    """Turn hip and knee for the ankle to be (x, y, z) from the hip, and place what they carry.

    rows: of ``frame``: hip, knee, ankle, and what the hip rides on; bones, arc: as above, of which
        row ``leg``; longest: how far the leg stretches [m]
    """
    hip, knee, ankle, up = rows
    upper, lower, sticks_out = bones[leg, 0], bones[leg, 1], bones[leg, 3] > 0
    distance2 = min(x * x + y * y + z * z, longest * longest)
    cosine = (distance2 - upper * upper - lower * lower) / (2 * upper * lower)
    cosine = min(1.0, max(-1.0, cosine))
    ck, sk = clamp_to_arc(cosine, bones[leg, 2] * math.sqrt(1.0 - cosine * cosine), arc, leg, KNEE)
    along, down = -lower * sk, -(upper + lower * ck)
    # Where the ankle should be, in the frame that the hip turns in.
    ux, uy, uz, uw = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    x, y, z = rotate_vector(-ux, -uy, -uz, uw, x, y, z)
    if sticks_out:
        cx, sx = bones[leg, 4], bones[leg, 5]
        ahead = math.sqrt(x * x + y * y)
        cz, sz = _direction(x, y)
        cz, sz = clamp_to_arc(cz, sz, arc, leg, HIP_Z)
        low = down
    else:
        cz, sz = bones[leg, 4], bones[leg, 5]
        ahead, sx = x * cz + y * sz, min(1.0, max(-1.0, (x * sz - y * cz) / down))
        cx, sx = clamp_to_arc(math.sqrt(1.0 - sx * sx), sx, arc, leg, HIP_X)
        low = down * cx
    cy, sy = _direction(along * ahead + low * z, low * ahead - along * z)
    cy, sy = clamp_to_arc(cy, sy, arc, leg, HIP_Y)
    hx, hy, hz, hw = quaternion_product(ux, uy, uz, uw, *_turned(cx, sx, cy, sy, cz, sz))
    set_rotation(frame, hip, (hx, hy, hz, hw))
    set_child_origin(frame, knee, hip, upper)
    sk, ck = half_angle(ck, sk)
    set_rotation(frame, knee, quaternion_product(hx, hy, hz, hw, 0.0, sk, 0.0, ck))
    set_child_origin(frame, ankle, knee, lower)


@njit(cache=True, inline="always")
def _turned(cx, sx, cy, sy, cz, sz):  # type: ignore[no-untyped-def]
    """Quaternion of Rz·Ry·Rx from cosines and sines of its angles."""
    sx, cx = half_angle(cx, sx)
    sy, cy = half_angle(cy, sy)
    sz, cz = half_angle(cz, sz)
    return (
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    )


@njit(cache=True, inline="always")
def clamp_to_arc(c, s, arc, leg, which):  # type: ignore[no-untyped-def]
    """Cosine and sine of an angle, or of the limit that is nearest."""
    mc, ms, hc, hs = arc[leg, which, 0], arc[leg, which, 1], arc[leg, which, 2], arc[leg, which, 3]
    if c * mc + s * ms >= hc:
        return c, s
    if s * mc < c * ms:
        hs = -hs
    return mc * hc - ms * hs, ms * hc + mc * hs


@njit(cache=True, inline="always")
def half_angle(c, s):  # type: ignore[no-untyped-def]
    """Sine and cosine of half an angle within ±180°."""
    return math.copysign(math.sqrt(max(0.0, (1.0 - c) / 2)), s), math.sqrt(max(0.0, (1.0 + c) / 2))


@njit(cache=True, inline="always")
def set_rotation(frame, row, q):  # type: ignore[no-untyped-def]
    """Turn a frame."""
    frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6] = q


@njit(cache=True, inline="always")
def _direction(x, y):  # type: ignore[no-untyped-def]
    """Cosine and sine of the angle of (x, y)."""
    n = math.sqrt(x * x + y * y)
    return (x / n, y / n) if n > 0.0 else (1.0, 0.0)


@njit(cache=True, inline="always")
def set_child_origin(frame, row, up, length):  # type: ignore[no-untyped-def]
    """Place what hangs straight down from a frame."""
    x, y, z, w = frame[up, 3], frame[up, 4], frame[up, 5], frame[up, 6]
    frame[row, 0] = frame[up, 0] - 2 * length * (x * z + w * y)
    frame[row, 1] = frame[up, 1] - 2 * length * (y * z - w * x)
    frame[row, 2] = frame[up, 2] - length * (1.0 - 2.0 * (x * x + y * y))
