"""How far up and down where a body stands can go: a bound, whatever its phase and wherever near.

With every point under its soles within r of the body, and the ground rising by at most ρ(r) over r,

    the mean of its prints is within ω·ρ(r) of the ground below the body,

ω the sum of the weights by which a plane through three points gives a print's height. The body is
that high, or lower by what a leg is too short: at most by how far its hip is above its ankle, and
its print below the others.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from scenes.rig.pose_tables import PoseTables
from scenes.rig.rigged_prototype import RiggedPrototype


def max_speed(prototypes: Sequence[RiggedPrototype]) -> float:
    """Speed that nobody's steps are above [m/s]: own strides are shorter, and slower."""
    return max(each.motion.speed for each in prototypes)


def height_bound(pose_tables: PoseTables, ground: Any, gone: float) -> float:
    """Farthest up or down that the origin of any of them goes while it walks ``gone`` m [m]."""
    t = pose_tables.tables
    if not len(t.leg):
        return max_rise(ground, gone)
    soles = np.linalg.norm(t.sole, axis=-1).max()
    reach = np.hypot(t.leg[:, 2], t.leg[:, 3]).max() + np.abs(t.leg[:, 4]).max() + soles
    weight = np.abs(t.plane[:, 0]).sum(axis=-1).max()
    leg = np.linalg.norm(t.hip[:, 3:], axis=1).max() + np.abs(t.hip[:, 2]).max()
    short = float(leg + t.leg[:, 7].max())
    return 2 * float(weight) * max_rise(ground, float(reach)) + max_rise(ground, gone) + short


def max_rise(ground: Any, radius: float) -> float:
    """How much higher or lower than at a point the ground can be that far from it [m]."""
    low, high = ground.bounds()
    rise = getattr(ground, "rise", None)
    return high - low if rise is None else min(high - low, float(rise(radius)))
