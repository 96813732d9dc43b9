"""Where bodies stand: every foot on the ground under its own print, at the object's own stride.

The ground is asked for its height at three points under each sole (heel, and both sides of the
ball), at the print that the foot stands on; while it swings, at the print it left and at the one it
goes to, and the plane under it passes from the one to the other. So a foot that stands keeps the
very same ground under it, however rough, and one that swings meets its next print as it lands. The
body is as high as its prints are on average, or lower where a leg would be too short.

A sole follows slopes up to the ``steepest`` of its kind, and a print is no further above or below
the others than such a slope would put it: steeper ground is beyond what joints can stand on, and P,
R and B hold for what they can.

Objects without legs stand on the ground below their origin. So do those too far for legs to be
displayed, and those too far for feet have one point under each print instead of three
(``rig_heed``).
"""

import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Reals
from scenes.rig.footprints import print_and_swing
from scenes.rig.pose_tables import Instances, PoseTables

BODY, FOOTPRINT, SOLE = 0, 1, 2
"""Levels of detail of ground contact: the ground's height is taken below the body alone, below each
footprint, or at three points below each sole, whose plane a standing foot follows."""

Heights = Callable[[Float64[np.ndarray, "m 2"]], Reals]


def place_on_ground(
    pose_tables: PoseTables,
    heights: Heights,
    xy: Float64[np.ndarray, "n 2"],
    cos: Reals,
    sin: Reals,
    prototype: Ints,
    phase: Reals,
    stride_factor: Reals,
    heed: Ints | None = None,
) -> Instances:
    """Bodies at xy (n, 2) [m] with headings, prototypes and phases, (n,) each.

    heights: of the ground [m] at points of the frame; pace (n,): each one's stride as a share of
        its prototype's; heed (n,): how closely each minds the ground, SOLE by default
    """
    heed = np.full(len(prototype), SOLE) if heed is None else heed
    t, within = pose_tables.tables, phase - np.floor(phase)
    places = (xy, cos, sin, prototype, within, stride_factor, heed)
    points = _soles(t.pose_tables, t.leg, t.sole, *places)
    ground = np.ascontiguousarray(heights(points))
    base, feet = _stand(t.pose_tables, t.leg, t.plane, t.hip, pose_tables.max_legs, *places, ground)
    return Instances(np.column_stack((xy, base)), cos, sin, prototype, within, feet)


@njit(cache=True)
def _soles(pose_tables, leg, sole, xy, cos, sin, prototype, phase, stride_factor, heed):  # type: ignore[no-untyped-def]
    """Points under every sole that stands, and under both prints of one that swings, (m, 2)."""
    points, m = np.empty((_most_points(pose_tables, leg, prototype, phase, heed), 2)), 0
    for o in range(len(prototype)):
        first, legs = pose_tables[prototype[o], 5], pose_tables[prototype[o], 6]
        if legs == 0 or heed[o] == BODY:
            points[m, 0], points[m, 1] = xy[o, 0], xy[o, 1]
            m += 1
            continue
        closely = heed[o] == SOLE
        for row in range(first, first + legs):
            own = (phase[o] - leg[row, 0]) % 1.0
            last, _ = print_and_swing(own, leg[row, 1])
            for step in range(2 if own > leg[row, 1] else 1):
                ahead = leg[row, 2] + stride_factor[o] * leg[row, 4] * (last + step)
                for k in range(3 if closely else 1):
                    x, y = ahead, leg[row, 3]
                    if closely:
                        x, y = x + sole[row, k, 0], y + sole[row, k, 1]
                    points[m, 0] = xy[o, 0] + cos[o] * x - sin[o] * y
                    points[m, 1] = xy[o, 1] + sin[o] * x + cos[o] * y
                    m += 1
    return points


@njit(cache=True)
def _most_points(pose_tables, leg, prototype, phase, heed):  # type: ignore[no-untyped-def]
    """How many points that takes."""
    count = 0
    for o in range(len(prototype)):
        first, legs = pose_tables[prototype[o], 5], pose_tables[prototype[o], 6]
        if legs == 0 or heed[o] == BODY:
            count += 1
            continue
        each = 3 if heed[o] == SOLE else 1
        for row in range(first, first + legs):
            count += 2 * each if (phase[o] - leg[row, 0]) % 1.0 > leg[row, 1] else each
    return count


