"""The stick: the usual appearance of an actor (§2.3, §3.1.1).

Actors: objects with a place, an appearance and parts. ``docs/actors.md`` draws these classes, and
sends the message of figure 4.
"""

from collections.abc import Mapping
from typing import Any

from lod.actors.joint import IDENTITY_JOINT, RevoluteJoint
from lod.actors.message import Route, ask
from lod.actors.object_with_parts import ObjectWithParts, mutator, query
from lod.actors.quaternion import (
    Quaternion,
    Vector,
    VectorLike,
    from_angles,
    rotation,
)
from lod.errors import InputError


class PositionableObject(ObjectWithParts, abstract=True):
    """An object in space: six degrees of freedom through a RevoluteJoint; abstract (§3.1.1)."""

    def __init__(
        self,
        parts: Mapping[str, ObjectWithParts] | None = None,
        joint: RevoluteJoint = IDENTITY_JOINT,
        part_types: Mapping[str, type[ObjectWithParts]] | None = None,
        name: str | None = None,
    ) -> None:
        """Assemble the object; ``joint`` is where and how it is in the frame of its whole."""
        super().__init__(parts, part_types, name)
        self._joint = joint

    @query
    def joint(self) -> RevoluteJoint:
        """Return position, orientation and limits in the frame of its whole."""
        return self._joint

    @query
    def position(self) -> Vector:
        """Return its origin in the frame of its whole [m]."""
        return self._joint.position

    @query
    def orientation(self) -> Quaternion:
        """Return its orientation in the frame of its whole, a number of the asker's own."""
        return self._joint.orientation

    @mutator
    def place(self, position: VectorLike) -> None:
        """Move the origin to a place in the frame of its whole [m]; it stays turned as before."""
        self._set_joint(self._joint.with_position(position))

    @mutator
    def orient(self, orientation: Quaternion) -> None:
        """Replace the orientation (figure 4). A turn beyond the joint's limits is refused."""
        self._set_joint(self._joint.with_orientation(orientation))

    @mutator
    def turn(self, axis: VectorLike, angle_deg: float) -> None:
        """Turn about an axis of the frame of its whole. A turn beyond the limits is refused."""
        turned = rotation(axis, angle_deg) * self._joint.orientation
        self._set_joint(self._joint.with_orientation(turned))

    @mutator
    def bend(self, angles_deg: VectorLike) -> None:
        """Turn by angles about x, y and z [degrees], in Rz·Ry·Rx, within the limits or refused."""
        self._set_joint(self._joint.with_orientation(from_angles(angles_deg)))

    def _set_joint(self, joint: RevoluteJoint) -> None:
        """Take another joint, as every change of place or orientation does."""
        self._joint = joint

    @query
    def where(self, route: Route = ()) -> Vector:
        """Return the origin of the part at a route below, in the frame of this object's whole [m].

        Every whole on the way carries the answer of its part into its own frame.
        """
        if not route:
            return self._joint.position
        return self._joint.to_whole(self._ask_part(ask(route[:1], "where", route[1:])))

    @query
    def frames(self) -> tuple[tuple[Route, RevoluteJoint], ...]:
        """Return the frames of this object and of every part below it, in the frame of its whole.

        Every part answers for those below it, and its whole carries the answers into its own frame.
        """
        found = [((), IDENTITY_JOINT.compose(self._joint))]
        for name in self.part_names():
            below = self._ask_part(ask((name,), "frames"))
            found += [((name, *route), self._joint.compose(frame)) for route, frame in below]
        return tuple(found)


class Actor(PositionableObject, abstract=True):
    """A positionable object that can be seen: it has an appearance slot; abstract (§3.1.1).

    Any value may fill the slot: what it means is a matter of whoever draws it.
    """

    def __init__(
        self,
        parts: Mapping[str, ObjectWithParts] | None = None,
        joint: RevoluteJoint = IDENTITY_JOINT,
        appearance: Any = None,
        part_types: Mapping[str, type[ObjectWithParts]] | None = None,
        name: str | None = None,
    ) -> None:
        super().__init__(parts, joint, part_types, name)
        self._appearance = appearance

    @query
    def appearance(self) -> Any:
        """Return the appearance, in the actor's own frame."""
        return self._appearance

    @mutator
    def set_appearance(self, appearance: Any) -> None:
        """Replace the appearance."""
        self._appearance = appearance


class SimpleActor(Actor):
    """A part without parts: a terminal node, whose capability for parts is disabled (§3.1.1)."""

    def __init_subclass__(cls, abstract: bool = False) -> None:
        super().__init_subclass__(abstract)
        if cls.part_types:
            where, rule = f"{cls.__name__}.part_types", "a SimpleActor has no parts"
            raise InputError(where, list(cls.part_types), rule, "use another class of Actor")

    def __init__(
        self,
        joint: RevoluteJoint = IDENTITY_JOINT,
        appearance: Any = None,
        name: str | None = None,
    ) -> None:
        super().__init__(joint=joint, appearance=appearance, name=name)


class CompoundActor(Actor):
    """An actor assembled from a table: it learns its part types from the parts it is given."""

    def __init__(
        self,
        parts: Mapping[str, ObjectWithParts],
        joint: RevoluteJoint = IDENTITY_JOINT,
        appearance: Any = None,
        name: str | None = None,
    ) -> None:
        types = {part_name: type(part) for part_name, part in parts.items()}
        super().__init__(parts, joint, appearance, types, name)
