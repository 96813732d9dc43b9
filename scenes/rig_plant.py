"""Feet on their ground: a leg posed for level ground is bent so that its foot stands on its print.

What ``rig_stand`` says of a foot: where its print is, how far that is ahead of the prototype's own
(for strides of its own), and how the ground under it slopes. The foot moves with its print and
turns with the slope about it, as one stiff piece with the path that it rolls along, so that it
rolls over its heel and ball as on the level and nothing that stands slides. The knee follows by the
law of cosines, and the hip by the shortest turn that points the leg at its foot, so that bones keep
their lengths. An ankle goes no further than its joint does: who lands on his heel on a steep way up
does so with less of his toes up.
"""

import math

from numba import njit

from scenes.rig_turns import times, turn


@njit(cache=True)
def plant_leg(  # type: ignore[no-untyped-def]
    frame, hip, knee, ankle, offset, first, longest, limits, leg, feet, o, number, cos, sin
):
    """Bend the leg in rows hip, knee, ankle of ``frame`` (x, y, z and quaternion), changing them.

    offset: bones and bend; first: what to add to a row of ``frame`` for the joint's row of
        ``offset``; longest: how far the leg stretches [m]
    limits (l, 6) of ankles, this one's in row ``leg``: least tan x, sin y, tan z, then the greatest
    feet (n, l, 6), o, number: of the object and of its leg; print x, y, z; how far ahead of the
        prototype's it is; the turn of the ground under it, its x and y; cos, sin: of the heading.
        Row 0 stands on level ground.
    """
    px, py, pz, ahead = (
        feet[o, number, 0],
        feet[o, number, 1],
        feet[o, number, 2],
        feet[o, number, 3],
    )
    ax, ay = feet[o, number, 4], feet[o, number, 5]
    aw = math.sqrt(1.0 - ax * ax - ay * ay)
    # The ankle from the prototype's own print, turned with the ground, put on the object's.
    x = frame[ankle, 0] - px + ahead * cos
    y = frame[ankle, 1] - py + ahead * sin
    x, y, z = turn(ax, ay, 0.0, aw, x, y, frame[ankle, 2] - frame[0, 2])
    x, y, z = x + px - frame[hip, 0], y + py - frame[hip, 1], z + pz - frame[hip, 2]
    thigh, shank = first + knee, first + ankle
    upper, lower = _length(offset, thigh), _length(offset, shank)
    shortest = abs(upper - lower) * 1.001
    distance = min(max(math.sqrt(x * x + y * y + z * z), shortest), longest)
    cosine = (distance * distance - upper * upper - lower * lower) / (2 * upper * lower)
    cosine = min(1.0, max(-1.0, cosine))
    # Sine and cosine of half the knee's angle, from the cosine of all of it.
    bent, straight = math.sqrt((1.0 - cosine) / 2), math.sqrt((1.0 + cosine) / 2)
    hx, hy, hz, hw = frame[hip, 3], frame[hip, 4], frame[hip, 5], frame[hip, 6]
    bent *= offset[first + hip, 3]
    kx, ky, kz, kw = times(hx, hy, hz, hw, 0.0, bent, 0.0, straight)
    tx, ty, tz = turn(hx, hy, hz, hw, offset[thigh, 0], offset[thigh, 1], offset[thigh, 2])
    sx, sy, sz = turn(kx, ky, kz, kw, offset[shank, 0], offset[shank, 1], offset[shank, 2])
    qx, qy, qz, qw = _shortest(tx + sx, ty + sy, tz + sz, x, y, z)
    _face(frame, hip, times(qx, qy, qz, qw, hx, hy, hz, hw))
    _face(frame, knee, times(qx, qy, qz, qw, kx, ky, kz, kw))
    _place(frame, knee, hip, turn(qx, qy, qz, qw, tx, ty, tz))
    _place(frame, ankle, knee, turn(qx, qy, qz, qw, sx, sy, sz))
    f = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    _face(frame, ankle, times(ax, ay, 0.0, aw, f[0], f[1], f[2], f[3]))
    _within(frame, knee, ankle, limits, leg)


@njit(cache=True)
def _within(frame, knee, ankle, limits, leg):  # type: ignore[no-untyped-def]
    """Turn the ankle no further in the knee's frame than its limits, angle by angle of Rz·Ry·Rx."""
    ux, uy, uz, uw = frame[knee, 3], frame[knee, 4], frame[knee, 5], frame[knee, 6]
    f = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    x, y, z, w = times(-ux, -uy, -uz, uw, f[0], f[1], f[2], f[3])
    across, along = 1.0 - 2.0 * (x * x + y * y), 1.0 - 2.0 * (y * y + z * z)
    if across <= 0.0 or along <= 0.0:
        return
    a, b, c = 2.0 * (w * x + y * z) / across, 2.0 * (w * y - z * x), 2.0 * (w * z + x * y) / along
    p = min(max(a, limits[leg, 0]), limits[leg, 3])
    q = min(max(b, limits[leg, 1]), limits[leg, 4])
    r = min(max(c, limits[leg, 2]), limits[leg, 5])
    if p == a and q == b and r == c:
        return
    a, b, c = math.atan(p) / 2, math.asin(q) / 2, math.atan(r) / 2
    turned = times(0.0, 0.0, math.sin(c), math.cos(c), 0.0, math.sin(b), 0.0, math.cos(b))
    turned = times(turned[0], turned[1], turned[2], turned[3], math.sin(a), 0.0, 0.0, math.cos(a))
    _face(frame, ankle, times(ux, uy, uz, uw, turned[0], turned[1], turned[2], turned[3]))


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
