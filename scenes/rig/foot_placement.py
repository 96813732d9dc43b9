"""Placement on the ground: how high does each body stand, and where is each of its feet?

The ground's height is taken at three points under each sole (heel, and both sides of the ball), at
the print on which the foot stands. While the foot swings the height is taken at two prints, the one
it left and the one it goes to, and the plane under the foot passes from the one to the other. So a
foot that stands keeps one plane under it, however rough the ground, and a foot that swings arrives
at the plane of its next print as it lands. The body's height is the mean of its prints' heights,
less what it must sink for its legs to reach their prints. How a foot rolls from heel to toe is
decided before, in ``scenes.figures.gait``.

A sole follows slopes up to the prototype's ``Feet.steepest``, and no print is farther above or
below the mean of all than such a slope would put it. The priority P, the range R and the bound B of
a prototype's parts (docs/method.md) are computed for these slopes; steeper ground is beyond what
the joints allow.

Objects without legs stand on the ground below their origin. So do objects too far for legs to be
displayed, and those too far for feet have one point under each print instead of three: see
``Placements.contact_detail``, which scenes/field/species_field.py decides.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Reals, frozen
from lod.kernels import ZERO, njit
from scenes.rig.leg_ik import (
    ACROSS,
    AHEAD,
    DUTY,
    HOME_X,
    HOME_Y,
    MAX_RISE,
    PRINT_X,
    PRINT_Y,
    PRINT_Z,
    REACH,
    SLOPE_X,
    SLOPE_Y,
    STEEPEST,
    STRIDE,
    STRIKE,
)
from scenes.rig.pose import (
    AT_HIP_X,
    AT_HIP_Y,
    AT_HIP_Z,
    FIRST_HIP,
    FIRST_LEG,
    FROM_PRINT_X,
    FROM_PRINT_Y,
    FROM_PRINT_Z,
    KEYS,
    LEGS,
    Instances,
    PoseTables,
)
from scenes.rig.rig import print_and_swing

BODY, FOOTPRINT, SOLE = 0, 1, 2
"""Detail of ground contact: the ground's height is taken below the body alone, below each
footprint, or at three points below each sole, whose plane a standing foot follows."""

HEIGHT, SLOPE_ALONG, SLOPE_ACROSS = range(3)
"""Columns of the ground's plane under a foot: height at its print [m], and slope along x and along
y of the object's frame."""

Heights = Callable[[Float64[np.ndarray, "m 2"]], Reals]
"""Heights of the ground [m] at points (m, 2) of the plan [m]."""


class Placements(NamedTuple):
    """Places of instances in the plan, and the state of their motions, (n,) each.

    xy              (n, 2) in the plan [m]
    cos, sin        of the heading
    prototype       row in the pose tables
    phase           of its motion [cycles]
    stride_factor   its stride as a share of its prototype's
    contact_detail  BODY, FOOTPRINT or SOLE; or (1,), one for all
    """

    xy: np.ndarray
    cos: Reals
    sin: Reals
    prototype: Ints
    phase: Reals
    stride_factor: Reals
    contact_detail: Ints = frozen([SOLE], np.int64)


def place_on_ground(pose_tables: PoseTables, heights: Heights, placements: Placements) -> Instances:
    """Place instances on the ground: heights of their bodies, and contacts of their feet."""
    # Read-only columns, with phases within one cycle and a contact detail for each.
    xy, cos, sin, prototype, phase, stride_factor, contact_detail = placements
    details = np.broadcast_to(contact_detail, len(prototype))
    where = Placements(
        frozen(xy, np.float64),
        frozen(cos, np.float64),
        frozen(sin, np.float64),
        frozen(prototype, np.int64),
        frozen(phase - np.floor(phase), np.float64),
        frozen(stride_factor, np.float64),
        frozen(details, np.int64),
    )
    ground = frozen(heights(_contact_points(pose_tables, where)), np.float64)
    base, contacts = _place_bodies(pose_tables, where, ground)
    origin = frozen(np.column_stack((where.xy, base)), np.float64)
    phase = frozen(where.phase - np.floor(where.phase), np.float64)  # what was rounded to 1 is 0
    contacts = frozen(contacts, np.float64)
    return Instances(origin, where.cos, where.sin, where.prototype, phase, contacts)


