"""Feet on their ground: a leg posed for level ground is bent so that its foot stands on its print.

What ``rig_stand`` says of a foot: where its print is, how far that is ahead of the prototype's own
(for strides of its own), and how the ground under it slopes. The foot moves with its print and
turns with the slope about it, as one stiff piece with the path that it rolls along, so that it
rolls over its heel and ball as on the level and nothing that stands slides. Knee and hip follow by
``rig_leg``.

No joint goes further than its limits. Where the ankle is near the ground it gives: who lands on his
heel on a steep way up does so with less of his toes up. Where it is high above (hocks, pasterns) it
only nods, and the leg is bent again for the foot as it then is, so that the toes keep their print.
"""

import math

from numba import njit

from scenes.rig_leg import ANKLE, face, half_of, reach_leg, within_arc
from scenes.rig_turns import times, turn

_PASSES = 4
"""How often a leg is bent for a foot whose ankle is high."""


@njit(cache=True)
def plant_leg(frame, rows, legs, leg, feet, o, number, cos, sin):  # type: ignore[no-untyped-def]
    """Bend the leg in rows hip, knee, ankle of ``frame`` (x, y, z and quaternion), changing them.

    rows: hip, knee, ankle, and what the hip rides on
    legs, leg: tables of ``Tables`` (legs, bones, arc, ankle), and this leg's row in them
    feet (n, l, 6), o, number: of the object and of its leg; print x, y, z; how far ahead of the
        prototype's it is; the turn of the ground under it, its x and y; cos, sin: of the heading.
        Row 0 stands on level ground.
    """
    reach, bones, arc, limits = legs
    hip, knee, ankle, _ = rows
    px, py, pz = feet[o, number, 0], feet[o, number, 1], feet[o, number, 2]
    ahead, ax, ay = feet[o, number, 3], feet[o, number, 4], feet[o, number, 5]
    slope = ax, ay, 0.0, math.sqrt(1.0 - ax * ax - ay * ay)
    # The ankle from the prototype's own print, turned with the ground, put on the object's.
    ex = frame[ankle, 0] - px + ahead * cos
    ey = frame[ankle, 1] - py + ahead * sin
    ez = frame[ankle, 2] - frame[0, 2]
    px, py, pz = px - frame[hip, 0], py - frame[hip, 1], pz - frame[hip, 2]
    foot = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    shank = frame[knee, 3], frame[knee, 4], frame[knee, 5], frame[knee, 6]
    gives = bones[leg, 6] > 0
    turned = slope
    for _ in range(1 if gives else _PASSES):
        x, y, z = turn(*turned, ex, ey, ez)
        reach_leg(frame, rows, bones, arc, leg, reach[leg, 5], x + px, y + py, z + pz)
        if gives:
            face(frame, ankle, times(*slope, *foot))
            _within(frame, knee, ankle, limits, leg)
        else:
            turned = _nod(frame, knee, ankle, shank, foot, slope, arc, leg)


@njit(cache=True)
def _nod(frame, knee, ankle, shank, foot, slope, arc, leg):  # type: ignore[no-untyped-def]
    """Turn the ankle about its y alone, as near to the foot on its slope as its limits let it;
    gives how the foot is turned from that on the level.

    shank, foot: as they were posed there.
    """
    r = times(-shank[0], -shank[1], -shank[2], shank[3], *foot)
    kx, ky, kz, kw = frame[knee, 3], frame[knee, 4], frame[knee, 5], frame[knee, 6]
    q = times(*times(-kx, -ky, -kz, kw, *times(*slope, *foot)), -r[0], -r[1], -r[2], r[3])
    # As posed it is Rz·Ry·Rx, of which Ry is to change: a turn about the axis (−sin z, cos z, 0).
    cz, sz, cy, sy = _angles(r)
    c, s = _twist(q[1] * cz - q[0] * sz, q[3])
    c, s = within_arc(cy * c - sy * s, sy * c + cy * s, arc, leg, ANKLE)
    s, c = half_of(c * cy + s * sy, s * cy - c * sy)
    f = times(*times(kx, ky, kz, kw, -sz * s, cz * s, 0.0, c), *r)
    face(frame, ankle, f)
    return times(*f, -foot[0], -foot[1], -foot[2], foot[3])


@njit(cache=True, inline="always")
def _angles(q):  # type: ignore[no-untyped-def]
    """Cosine and sine of z, and of y, of the turn Rz·Ry·Rx, the ones about x and z within ±90°."""
    x, y, z, w = q
    ahead, aside = 1.0 - 2.0 * (y * y + z * z), 2.0 * (w * z + x * y)
    n = math.copysign(math.sqrt(ahead * ahead + aside * aside), 1.0 - 2.0 * (x * x + y * y))
    if abs(n) < 1e-12:
        return 1.0, 0.0, 0.0, 2.0 * (w * y - z * x)
    return ahead / n, aside / n, n, 2.0 * (w * y - z * x)


@njit(cache=True, inline="always")
def _twist(y, w):  # type: ignore[no-untyped-def]
    """Cosine and sine of the angle about an axis, of a turn that has y along it, and w."""
    n = y * y + w * w
    if n < 1e-18:
        return 1.0, 0.0
    return (w * w - y * y) / n, 2.0 * w * y / n


@njit(cache=True)
def _within(frame, knee, ankle, limits, leg):  # type: ignore[no-untyped-def]
    """Turn the ankle no further in the knee's frame than its limits, angle by angle of Rz·Ry·Rx."""
    ux, uy, uz, uw = frame[knee, 3], frame[knee, 4], frame[knee, 5], frame[knee, 6]
    f = frame[ankle, 3], frame[ankle, 4], frame[ankle, 5], frame[ankle, 6]
    x, y, z, w = times(-ux, -uy, -uz, uw, *f)
    across, along = 1.0 - 2.0 * (x * x + y * y), 1.0 - 2.0 * (y * y + z * z)
    if across <= 0.0 or along <= 0.0:
        return
    a, b, c = 2.0 * (w * x + y * z) / across, 2.0 * (w * y - z * x), 2.0 * (w * z + x * y) / along
    p = min(max(a, limits[leg, 0]), limits[leg, 3])
    q = min(max(b, limits[leg, 1]), limits[leg, 4])
    r = min(max(c, limits[leg, 2]), limits[leg, 5])
    if p == a and q == b and r == c:
        return
    a, c = 1.0 / math.sqrt(1.0 + p * p), 1.0 / math.sqrt(1.0 + r * r)
    sa, ca = half_of(a, p * a)
    sb, cb = half_of(math.sqrt(1.0 - q * q), q)
    sc, cc = half_of(c, r * c)
    turned = times(0.0, 0.0, sc, cc, 0.0, sb, 0.0, cb)
    turned = times(*turned, sa, 0.0, 0.0, ca)
    face(frame, ankle, times(ux, uy, uz, uw, *turned))
