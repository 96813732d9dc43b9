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
    angles_of,
    components,
    rotate,
    unit,
    vector,
)
from lod.errors import InputError

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
