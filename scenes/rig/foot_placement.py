"""Where instances stand: each foot on the ground under its own print, at the instance's own stride.

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
(``scenes.field.ground_contact_detail``).
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Reals, frozen
from scenes.rig.footprints import print_and_swing
from scenes.rig.leg_ik import (
    ACROSS,
    DUTY,
    HOME_X,
    HOME_Y,
    MAX_RISE,
    REACH,
    STEEPEST,
    STRIDE,
    STRIKE,
)
from scenes.rig.pose_tables import (
    AHEAD,
    FIRST_HIP,
    FIRST_LEG,
    KEYS,
    LEGS,
    PRINT_X,
    PRINT_Y,
    PRINT_Z,
    SLOPE_X,
    SLOPE_Y,
    Instances,
    PoseTables,
)

BODY, FOOTPRINT, SOLE = 0, 1, 2
"""Levels of detail of ground contact: the ground's height is taken below the body alone, below each
footprint, or at three points below each sole, whose plane a standing foot follows."""

Heights = Callable[[Float64[np.ndarray, "m 2"]], Reals]


class Placements(NamedTuple):
    """Where instances are to stand, (n,) each.

    xy     (n, 2) in the plan [m]; cos, sin: of the heading; prototype: row in the pose tables
    phase  of its motion [cycles]
    stride_factor  its stride as a share of its prototype's
    level  of detail of its ground contact: BODY, FOOTPRINT or SOLE
    """

    xy: np.ndarray
    cos: Reals
    sin: Reals
    prototype: Ints
    phase: Reals
    stride_factor: Reals
    level: Ints | int = SOLE


def place_on_ground(pose_tables: PoseTables, heights: Heights, placements: Placements) -> Instances:
    """The instances that stand on the ground there; heights: of the ground [m] at points (m, 2)."""
    where, columns = _columns(placements), pose_tables.columns
    ground = frozen(heights(_contact_points(columns, where)), np.float64)
    base, contacts = _stand(columns, pose_tables.max_legs, where, ground)
    facing = where.cos, where.sin
    origin = np.column_stack((where.xy, base))
    return Instances(origin, *facing, where.prototype, where.phase, contacts)


def _columns(placements: Placements) -> Placements:
    """The same with read-only columns, phases within one cycle and levels one by one."""
    xy, cos, sin, prototype, phase, stride_factor, level = placements
    levels = np.broadcast_to(level, len(prototype))
    return Placements(
        frozen(xy, np.float64),
        frozen(cos, np.float64),
        frozen(sin, np.float64),
        frozen(prototype, np.int64),
        frozen(phase - np.floor(phase), np.float64),
        frozen(stride_factor, np.float64),
        frozen(levels, np.int64),
    )


@njit(cache=True)
def _contact_points(tables, where):  # type: ignore[no-untyped-def]
    """Points of the plan under every sole that stands, and under both prints of one that swings,
    (m, 2) [m].
    """
    points, m = np.empty((_point_count(tables, where), 2)), 0
    leg, sole = tables.legs.leg, tables.sole
    for o in range(len(where.prototype)):
        v = where.prototype[o]
        first, legs = tables.prototypes[v, FIRST_LEG], tables.prototypes[v, LEGS]
        if legs == 0 or where.level[o] == BODY:
            points[m, 0], points[m, 1] = where.xy[o, 0], where.xy[o, 1]
            m += 1
            continue
        for row in range(first, first + legs):
            own = (where.phase[o] - leg[row, STRIKE]) % 1.0
            last, _ = print_and_swing(own, leg[row, DUTY])
            for step in range(2 if own > leg[row, DUTY] else 1):
                ahead = leg[row, HOME_X]
                ahead += where.stride_factor[o] * leg[row, STRIDE] * (last + step)
                for k in range(3 if where.level[o] == SOLE else 1):
                    x, y = ahead, leg[row, HOME_Y]
                    if where.level[o] == SOLE:
                        x, y = x + sole[row, k, 0], y + sole[row, k, 1]
                    points[m, 0], points[m, 1] = _in_plan(where, o, x, y)
                    m += 1
    return points


@njit(cache=True, inline="always")
def _in_plan(where, o, x, y):  # type: ignore[no-untyped-def]
    """Where a point of object ``o`` is in the plan, x and y [m]."""
    cos, sin = where.cos[o], where.sin[o]
    return where.xy[o, 0] + cos * x - sin * y, where.xy[o, 1] + sin * x + cos * y


@njit(cache=True)
def _point_count(tables, where):  # type: ignore[no-untyped-def]
    """How many points ``_contact_points`` gives."""
    count, leg = 0, tables.legs.leg
    for o in range(len(where.prototype)):
        v = where.prototype[o]
        first, legs = tables.prototypes[v, FIRST_LEG], tables.prototypes[v, LEGS]
        if legs == 0 or where.level[o] == BODY:
            count += 1
            continue
        each = 3 if where.level[o] == SOLE else 1
        for row in range(first, first + legs):
            swings = (where.phase[o] - leg[row, STRIKE]) % 1.0 > leg[row, DUTY]
            count += 2 * each if swings else each
    return count


class _Step(NamedTuple):
    """How far through its cycle a leg is: rows of ``PoseColumns.hip`` at the keys before and after
    its phase, share of the way from one to the other, phase, and stride factor.
    """

    before: int
    after: int
    share: float
    phase: float
    stride_factor: float


@njit(cache=True)
def _stand(tables, max_legs, where, ground):  # type: ignore[no-untyped-def]
    """Height of each body (n,) [m], and its ``Instances.foot_contacts`` (n, max_legs, 6).

    ground: heights at ``_contact_points`` [m]
    """
    n, m, leg, hip = len(where.prototype), 0, tables.legs.leg, tables.hip
    base, contacts, under = np.empty(n), np.zeros((n, max_legs, 6)), np.empty((max_legs, 3))
    for o in range(n):
        v = where.prototype[o]
        first, legs = tables.prototypes[v, FIRST_LEG], tables.prototypes[v, LEGS]
        if legs == 0 or where.level[o] == BODY:
            base[o] = ground[m]
            contacts[o, :, PRINT_Z] = ground[m]  # level ground, at the prototype's own stride
            m += 1
            continue
        mean = 0.0
        for k in range(legs):
            phase, level = where.phase[o], where.level[o]
            m = _ground_plane(leg, tables.plane, first + k, phase, level, ground, m, under[k])
            mean += under[k, 0] / legs
        keys, first_hip = tables.prototypes[v, KEYS], tables.prototypes[v, FIRST_HIP]
        along = where.phase[o] * keys
        key = min(int(along), keys - 1)
        drop = 0.0
        for k in range(legs):
            contact, before = contacts[o, k], first_hip + key * legs + k
            at = _Step(before, before + legs, along - key, where.phase[o], where.stride_factor[o])
            drop = min(drop, _place_foot(leg, hip, first + k, at, mean, under[k], contact))
            x, y, ax, ay = contact[PRINT_X], contact[PRINT_Y], contact[SLOPE_X], contact[SLOPE_Y]
            cos, sin = where.cos[o], where.sin[o]
            contact[PRINT_X], contact[PRINT_Y] = _in_plan(where, o, x, y)
            contact[SLOPE_X], contact[SLOPE_Y] = cos * ax - sin * ay, sin * ax + cos * ay
        base[o] = mean + drop
    return base, contacts


@njit(cache=True)
def _ground_plane(leg, plane, row, phase, level, ground, m, out):  # type: ignore[no-untyped-def]
    """The plane under a foot into ``out``: height at its print, slope along x and y. Gives the row
    of ``ground`` after those of this foot.
    """
    own = (phase - leg[row, STRIKE]) % 1.0
    _, swing = print_and_swing(own, leg[row, DUTY])
    out[0] = out[1] = out[2] = 0.0
    for step in range(2 if own > leg[row, DUTY] else 1):
        share = swing if step == 1 else 1.0 - swing
        if level == FOOTPRINT:
            out[0] += share * ground[m]
            m += 1
            continue
        for c in range(3):
            for k in range(3):
                out[c] += share * plane[row, c, k] * ground[m + k]
        m += 3
    steep, most = math.sqrt(out[1] * out[1] + out[2] * out[2]), leg[row, STEEPEST]
    if steep > most:
        out[1], out[2] = out[1] * most / steep, out[2] * most / steep
    out[2] *= leg[row, ACROSS]
    return m


@njit(cache=True)
def _place_foot(leg, hip, row, step, mean, under, contact):  # type: ignore[no-untyped-def]
    """A foot's contact in the object's frame, into ``contact``; gives how far the body may rise for
    the leg to reach it [m].

    row: of the leg; mean: height of all prints of the object [m]; under: the ground's plane
    """
    a, b, share, pace = step.before, step.after, step.share, step.stride_factor
    last, swing = print_and_swing((step.phase - leg[row, STRIKE]) % 1.0, leg[row, DUTY])
    ahead, longest = leg[row, STRIDE] * (last + swing), leg[row, REACH]
    rise = min(max(under[0] - mean, -leg[row, MAX_RISE]), leg[row, MAX_RISE])
    normal = math.sqrt(1.0 + under[1] * under[1] + under[2] * under[2])
    unit = 1.0 / math.sqrt(2.0 * normal * (1.0 + normal))
    ax, ay, w = under[2] * unit, -under[1] * unit, (1.0 + normal) * unit
    contact[PRINT_X], contact[PRINT_Y] = leg[row, HOME_X] + pace * ahead, leg[row, HOME_Y]
    contact[PRINT_Z], contact[AHEAD] = mean + rise, (pace - 1.0) * ahead
    contact[SLOPE_X], contact[SLOPE_Y] = ax, ay
    # The ankle from its print, turned with the ground, and the hip above it.
    x = (1 - share) * hip[a, 3] + share * hip[b, 3]
    y = (1 - share) * hip[a, 4] + share * hip[b, 4]
    z = (1 - share) * hip[a, 5] + share * hip[b, 5]
    tx, ty, tz = 2 * ay * z, -2 * ax * z, 2 * (ax * y - ay * x)
    x, y, z = x + w * tx + ay * tz, y + w * ty - ax * tz, z + w * tz + ax * ty - ay * tx
    x += contact[PRINT_X] - (1 - share) * hip[a, 0] - share * hip[b, 0]
    y += contact[PRINT_Y] - (1 - share) * hip[a, 1] - share * hip[b, 1]
    z += rise - (1 - share) * hip[a, 2] - share * hip[b, 2]
    return z + math.sqrt(max(0.0, longest * longest - x * x - y * y))
