"""How a posable prototype becomes an actor of figure 3, and an actor's pose a prototype's.

The modelling tree is an actor each joint (§2.3): the figure itself owns its pelvis, the pelvis the
waist and the hips, and so on to the finger tips. Every actor wears the sticks that ride on its
joint when all detail is displayed. Both are built from the same tables, and a crowd is posed from
the compiled actor by the same walk as from key poses (``pose_from_actor``).
"""

from dataclasses import dataclass, replace

import numpy as np

from lod.actors.actor import Actor, CompoundActor, SimpleActor
from lod.actors.appearance import NO_STICKS, Appearance, ConeStick, StickBundle
from lod.actors.compile import compile_actor
from lod.actors.joint import IDENTITY_JOINT, JointLimits, RevoluteJoint
from lod.actors.quaternion import Quaternion, VectorLike, vector
from scenes.rig.keyframes import rest_motion
from scenes.rig.rig import Rig
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import from_euler, to_euler

_SLACK_DEG = 1e-6


@dataclass(frozen=True, init=False)
class AngleLimits(JointLimits):
    """A box of angles about x, y and z in Rz·Ry·Rx, as tables of figures give them [degrees]."""

    def orientation(self, angles_deg: VectorLike) -> Quaternion:
        """Compute the orientation by those angles."""
        return Quaternion(*from_euler(np.array(vector(angles_deg))).tolist())

    def contains(self, orientation: Quaternion) -> bool:
        """Tell whether its angles lie in the box; the same turn has a second set of them."""
        angles = to_euler(np.array([float(orientation[k]) for k in range(4)]))
        other = angles * np.array((1.0, -1.0, 1.0)) + 180.0
        return self._within(angles) or self._within(other)

    def _within(self, angles: np.ndarray) -> bool:
        low, high = np.array(self.low_deg), np.array(self.high_deg)
        middle = (low + high) / 2
        near = middle + (angles - middle + 180.0) % 360.0 - 180.0
        return bool(np.all((near >= low - _SLACK_DEG) & (near <= high + _SLACK_DEG)))


def to_actor(prototype: RiggedPrototype) -> CompoundActor:
    """Make the prototype at rest an actor whose parts have the names of the rig's joints."""
    rig, looks = prototype.rig, _joint_sticks(prototype)

    def parts_of(joint: int) -> dict[str, Actor]:
        return {rig.name[j]: built(j) for j in np.flatnonzero(rig.parent == joint).tolist()}

    def built(j: int) -> Actor:
        limits = AngleLimits(rig.low[j].tolist(), rig.high[j].tolist())
        here = RevoluteJoint(rig.offset[j].tolist(), rig.rest[j].tolist(), limits)
        parts = parts_of(j)
        return CompoundActor(parts, here, looks[j]) if parts else SimpleActor(here, looks[j])

    return CompoundActor(parts_of(-1), IDENTITY_JOINT, NO_STICKS, name=prototype.name)


def compile_rig(actor: Actor, like: Rig) -> Rig:
    """Compile an actor to a rig that is at rest as the actor is posed now.

    Its joints have the order of those of ``like``, which also says how far the whole sways.

    Raises InputError where a joint has no part of its name; Refused where a whole refuses.
    """
    arrays = compile_actor(actor)
    row = {route[-1]: i for i, route in enumerate(arrays.routes) if route}
    rows = np.array([row[name] if name in row else arrays.row(name) for name in like.name])
    number = {r: j for j, r in enumerate(rows.tolist())} | {0: -1}
    parent = np.array([number[whole] for whole in arrays.parent[rows].tolist()])
    lengths = parent, arrays.position[rows], arrays.orientation[rows]
    limits = arrays.low_deg[rows], arrays.high_deg[rows]
    return Rig(like.name, *lengths, *limits, like.shift_low, like.shift_high)


def pose_from_actor(prototype: RiggedPrototype, actor: Actor) -> RiggedPrototype:
    """Hold the prototype in the pose that its actor is in."""
    return prototype.with_motion(
        replace(rest_motion(prototype.rig), rotations=compile_rig(actor, prototype.rig).rest[None])
    )


def _joint_sticks(prototype: RiggedPrototype) -> list[Appearance]:
    """Collect the sticks that ride on each joint while every part is displayed."""
    sticks: list[list[ConeStick]] = [[] for _ in prototype.rig.name]
    for table in prototype.full_detail_sticks():
        albedo = prototype.tints[table.tint].tolist()
        columns = table.start, table.end, table.start_radius, table.end_radius
        rows = zip(table.start_joint.tolist(), *(c.tolist() for c in columns), albedo, strict=True)
        for joint, *stick in rows:
            sticks[joint].append(ConeStick(*stick))
    return [StickBundle(tuple(own)) if own else NO_STICKS for own in sticks]
