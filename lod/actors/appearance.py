"""The stick: the usual appearance of an actor (§2.3, §3.1.1)."""

import math
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

from lod.actors.joint import RevoluteJoint
from lod.actors.quaternion import vector
from lod.actors.vectors import Vector, VectorLike
from lod.errors import InputError


@dataclass(frozen=True, init=False)
class ConeStick:
    """A round cone with round ends, in the frame of the part that looks so.

    start, end                centres of the two spheres [m]
    start_radius, end_radius  above 0 [m]
    albedo                    linear Rec.709, 0 to 1
    """

    start: Vector
    end: Vector
    start_radius: float
    end_radius: float
    albedo: Vector

    def __init__(
        self,
        start: VectorLike,
        end: VectorLike,
        start_radius: float,
        end_radius: float,
        albedo: VectorLike = (0.5, 0.5, 0.5),
    ) -> None:
        for name, values in {"start": start, "end": end, "albedo": albedo}.items():
            object.__setattr__(self, name, vector(values, f"stick.{name}"))
        for name, radius in {"start_radius": start_radius, "end_radius": end_radius}.items():
            if not (math.isfinite(radius) and radius > 0):
                raise InputError(f"stick.{name}", radius, "a radius above 0 m")
            object.__setattr__(self, name, float(radius))
        if not all(0 <= share <= 1 for share in self.albedo):
            raise InputError("stick.albedo", self.albedo, "three shares, 0 to 1")

    def sticks_in(self, frame: RevoluteJoint) -> tuple["ConeStick", ...]:
        """Return this stick in the frame that ``frame``, the joint of its part, is given in."""
        ends = frame.to_whole(self.start), frame.to_whole(self.end)
        return (replace(self, start=ends[0], end=ends[1]),)


@dataclass(frozen=True)
class StickBundle:
    """Several sticks as one appearance, which may be none at all."""

    sticks: tuple[ConeStick, ...] = ()

    def sticks_in(self, frame: RevoluteJoint) -> tuple[ConeStick, ...]:
        """Return all of its sticks in the frame that ``frame`` is given in, in their order."""
        return tuple(
            with_position for stick in self.sticks for with_position in stick.sticks_in(frame)
        )


@runtime_checkable
class Appearance(Protocol):
    """What fills the appearance slot of an actor: a value that gives its sticks in any frame."""

    def sticks_in(self, frame: RevoluteJoint) -> tuple[ConeStick, ...]:
        """Return its sticks in the frame that ``frame`` is given in."""


NO_STICKS = StickBundle()
