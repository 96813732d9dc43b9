"""Feet on their ground: a leg posed for level ground is bent so that its foot stands on its print.

What ``rig_stand`` says of a foot: where its print is, how far that is ahead of the prototype's own
(for strides of its own), and how the ground under it slopes. The foot moves with its print and
turns with the slope about it, as one stiff piece with the path that it rolls along, so that it
rolls over its heel and ball as on the level and nothing that stands slides. Knee and hip follow by
``rig_leg``.

No joint goes further than its limits. At its own an ankle gives: who lands on his heel on a steep
way up does so with less of his toes up. What is high above the ground (hocks, fetlocks) leans with
slopes along it and not with those across (``rig_stand``), and its limits are wide enough for it.
"""

import math

from numba import njit

from scenes.rig.leg_ik import half_angle, set_rotation, two_bone_ik
from scenes.rig.rotations import quaternion_product, rotate_vector


@njit(cache=True)
def solve_foot(frame, rows, legs, leg, feet, o, number, cos, sin):  # type: ignore[no-untyped-def]
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
    x, y, z = rotate_vector(*slope, ex, ey, ez)
    two_bone_ik(frame, rows, bones, arc, leg, reach[leg, 5], x + px, y + py, z + pz)
    set_rotation(frame, ankle, quaternion_product(*slope, *foot))
    _within(frame, knee, ankle, limits, leg)


@njit(cache=True)
def _within(frame, knee, ankle, limits, leg):  # type: ignore[no-untyped-def]
    """Turn the ankle no further in the knee's frame than its limits, angle by angle of Rz·Ry·Rx.

    limits: as in ``Tables``, 90° at most.
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
    sa, ca = half_angle(a, p * a)
    sb, cb = half_angle(math.sqrt(1.0 - q * q), q)
    sc, cc = half_angle(c, r * c)
    turned = quaternion_product(0.0, 0.0, sc, cc, 0.0, sb, 0.0, cb)
    turned = quaternion_product(*turned, sa, 0.0, 0.0, ca)
    set_rotation(frame, ankle, quaternion_product(ux, uy, uz, uw, *turned))


@njit(cache=True, inline="always")
def _tangent(sine, cosine, other):  # type: ignore[no-untyped-def]
    """Of an angle about x or z: as great as can be beyond 90°, unless both are, which y's does."""
    if cosine > 0.0 or (cosine < 0.0 and other <= 0.0):
        return sine / cosine
    return math.copysign(math.inf, sine)
