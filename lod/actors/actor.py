"""Actors: objects with a place, an appearance and parts (§2.3, §3.1.1), and quaternions (§3.3).

``docs/actors.md`` draws these classes, and sends the message of figure 4. Quaternions are numbers:
rotations that can be multiplied, divided and mixed with reals. They are drjit's scalar quaternions,
with components i, j, k and then the real part (x, y, z, w). A vector is a quaternion whose real
part is 0; a rotation is one of length 1. Products combine rotations from the right: ``a * b`` turns
by b first, then by a.

A drjit quaternion can be written to (``q.x = 1``), and ``==`` compares component by component.
Therefore state is stored as a tuple (``components``), and every quaternion returned is a new one.

>>> i, j, k = (pure_quaternion(axis) for axis in (EAST, NORTH, UP))
>>> i * i, j * j, k * k, i * j * k
(-1, -1, -1, -1)
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from drjit.scalar import Quaternion4f64

from lod.actors.object_with_parts import ObjectWithParts, Route, ask, mutator, query
from lod.errors import InputError

Vector = tuple[float, float, float]
VectorLike = Sequence[float] | np.ndarray
Components = tuple[float, float, float, float]
"""i, j, k and the real part."""

Quaternion: TypeAlias = Quaternion4f64

EAST: Vector = (1.0, 0.0, 0.0)
NORTH: Vector = (0.0, 1.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
IDENTITY: Components = (0.0, 0.0, 0.0, 1.0)
"""Components of the rotation by 0: the number 1."""

_UNIT_WITHIN = 4e-16
"""Largest difference from 1 by which a rounded length counts as 1."""


def vector(values: VectorLike, where: str = "vector") -> Vector:
    """Return three finite numbers as a tuple. Raises InputError for anything else."""
    try:
        x, y, z = (float(value) for value in values)
    except (TypeError, ValueError):
        raise InputError(where, values, "three numbers") from None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise InputError(where, values, "three finite numbers")
    return x, y, z


def components(q: Quaternion) -> Components:
    """Return the components (x, y, z, w) as a tuple."""
    return q.x, q.y, q.z, q.w


def pure_quaternion(values: VectorLike) -> Quaternion:
    """Return a vector as a quaternion whose real part is 0 (§3.3)."""
    return Quaternion(*vector(values), 0.0)


def unit(q: Quaternion) -> Quaternion:
    """Scale ``q`` to length 1; return it unchanged where its length is 1 to rounding.

    Applied after every product, it prevents that errors of rounding add up. Raises InputError for
    0, NaN and infinity.
    """
    length = math.hypot(q.x, q.y, q.z, q.w)
    if abs(length - 1.0) <= _UNIT_WITHIN:
        return q
    if not (math.isfinite(length) and length > 0):
        raise InputError("quaternion", components(q), "finite and not 0: it stands for a rotation")
    return q / length


def rotation(axis: VectorLike, angle_deg: float) -> Quaternion:
    """Return the rotation by ``angle_deg`` about ``axis``, anticlockwise seen from its tip.

    Hamilton (reference 39 of the paper) gives the formula. Raises InputError for an axis of length
    0 or an angle that is not finite.
    """
    x, y, z = vector(axis, "axis")
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise InputError("axis", axis, "a direction, not 0", "try (0, 1, 0)")
    if not math.isfinite(angle_deg):
        raise InputError("angle", angle_deg, "finite")
    half = math.radians(angle_deg) / 2
    s = math.sin(half) / length
    return unit(Quaternion(x * s, y * s, z * s, math.cos(half)))


def rotate(q: Quaternion, values: VectorLike) -> Vector:
    """Rotate a vector by ``q``: q·v·q⁻¹, which keeps its length whatever the length of q."""
    turned = q * pure_quaternion(values) / q
    return turned.x, turned.y, turned.z


def angles_of(q: Quaternion) -> Vector:
    """Compute the angles about x, y and z of Rz·Ry·Rx [degrees], that about y within ±90."""
    about_x = math.atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y))
    about_y = math.asin(max(-1.0, min(1.0, 2 * (q.w * q.y - q.z * q.x))))
    about_z = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    return math.degrees(about_x), math.degrees(about_y), math.degrees(about_z)


def from_angles(angles_deg: VectorLike) -> Quaternion:
    """Return the rotation Rz·Ry·Rx by angles about x, y and z [degrees]: invert ``angles_of``."""
    half = np.radians(np.array(vector(angles_deg, "angles"))) / 2
    (sx, sy, sz), (cx, cy, cz) = np.sin(half).tolist(), np.cos(half).tolist()
    return Quaternion(
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    )


RotationLike = Quaternion | Sequence[float] | np.ndarray


@dataclass(frozen=True, init=False)
class JointLimits:
    """The limits of a joint: a box of angles about x, y and z, in Rz·Ry·Rx [degrees].

    The box of a hinge has an extent on one axis only; (0, 0, 0) need not lie inside. Raises
    InputError where a low limit exceeds the high one.
    """

    low_deg: Vector
    high_deg: Vector

    def __init__(self, low_deg: VectorLike, high_deg: VectorLike) -> None:
        low, high = vector(low_deg, "limits.low"), vector(high_deg, "limits.high")
        if any(a > b for a, b in zip(low, high, strict=True)):
            raise InputError("limits.low", low, f"at most the high limits, {high}, on every axis")
        object.__setattr__(self, "low_deg", low)
        object.__setattr__(self, "high_deg", high)

    def check(self, orientation: Quaternion) -> None:
        """Raise InputError unless the angles of an orientation lie in the box.

        The same turn has a second set of angles, and both come round every 360 degrees.
        """
        x, y, z = angles_of(orientation)
        nearest, least = (x, y, z), np.inf
        for angles in ((x, y, z), (x + 180, 180 - y, z + 180)):
            found, beyond = [], 0.0
            for low, angle, high in zip(self.low_deg, angles, self.high_deg, strict=True):
                middle = (low + high) / 2
                found.append(middle + (angle - middle + 180.0) % 360.0 - 180.0)
                beyond = max(beyond, low - found[-1], found[-1] - high)
            if beyond <= 1e-6:
                return
            if beyond < least:
                nearest, least = (found[0], found[1], found[2]), beyond
        rule = f"turned from {self.low_deg} to {self.high_deg} degrees about x, y and z"
        raise InputError("orientation", tuple(round(each, 2) for each in nearest), rule)


@dataclass(frozen=True, init=False)
class RevoluteJoint:
    """Position and orientation of a part in the frame of its whole, an immutable value.

    position  position of the part's origin, which is the centre of its rotation [m]
    turn      the orientation, from the part's frame to the whole's, as components x, y, z, w of
              length 1
    limits    the limits of the turn; None for a free joint
    """

    position: Vector
    turn: Components
    limits: JointLimits | None

    def __init__(
        self,
        position: VectorLike = (0.0, 0.0, 0.0),
        turn: RotationLike = IDENTITY,
        limits: JointLimits | None = None,
    ) -> None:
        """Take ``turn`` as a Quaternion or its components. Raises InputError beyond the limits."""
        object.__setattr__(self, "position", vector(position, "position"))
        object.__setattr__(self, "turn", _rotation_components(turn, "orientation"))
        object.__setattr__(self, "limits", limits)
        if limits:
            limits.check(self.orientation)

    @property
    def orientation(self) -> Quaternion:
        """Return the orientation as a new quaternion: changing it changes no joint."""
        return Quaternion(*self.turn)

    def with_position(self, position: VectorLike) -> "RevoluteJoint":
        """Return the joint with the same orientation at another position [m]."""
        return RevoluteJoint(position, self.turn, self.limits)

    def with_orientation(self, orientation: Quaternion) -> "RevoluteJoint":
        """Return the joint with another orientation. Raises InputError beyond the limits."""
        return RevoluteJoint(self.position, orientation, self.limits)

    def to_whole(self, point: VectorLike) -> Vector:
        """Transform a point from the frame of the part to that of its whole [m]."""
        x, y, z = rotate(self.orientation, point)
        return self.position[0] + x, self.position[1] + y, self.position[2] + z

    def compose(self, part: "RevoluteJoint") -> "RevoluteJoint":
        """Return a part's joint on this part in the frame of this part's whole, without limits."""
        turned = unit(self.orientation * part.orientation)
        return RevoluteJoint(self.to_whole(part.position), turned)


def _rotation_components(turn: RotationLike, where: str) -> Components:
    try:
        return components(unit(Quaternion(*(float(value) for value in turn))))
    except (TypeError, ValueError, RuntimeError):
        raise InputError(
            where, turn, "a quaternion, not 0: x, y, z, w", "try rotation(UP, 40)"
        ) from None


IDENTITY_JOINT = RevoluteJoint()
"""The joint with position 0 and no rotation: the frame of a whole that nothing owns."""


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
        self, joint: RevoluteJoint = IDENTITY_JOINT, appearance: Any = None, name: str | None = None
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
