"""The limbs of a live actor: what each joint of a rig carries, moved by messages (§3.1.1).

The modelling tree is an actor each joint (§2.3). A limb is called as what its joint carries,
without a side that it shares with the limb that carries it: a person's right hand is
``torso/abdomen/chest/right arm/forearm/hand``. A body lets the limbs on the way be left out
(``scenes.actors.body``): ``right arm/hand``.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lod.actors.actor import CompoundActor
from lod.actors.appearance import NO_STICKS, Appearance, ConeStick, StickBundle
from lod.actors.dispatch import mutator, query
from lod.actors.joint import JointLimits, RevoluteJoint
from lod.actors.message import SEPARATOR, Route, ask, change
from lod.actors.quaternion import Quaternion, vector
from lod.actors.vectors import Components, Vector, VectorLike
from scenes.rig.anatomy import SIDES
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import from_euler

_SLACK_DEG = 1e-6

Pose = Sequence[tuple[Vector, Components]]
"""Position in the frame of its whole [m] and orientation of every joint of a rig, row by row."""


class LimbTree(NamedTuple):
    """Row of a joint in its rig (−1 is the body itself), and the trees of the limbs it carries."""

    row: int
    limbs: "tuple[tuple[str, LimbTree], ...]"


@dataclass(frozen=True, init=False)
class AngleLimits(JointLimits):
    """A box of angles about x, y and z in Rz·Ry·Rx, as tables of figures give them [degrees]."""

    def orientation(self, angles_deg: VectorLike) -> Quaternion:
        """Compute the orientation by those angles."""
        return Quaternion(*from_euler(np.array(vector(angles_deg))).tolist())

    def contains(self, orientation: Quaternion) -> bool:
        """Tell whether its angles lie in the box; the same turn has a second set of them."""
        x, y, z, w = orientation.x, orientation.y, orientation.z, orientation.w
        about_x = math.degrees(math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)))
        about_y = math.degrees(math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))))
        about_z = math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
        first = about_x, about_y, about_z
        return self._within(first) or self._within((about_x + 180, 180 - about_y, about_z + 180))

    def _within(self, angles: Vector) -> bool:
        for low, angle, high in zip(self.low_deg, angles, self.high_deg, strict=True):
            middle = (low + high) / 2
            near = middle + (angle - middle + 180.0) % 360.0 - 180.0
            if not low - _SLACK_DEG <= near <= high + _SLACK_DEG:
                return False
        return True


class Limb(CompoundActor):
    """A joint with all that it carries. It follows the body's motion until a message turns it."""

    _held = False

    def _set_joint(self, joint: RevoluteJoint) -> None:
        super()._set_joint(joint)
        self._held = True

    @mutator
    def release(self) -> None:
        """Follow the body's motion again, with every limb from here down."""
        self._held = False
        for name in self.part_names():
            self._ask_part(change((name,), "release"))

    @mutator
    def follow(self, tree: LimbTree, pose: Pose, along: Route | None = None) -> None:
        """Take the pose of the body's motion, from here down, where no message holds a limb.

        along  the route on which limbs below do so; None = all of them
        """
        if tree.row >= 0 and not self._held:
            position, turn = pose[tree.row]
            self._joint = RevoluteJoint(position, turn, self._joint.limits)
        self._follow_below(tree, pose, along)

    def _follow_below(self, tree: LimbTree, pose: Pose, along: Route | None) -> None:
        for name, below in tree.limbs:
            if along is None:
                self._ask_part(change((name,), "follow", below, pose))
            elif along[:1] == (name,):
                self._ask_part(change((name,), "follow", below, pose, along[1:]))

    @query
    def held(self, below: bool = True) -> tuple[tuple[Route, Components], ...]:
        """Return the orientations of the limbs that messages hold, with routes from here.

        below  whether those that it carries are asked, too
        """
        found = [((), self._joint.turn)] if self._held else []
        for name in self.part_names() if below else ():
            carried = self._ask_part(ask((name,), "held"))
            found += [((name, *route), turn) for route, turn in carried]
        return tuple(found)


def limb_tree(prototype: RiggedPrototype) -> LimbTree:
    """Arrange the limbs of a prototype as its joints carry one another."""
    parent = prototype.rig.parent.tolist()

    def tree(row: int) -> LimbTree:
        rows = [j for j, above in enumerate(parent) if above == row]
        return LimbTree(row, tuple((_name(prototype, j), tree(j)) for j in rows))

    return tree(-1)


def limb_routes(tree: LimbTree, so_far: Route = ()) -> dict[Route, int]:
    """List the route from the body to each limb, with the row of its joint."""
    found: dict[Route, int] = {}
    for name, below in tree.limbs:
        found[*so_far, name] = below.row
        found |= limb_routes(below, (*so_far, name))
    return found


def build_limbs(prototype: RiggedPrototype, tree: LimbTree) -> tuple[dict[str, Limb], Appearance]:
    """Build the limbs of a body at rest, by name, and what the body itself wears.

    Each limb wears the sticks that ride on its joint.
    """
    rig, looks = prototype.rig, _joint_sticks(prototype)

    def built(below: LimbTree) -> Limb:
        j = below.row
        limits = AngleLimits(rig.low[j].tolist(), rig.high[j].tolist())
        here = RevoluteJoint(rig.offset[j].tolist(), rig.rest[j].tolist(), limits)
        return Limb({name: built(each) for name, each in below.limbs}, here, looks[j])

    return {name: built(below) for name, below in tree.limbs}, looks[-1]


def _name(prototype: RiggedPrototype, row: int) -> str:
    """Name a limb, without the side or the path that it shares with the limb that carries it.

    Limbs of imported models have the paths of their nodes: ``mill/rotor`` of a mill is ``rotor``.
    """
    parent = int(prototype.rig.parent[row])
    if "/" in prototype.limbs[row]:
        root = prototype.limbs[row].partition("/")[0]
        path = prototype.limbs[parent] if parent >= 0 else root
        below = prototype.limbs[row].removeprefix(f"{path}/")
        return below.replace(SEPARATOR, " ").replace(".", " ")
    side, _, bare = prototype.limbs[row].partition(" ")
    above = prototype.limbs[parent].partition(" ")[0] if parent >= 0 else ""
    return bare if side in SIDES and side == above else prototype.limbs[row]


def _joint_sticks(prototype: RiggedPrototype) -> list[Appearance]:
    """Collect the sticks that ride on each joint while every part is displayed.

    Those of the object's own frame stand last.
    """
    sticks: list[list[ConeStick]] = [[] for _ in range(len(prototype.rig) + 1)]
    for table in prototype.full_detail_sticks():
        albedo = prototype.tints[table.tint].tolist()
        columns = table.start, table.end, table.start_radius, table.end_radius
        rows = zip(table.start_joint.tolist(), *(c.tolist() for c in columns), albedo, strict=True)
        for joint, *stick in rows:
            sticks[joint].append(ConeStick(*stick))
    return [StickBundle(tuple(own)) if own else NO_STICKS for own in sticks]