@njit(cache=True)
def _stand(  # type: ignore[no-untyped-def]
    pose_tables, leg, plane, hip, most, xy, cos, sin, prototype, phase, stride_factor, heed, ground
):
    """Height of each body (n,), and of each foot (n, most, 6) what ``rig_plant`` reads."""
    n, m = len(prototype), 0
    base, feet, under = np.empty(n), np.zeros((n, most, 6)), np.empty((most, 3))
    for o in range(n):
        v = prototype[o]
        first, legs = pose_tables[v, 5], pose_tables[v, 6]
        if legs == 0 or heed[o] == BODY:
            base[o] = ground[m]
            feet[o, :, 2] = ground[m]  # level ground, at the prototype's own stride
            m += 1
            continue
        mean = 0.0
        for k in range(legs):
            m = _under(leg, plane, ground, m, first + k, phase[o], heed[o], under[k])
            mean += under[k, 0] / legs
        along = phase[o] * pose_tables[v, 3]
        key = min(int(along), pose_tables[v, 3] - 1)
        drop = 0.0
        for k in range(legs):
            rows = pose_tables[v, 7] + key * legs + k, pose_tables[v, 7] + (key + 1) * legs + k
            foot = feet[o, k]
            at = along - key, phase[o], stride_factor[o], mean
            drop = min(drop, _foot(leg, hip, first + k, rows, at, under[k], foot))
            x, y, ax, ay = foot[0], foot[1], foot[4], foot[5]
            foot[0] = xy[o, 0] + cos[o] * x - sin[o] * y
            foot[1] = xy[o, 1] + sin[o] * x + cos[o] * y
            foot[4], foot[5] = cos[o] * ax - sin[o] * ay, sin[o] * ax + cos[o] * ay
        base[o] = mean + drop
    return base, feet


@njit(cache=True)
def _under(leg, plane, ground, m, row, phase, heed, out):  # type: ignore[no-untyped-def]
    """The plane under a foot: height at its print, slope along x and y; and where ``ground`` goes
    on.
    """
    own = (phase - leg[row, 0]) % 1.0
    _, swing = print_and_swing(own, leg[row, 1])
    out[0] = out[1] = out[2] = 0.0
    for step in range(2 if own > leg[row, 1] else 1):
        share = swing if step == 1 else 1.0 - swing
        if heed == FOOTPRINT:
            out[0] += share * ground[m]
            m += 1
            continue
        for c in range(3):
            for k in range(3):
                out[c] += share * plane[row, c, k] * ground[m + k]
        m += 3
    steep = math.sqrt(out[1] * out[1] + out[2] * out[2])
    if steep > leg[row, 6]:
        out[1], out[2] = out[1] * leg[row, 6] / steep, out[2] * leg[row, 6] / steep
    out[2] *= leg[row, 8]
    return m


@njit(cache=True)
def _foot(leg, hip, row, keys, at, under, foot):  # type: ignore[no-untyped-def]
    """Where a foot's print is, in the object's frame; gives how far the body may rise for the leg
    to reach it [m].
    """
    share, phase, stride_factor, mean = at
    last, swing = print_and_swing((phase - leg[row, 0]) % 1.0, leg[row, 1])
    ahead, longest = leg[row, 4] * (last + swing), leg[row, 5]
    rise = min(max(under[0] - mean, -leg[row, 7]), leg[row, 7])
    normal = math.sqrt(1.0 + under[1] * under[1] + under[2] * under[2])
    unit = 1.0 / math.sqrt(2.0 * normal * (1.0 + normal))
    ax, ay, w = under[2] * unit, -under[1] * unit, (1.0 + normal) * unit
    foot[0], foot[1], foot[2] = leg[row, 2] + stride_factor * ahead, leg[row, 3], mean + rise
    foot[3], foot[4], foot[5] = (stride_factor - 1.0) * ahead, ax, ay
    a, b = keys
    x = (1 - share) * hip[a, 3] + share * hip[b, 3]
    y = (1 - share) * hip[a, 4] + share * hip[b, 4]
    z = (1 - share) * hip[a, 5] + share * hip[b, 5]
    tx, ty, tz = 2 * ay * z, -2 * ax * z, 2 * (ax * y - ay * x)
    x, y, z = x + w * tx + ay * tz, y + w * ty - ax * tz, z + w * tz + ax * ty - ay * tx
    x += foot[0] - (1 - share) * hip[a, 0] - share * hip[b, 0]
    y += foot[1] - (1 - share) * hip[a, 1] - share * hip[b, 1]
    z += rise - (1 - share) * hip[a, 2] - share * hip[b, 2]
    return z + math.sqrt(max(0.0, longest * longest - x * x - y * y))
