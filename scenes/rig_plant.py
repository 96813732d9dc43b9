"""Feet on sloping ground: a leg posed for level ground is bent so that its foot stands on a slope.

The foot is turned with the slope about the point of the ground below its ankle, so that it rolls
over its heel and ball as on the level. The knee follows by the law of cosines, and the hip by the
shortest turn that points the leg at its foot, so that bones keep their lengths. Where a leg would
be too short for its foot, the whole body sinks: on a slope of 10 % by a few centimetres.

The ground is taken as even over a stride: what it curves within one is how far a foot is off.
"""

import math

from numba import njit

from scenes.rig_turns import times, turn

STRAIGHTEST = 0.9985
"""How far a leg stretches at most, as a share of its length."""


@njit(cache=True)
def _on_slope(frame, hip, ankle, drop, gx, gy):  # type: ignore[no-untyped-def]
    """From the hip to where the ankle goes: as far off the slope as off the level, square to it
    [m].

    ``drop`` (0 or below): how far the whole body has been moved up already.
    """
    clear = frame[ankle, 2] - frame[0, 2] - drop
    rise = gx * (frame[ankle, 0] - frame[0, 0]) + gy * (frame[ankle, 1] - frame[0, 1])
    off = clear / math.sqrt(1.0 + gx * gx + gy * gy)
    x = frame[ankle, 0] - gx * off - frame[hip, 0]
    y = frame[ankle, 1] - gy * off - frame[hip, 1]
    return x, y, frame[0, 2] + rise + off - frame[hip, 2]


@njit(cache=True)
def room_to_reach(frame, hip, ankle, offset, thigh, shank, gx, gy):  # type: ignore[no-untyped-def]
    """How far the body may rise for this leg to reach its foot on the slope; below 0, must sink
    [m].

    hip, ankle: rows of ``frame`` (x, y, z and quaternion); thigh, shank: rows of ``offset``.
    """
    length = STRAIGHTEST * (_length(offset, thigh) + _length(offset, shank))
    x, y, z = _on_slope(frame, hip, ankle, 0.0, gx, gy)
    return z + math.sqrt(max(0.0, length * length - x * x - y * y))


@njit(cache=True)
def plant_leg(frame, hip, knee, ankle, offset, first, drop, gx, gy):  # type: ignore[no-untyped-def]
    """Bend the leg in rows hip, knee, ankle of ``frame``, changing them; its bones are in
    ``offset``.

    first: what to add to a row of ``frame`` for the joint's row of ``offset``; drop as in
    ``_on_slope``.
    """
    x, y, z = _on_slope(frame, hip, ankle, drop, gx, gy)
    thigh, shank = first + knee, first + ankle
    upper, lower = _length(offset, thigh), _length(offset, shank)
    longest, shortest = STRAIGHTEST * (upper + lower), abs(upper - lower) * 1.001
    distance = min(max(math.sqrt(x * x + y * y + z * z), shortest), longest)
    cosine = (distance * distance - upper * upper - lower * lower) / (2 * upper * lower)
    half = offset[first + hip, 3] * math.acos(min(1.0, max(-1.0, cosine))) / 2
    hx, hy, hz, hw = frame[hip, 3], frame[hip, 4], frame[hip, 5], frame[hip, 6]
    kx, ky, kz, kw = times(hx, hy, hz, hw, 0.0, math.sin(half), 0.0, math.cos(half))
    tx, ty, tz = turn(hx, hy, hz, hw, offset[thigh, 0], offset[thigh, 1], offset[thigh, 2])
    sx, sy, sz = turn(kx, ky, kz, kw, offset[shank, 0], offset[shank, 1], offset[shank, 2])
    ax, ay, az, aw = _shortest(tx + sx, ty + sy, tz + sz, x, y, z)
    _face(frame, hip, times(ax, ay, az, aw, hx, hy, hz, hw))
    _face(frame, knee, times(ax, ay, az, aw, kx, ky, kz, kw))
    _place(frame, knee, hip, turn(ax, ay, az, aw, tx, ty, tz))
    _place(frame, ankle, knee, turn(ax, ay, az, aw, sx, sy, sz))
    ax, ay, az, aw = _shortest(0.0, 0.0, 1.0, -gx, -gy, 1.0)
    f = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    _face(frame, ankle, times(ax, ay, az, aw, f[0], f[1], f[2], f[3]))


@njit(cache=True)
def _face(frame, row, q):  # type: ignore[no-untyped-def]
    frame[row, 3], frame[row, 4], frame[row, 5], frame[row, 6] = q


@njit(cache=True)
def _place(frame, row, up, v):  # type: ignore[no-untyped-def]
    frame[row, 0] = frame[up, 0] + v[0]
    frame[row, 1] = frame[up, 1] + v[1]
    frame[row, 2] = frame[up, 2] + v[2]


@njit(cache=True)
def _length(v, row):  # type: ignore[no-untyped-def]
    return math.sqrt(v[row, 0] ** 2 + v[row, 1] ** 2 + v[row, 2] ** 2)


@njit(cache=True)
def _shortest(ax, ay, az, bx, by, bz):  # type: ignore[no-untyped-def]
    """The shortest turn that takes direction a to b (not opposite ones)."""
    w = math.sqrt((ax * ax + ay * ay + az * az) * (bx * bx + by * by + bz * bz))
    w += ax * bx + ay * by + az * bz
    x, y, z = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    n = 1.0 / math.sqrt(x * x + y * y + z * z + w * w)
    return x * n, y * n, z * n, w * n
