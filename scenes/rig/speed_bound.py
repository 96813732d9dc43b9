"""How fast any point of an object moves by its own motion, at any phase: an upper bound.

A point on a joint moves with its joint's origin and with its turning, and the origin with the
joint above: from the root down,

    speed of an origin ≤ speed of the origin above + rate of the turn above · length of the offset,
    rate of a turn     ≤ rate of the turn above + angle between two keys · keys / period,

and so for the ends of sticks. Feet that follow a slope (``leg_ik``) move faster: the body's own
speed is added for it, which suffices for ground no steeper than 45°.
"""

import numpy as np

from lod.arrays import Ints, Points
from scenes.rig.rigged_prototype import RiggedPrototype


def speed_bound(prototype: RiggedPrototype) -> float:
    """Bound the speed of any point of the object against where it stands [m/s]."""
    motion, rig = prototype.motion, prototype.rig
    if len(motion.rotations) == 1:
        return 0.0
    rate = len(motion.rotations) / motion.period
    after = np.roll(motion.rotations, -1, axis=0)
    cosine = np.abs((motion.rotations * after).sum(axis=-1))
    angle = 2 * np.arccos(np.clip(cosine, 0, 1)) * rate
    bob = np.linalg.norm(np.roll(motion.shift, -1, axis=0) - motion.shift, axis=-1) * rate
    speed, turning = np.zeros_like(angle), np.zeros_like(angle)
    for j, parent in enumerate(rig.parent.tolist()):
        length = float(np.linalg.norm(rig.offset[j]))
        speed[:, j] = bob if parent < 0 else speed[:, parent] + turning[:, parent] * length
        turning[:, j] = angle[:, j] + (0.0 if parent < 0 else turning[:, parent])
    reach = _reach(prototype, len(rig))
    fastest = float((speed + turning * reach).max())
    return fastest + (motion.speed if len(motion.feet) else 0.0)


def _reach(prototype: RiggedPrototype, joints: int) -> np.ndarray:
    """Find the greatest distance from each joint to what rides on it, (joints,) [m]."""
    reach = np.zeros(joints)
    ends: list[tuple[Ints, Points]] = [(prototype.joint, prototype.place)]
    for table in (prototype.inner, prototype.leaf):
        ends += [(table.start_joint, table.start), (table.end_joint, table.end)]
    for joint, place in ends:
        on = joint >= 0
        np.maximum.at(reach, joint[on], np.linalg.norm(place[on], axis=1))
    return reach