@njit(cache=True)
def _contact_points(tables: PoseTables, where: Placements) -> np.ndarray:
    """Points of the plan at which the ground's height is needed, (m, 2) [m].

    They are in the order of objects, their legs, the prints of a leg (two while it swings: the one
    it left, the one it goes to) and the points of a sole.
    """
    # At most two prints of three points a leg.
    points, m = np.empty((len(where.prototype) * max(6 * tables.max_legs, 1), 2)), 0
    leg, sole = tables.legs.leg, tables.sole
    for o in range(len(where.prototype)):
        v = where.prototype[o]
        first, legs = tables.prototypes[v, FIRST_LEG], tables.prototypes[v, LEGS]
        if legs == 0 or where.contact_detail[o] == BODY:
            points[m, 0], points[m, 1] = where.xy[o, 0], where.xy[o, 1]
            m += 1
            continue
        for row in range(first, first + legs):
            since_landing = (where.phase[o] - leg[row, STRIKE]) % 1.0
            last, _ = print_and_swing(since_landing, leg[row, DUTY])
            for following in range(2 if since_landing > leg[row, DUTY] else 1):
                ahead = leg[row, HOME_X]
                ahead += where.stride_factor[o] * leg[row, STRIDE] * (last + following)
                for k in range(3 if where.contact_detail[o] == SOLE else 1):
                    x, y = ahead, leg[row, HOME_Y]
                    if where.contact_detail[o] == SOLE:
                        x, y = x + sole[row, k, 0], y + sole[row, k, 1]
                    points[m, 0], points[m, 1] = _in_plan(where, o, x, y)
                    m += 1
    return points[:m]


@njit(cache=True, inline="always")
def _in_plan(where: Placements, o: int, x: float, y: float) -> tuple[float, float]:
    cos, sin = where.cos[o], where.sin[o]
    return where.xy[o, 0] + cos * x - sin * y, where.xy[o, 1] + sin * x + cos * y


@njit(cache=True)
def _place_bodies(tables, where, ground):  # type: ignore[no-untyped-def]
    """Height of each body (n,) [m], and its ``Instances.foot_contacts`` (n, max_legs, 6).

    ground  (m,) heights at ``_contact_points`` [m]
    """
    n, m, leg, hip = len(where.prototype), ZERO, tables.legs.leg, tables.hip
    max_legs = tables.max_legs
    base, contacts, planes = np.empty(n), np.zeros((n, max_legs, 6)), np.empty((max_legs, 3))
    for o in range(n):
        v = where.prototype[o]
        first, legs = tables.prototypes[v, FIRST_LEG], tables.prototypes[v, LEGS]
        if legs == 0 or where.contact_detail[o] == BODY:
            base[o] = ground[m]
            contacts[o, :, PRINT_Z] = ground[m]  # flat ground, at the prototype's own stride
            m += 1
            continue
        mean = 0.0
        for k in range(legs):
            phase, detail = where.phase[o], where.contact_detail[o]
            m = _ground_plane(leg, tables.plane, first + k, phase, detail, ground, m, planes[k])
            mean += planes[k, HEIGHT] / legs
        keys, first_hip = tables.prototypes[v, KEYS], tables.prototypes[v, FIRST_HIP]
        key_position = where.phase[o] * keys
        key = min(int(key_position), keys - 1)
        body_shift = 0.0  # 0 or less: the body sinks until its most stretched leg reaches
        for k in range(legs):
            contact, at = contacts[o, k], first_hip + key * legs + k
            hips, share = (hip[at], hip[at + legs]), key_position - key
            phase, pace = where.phase[o], where.stride_factor[o]
            room = _place_foot(leg, first + k, hips, share, phase, pace, mean, planes[k], contact)
            body_shift = min(body_shift, room)
            x, y, ax, ay = contact[PRINT_X], contact[PRINT_Y], contact[SLOPE_X], contact[SLOPE_Y]
            cos, sin = where.cos[o], where.sin[o]
            contact[PRINT_X], contact[PRINT_Y] = _in_plan(where, o, x, y)
            contact[SLOPE_X], contact[SLOPE_Y] = cos * ax - sin * ay, sin * ax + cos * ay
        base[o] = mean + body_shift
    return base, contacts


