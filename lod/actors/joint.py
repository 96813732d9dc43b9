"""The revolute joint: position and orientation of a part on its whole (§3.1.1, §3.3)."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lod.actors.quaternion import (
    IDENTITY,
    Components,
    Quaternion,
    Vector,
    VectorLike,
    components,
    from_rotation_vector,
    rotate,
    rotation_vector,
    unit,
    vector,
)
from lod.errors import InputError

RotationLike = Quaternion | Sequence[float] | np.ndarray
_TOLERANCE_DEG = 1e-9


@dataclass(frozen=True, init=False)
class JointLimits:
    """The limits of a joint: a box of rotation vectors (axis times angle) from rest [degrees].

    The box of a hinge has an extent on one axis only; (0, 0, 0) need not lie inside.

    low_deg, high_deg  least and greatest components of the rotation vector [degrees]
    rest  orientation from which the turn is counted, about the axes of the part itself

    Raises InputError where a low limit exceeds the high one.
    """

    low_deg: Vector
    high_deg: Vector
    rest: Components

    def __init__(
        self, low_deg: VectorLike, high_deg: VectorLike, rest: RotationLike = IDENTITY
    ) -> None:
        low, high = vector(low_deg, "limits.low"), vector(high_deg, "limits.high")
        if any(a > b for a, b in zip(low, high, strict=True)):
            raise InputError("limits.low", low, f"at most the high limits, {high}, on every axis")
        object.__setattr__(self, "low_deg", low)
        object.__setattr__(self, "high_deg", high)
        object.__setattr__(self, "rest", _rotation_components(rest, "limits.rest"))

    def orientation(self, angles_deg: VectorLike) -> Quaternion:
        """Compute the orientation after the turn ``angles_deg`` from rest."""
        return unit(Quaternion(*self.rest) * from_rotation_vector(angles_deg))

    def contains(self, orientation: Quaternion) -> bool:
        """Tell whether the turn from rest lies in the box, the short way round or the long way."""
        short = rotation_vector(1 / Quaternion(*self.rest) * orientation)
        return self._holds(short) or self._holds(_long_way(short))

    def _holds(self, angles_deg: Vector) -> bool:
        slack = _TOLERANCE_DEG
        box = zip(self.low_deg, angles_deg, self.high_deg, strict=True)
        return all(low - slack <= angle <= high + slack for low, angle, high in box)


@dataclass(frozen=True, init=False)
class RevoluteJoint:
    """Position and orientation of a part in the frame of its whole, an immutable value.

    position  position of the part's origin, which is the centre of its rotation [m]
    turn      the orientation, from the part's frame to the whole's, as components x, y, z, w of
              length 1
    limits    the limits of the turn from rest; None for a free joint
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
        if limits and not limits.contains(self.orientation):
            angles = tuple(round(angle, 2) for angle in self.angles_deg)
            rule = f"turned from {limits.low_deg} to {limits.high_deg} degrees from rest"
            raise InputError("orientation", angles, rule)

    @property
    def orientation(self) -> Quaternion:
        """Return the orientation as a new quaternion: changing it changes no joint."""
        return Quaternion(*self.turn)

    @property
    def angles_deg(self) -> Vector:
        """Compute the turn from rest as a rotation vector [degrees], the short way round."""
        rest = Quaternion(*self.limits.rest) if self.limits else Quaternion(*IDENTITY)
        return rotation_vector(1 / rest * self.orientation)

    def with_position(self, position: VectorLike) -> "RevoluteJoint":
        """Return the joint with the same orientation at another position [m]."""
        return RevoluteJoint(position, self.turn, self.limits)

    def with_orientation(self, orientation: Quaternion) -> "RevoluteJoint":
        """Return the joint with another orientation. Raises InputError beyond the limits."""
        return RevoluteJoint(self.position, orientation, self.limits)

    def with_angles(self, angles_deg: VectorLike) -> "RevoluteJoint":
        """Return the joint turned by a rotation vector from rest [degrees].

        Raises InputError beyond the limits.
        """
        if self.limits is None:
            return self.with_orientation(from_rotation_vector(angles_deg))
        return self.with_orientation(self.limits.orientation(angles_deg))

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


def _long_way(short: Vector) -> Vector:
    angle = sum(value**2 for value in short) ** 0.5
    scale = 1 - 360 / angle if angle else 1.0
    return short[0] * scale, short[1] * scale, short[2] * scale


IDENTITY_JOINT = RevoluteJoint()
"""The joint with position 0 and no rotation: the frame of a whole that nothing owns."""