@njit(cache=True)
def _ground_plane(leg, sole_planes, row, phase, detail, ground, m, plane):  # type: ignore[no-untyped-def]
    """Write the plane under a foot into ``plane`` (3,): HEIGHT, SLOPE_ALONG and SLOPE_ACROSS.

    leg          (l, 9) LegTables.leg; ``row`` is the leg's
    sole_planes  (l, 3, 3) PoseTables.plane: from heights at the sole's points to the plane
    ground       heights of the ground, those of this foot from ``m`` on

    Returns the row of ``ground`` after those of this foot.
    """
    since_landing = (phase - leg[row, STRIKE]) % 1.0
    _, swing = print_and_swing(since_landing, leg[row, DUTY])
    plane[:] = 0.0
    for following in range(2 if since_landing > leg[row, DUTY] else 1):
        share = swing if following == 1 else 1.0 - swing
        if detail == FOOTPRINT:
            plane[HEIGHT] += share * ground[m]
            m += 1
            continue
        for c in range(3):
            for k in range(3):
                plane[c] += share * sole_planes[row, c, k] * ground[m + k]
        m += 3
    along, across, steepest = plane[SLOPE_ALONG], plane[SLOPE_ACROSS], leg[row, STEEPEST]
    slope = math.sqrt(along * along + across * across)
    if slope > steepest:
        plane[SLOPE_ALONG] = along * steepest / slope
        plane[SLOPE_ACROSS] = across * steepest / slope
    plane[SLOPE_ACROSS] *= leg[row, ACROSS]
    return m


@njit(cache=True)
def _place_foot(leg, row, hips, share, phase, pace, mean, plane, contact):  # type: ignore[no-untyped-def]
    """Write a foot's contact in the object's frame into ``contact`` (6,).

    leg    (l, 9) LegTables.leg; ``row`` is the leg's
    hips   rows of PoseTables.hip at the keys before and after the object's phase
    share  of the way from the one to the other, 0 to 1
    pace   the object's stride as a share of its prototype's
    mean   mean height of the object's prints [m]
    plane  (3,) the ground's plane under the foot

    Returns how far the body may rise above ``mean`` until the leg is stretched to its reach [m];
    below 0 the body has to sink by as much.
    """
    last, swing = print_and_swing((phase - leg[row, STRIKE]) % 1.0, leg[row, DUTY])
    ahead, longest = leg[row, STRIDE] * (last + swing), leg[row, REACH]
    rise = min(max(plane[HEIGHT] - mean, -leg[row, MAX_RISE]), leg[row, MAX_RISE])
    along, across = plane[SLOPE_ALONG], plane[SLOPE_ACROSS]
    # The quaternion (qx, qy, 0, qw) that turns the vertical into the plane's normal.
    normal = math.sqrt(1.0 + along * along + across * across)
    unit = 1.0 / math.sqrt(2.0 * normal * (1.0 + normal))
    qx, qy, qw = across * unit, -along * unit, (1.0 + normal) * unit
    contact[PRINT_X], contact[PRINT_Y] = leg[row, HOME_X] + pace * ahead, leg[row, HOME_Y]
    contact[PRINT_Z], contact[AHEAD] = mean + rise, (pace - 1.0) * ahead
    contact[SLOPE_X], contact[SLOPE_Y] = qx, qy
    # The vector from the print to the ankle, turned by the quaternion: v + qw·t + q×t, t = 2·q×v.
    now, then = hips
    x = (1 - share) * now[FROM_PRINT_X] + share * then[FROM_PRINT_X]
    y = (1 - share) * now[FROM_PRINT_Y] + share * then[FROM_PRINT_Y]
    z = (1 - share) * now[FROM_PRINT_Z] + share * then[FROM_PRINT_Z]
    tx, ty, tz = 2 * qy * z, -2 * qx * z, 2 * (qx * y - qy * x)
    x, y, z = x + qw * tx + qy * tz, y + qw * ty - qx * tz, z + qw * tz + qx * ty - qy * tx
    # Plus the print, less the hip: the vector from the hip to the ankle, with the body at ``mean``.
    x += contact[PRINT_X] - (1 - share) * now[AT_HIP_X] - share * then[AT_HIP_X]
    y += contact[PRINT_Y] - (1 - share) * now[AT_HIP_Y] - share * then[AT_HIP_Y]
    z += rise - (1 - share) * now[AT_HIP_Z] - share * then[AT_HIP_Z]
    return z + math.sqrt(max(0.0, longest * longest - x * x - y * y))
