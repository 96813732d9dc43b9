"""The body of a live actor: a whole of limbs that moves over the ground (§3.1.1, §3.2).

A body goes where it faces: ``go`` gives it a speed and a rate of turning, which it keeps until the
next such message. Between messages it *coasts*; ``advance`` brings it up to a time. Its limbs
follow its walk until a message turns one; what a message turned is *held* until it is released.

Its place counts from the plane's origin, x east and y north, and from the ground below it. Limbs
answer for level ground; on slopes the pruner plants the feet (``scenes.rig.foot_placement``).

``docs/actors.md`` has an example.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from lod.actors.actor import EAST, UP, Components, PositionableObject, RevoluteJoint, rotation
from lod.actors.object_with_parts import (
    Message,
    Refusal,
    Refused,
    Route,
    ask,
    format_route,
    mutator,
    nearest_route,
    query,
)
from lod.errors import InputError
from scenes.actors.limb import (
    Limb,
    Pose,
    build_limbs,
    limb_routes,
    limb_tree,
    planted_phase,
    pose_at,
    step_at,
    with_share,
)
from scenes.actors.performance import Eye
from scenes.rig.rigged_prototype import RiggedPrototype

Guard = Callable[[Message], Message | str]
"""Looks at a message to a limb: gives it, or another of its kind, or says why it is refused."""

FASTEST = 40.0  # greatest speed of a body [m/s]

ACCELERATION, SPIN_ACCELERATION = 4.0, 12.0
"""How fast a body's speed [m/s²] and rate of turning [rad/s²] may change."""

_OF_ONE_LIMB = frozenset(
    ("joint", "position", "orientation", "held", "place", "orient", "turn", "bend", "release")
)
"""What limbs are asked for that does not depend on how those below them follow the walk."""

_Walk = tuple[float, int]
"""Phase of a walk, and eighths of it: what the pose of limbs that follow it depends on."""


class Posture(NamedTuple):
    """How a body stands at a time: its answer to the pruner, by which it is drawn.

    x, y    where it is [m]; yaw: where it faces, anticlockwise from x [rad]
    phase, stride_factor, eighths, cadence  of its walk (``scenes.actors.limb``)
    speed, spin  how it coasts from here [m/s, rad/s]
    went    when it was last told to go [s]
    held    rows of the joints that messages hold, with their orientations
    """

    x: float
    y: float
    yaw: float
    phase: float
    stride_factor: float
    eighths: int
    speed: float
    spin: float
    cadence: float
    went: float
    held: tuple[tuple[int, Components], ...] = ()


class Course(NamedTuple):
    """How a body moves: place [m], velocity [m/s], yaw [rad], rate of turning [rad/s].

    reach  how far it reaches from its place in the plan, as it stands [m]
    """

    x: float
    y: float
    vx: float
    vy: float
    yaw: float
    spin: float
    reach: float


class Body(Limb):
    """A live actor of a model, with a limb for each of its joints."""

    def __init__(
        self,
        name: str,
        prototype: RiggedPrototype,
        position: tuple[float, float] = (0.0, 0.0),
        heading_deg: float = 90.0,
    ) -> None:
        """Build the body at rest at a place [m]; its heading is clockwise from north [degrees]."""
        self._tree = limb_tree(prototype)
        here = RevoluteJoint((*position, 0.0), rotation(UP, 90.0 - heading_deg))
        super().__init__(build_limbs(prototype, self._tree), here, name=name)
        self._prototype, self._rows = prototype, limb_routes(self._tree)
        self._reach = reach_in_plan(prototype)
        self._time, self._phase, self._speed, self._spin = 0.0, 0.0, 0.0, 0.0
        self._went = -1.0
        self._settled: _Walk | None = None
        self._pose: tuple[_Walk, Pose] | None = None
        self._touched = frozenset[Route]()
        self._guard: Guard | None = None
        self._present = True

    @query
    def heading(self) -> float:
        """Return where it faces, clockwise from north [degrees], from 0 to 360."""
        return (90.0 - math.degrees(self._yaw)) % 360.0

    @query
    def course(self) -> Course:
        """Return where it is and how it moves."""
        (x, y, _), yaw = self._joint.position, self._yaw
        ahead = self._speed * math.cos(yaw), self._speed * math.sin(yaw)
        return Course(x, y, *ahead, yaw, self._spin, self._reach)

    @query
    def posture(self) -> Posture | None:
        """Return how it is to be drawn; None once it has left."""
        if not self._present:
            return None
        step = step_at(self._prototype.motion, self._speed)
        held: tuple[tuple[int, Components], ...] = ()
        if self._touched:
            touched = ((row, r) for r, row in self._rows.items() if r in self._touched)
            held = tuple(
                (row, turn)
                for row, route in touched
                for _, turn in self._ask_part(ask(route, "held", False))
            )
        x, y, _ = self._joint.position
        walk = self._phase, step.stride_factor, step.eighths
        coasts = self._speed, self._spin, step.cadence, self._went
        return Posture(x, y, self._yaw, *walk, *coasts, held)

    @mutator
    def advance(self, time_s: float) -> None:
        """Move along its course up to a time [s]: on an arc, as far as it goes till then."""
        dt, self._time = time_s - self._time, time_s
        if dt <= 0 or not self._present:
            return
        cadence = step_at(self._prototype.motion, self._speed).cadence
        self._phase = (self._phase + dt * cadence) % 1.0
        if self._speed == 0 and self._spin == 0:
            return
        (x, y, z), yaw = self._joint.position, self._yaw
        half = self._spin * dt / 2
        chord = self._speed * dt * (math.sin(half) / half if half else 1.0)
        place = x + chord * math.cos(yaw + half), y + chord * math.sin(yaw + half), z
        self._joint = RevoluteJoint(place, rotation(UP, math.degrees(yaw + 2 * half)))

    @mutator
    def go(self, speed: float, spin_deg: float = 0.0) -> None:
        """Go ahead at a speed [m/s], turning anticlockwise at a rate [degrees/s]; 0 is to stand.

        Speed and rate change by at most ACCELERATION and SPIN_ACCELERATION a second since it was
        last told to go: it comes as near to what is asked as it can.
        """
        if not (math.isfinite(speed) and 0 <= speed <= FASTEST and math.isfinite(spin_deg)):
            rule = f"a speed from 0 to {FASTEST:g} m/s, a finite turn"
            raise InputError("go", (speed, spin_deg), rule)
        since, self._went = self._time - self._went, self._time
        motion, before = self._prototype.motion, self._speed
        self._speed = _towards(self._speed, float(speed), ACCELERATION * since)
        self._spin = _towards(self._spin, math.radians(spin_deg), SPIN_ACCELERATION * since)
        if self._speed != before:
            steps = step_at(motion, before), step_at(motion, self._speed)
            self._phase = planted_phase(motion, self._phase, *steps)

    @mutator
    def release(self) -> None:
        """Follow the walk again with every limb."""
        super().release()
        self._touched, self._settled = frozenset(), None

    @mutator
    def leave(self) -> None:
        """Leave the scene, for good: nothing of it is displayed from now on."""
        self._present = False

    @mutator
    def guard(self, guard: Guard) -> None:
        """Have every message to a limb looked at on its way (§3.2)."""
        self._guard = guard

    def intercept(self, message: Message) -> Message | Refusal:
        """Complete the route, have the guard look, and bring the limbs up to date."""
        if not self._present:
            return self.refuse("has left")
        whole = Message(self._completed(message.route), message.action)
        passed = whole if self._guard is None else self._guard(whole)
        if isinstance(passed, str):
            return self.refuse(passed)
        self._settle(passed.route if passed.action.name in _OF_ONE_LIMB else None)
        if passed.action.changes:  # list the limbs that messages may hold from now on
            changed, self._settled = passed.route, None
            if passed.action.name == "release":
                kept = (each for each in self._touched if each[: len(changed)] != changed)
                self._touched = frozenset(kept)
            elif changed in self._rows:
                self._touched |= {changed}
        return passed

    @query
    def where(self, route: Route = ()) -> tuple[float, float, float]:
        """Return the origin of the limb at a route, in the scene, above the ground [m]."""
        full = self._completed(route)
        self._settle(full)
        return super().where(full)

    def _set_joint(self, joint: RevoluteJoint) -> None:
        """Stand elsewhere, or face another way; a body stands upright."""
        x, y = joint.turn[:2]
        if math.hypot(x, y) > 1e-9 or abs(joint.position[2]) > 1e-9:
            raise InputError("place", joint.position, "a body stands upright on the ground")
        self._joint = joint

    @property
    def _yaw(self) -> float:
        _, _, z, w = self._joint.turn
        return 2 * math.atan2(z, w)

    def _completed(self, route: Route) -> Route:
        """Find the limb that a route names in which limbs on the way may be left out.

        It is the one nearest to the body of those with the names of the route in their order.
        Raises Refused where there is none.
        """
        if not route or route in self._rows:
            return route
        found = [full for full in self._rows if full[-1] == route[-1] and _in_order(route, full)]
        if found:
            return min(found, key=len)
        known = "it has no parts at all"
        if self._rows:
            nearest = format_route(nearest_route(route, list(self._rows)))
            known = f"the nearest known route is {nearest!r}"
        raise Refused(str(self), f"has no part {format_route(route)!r}; {known}")

    def _settle(self, along: Route | None = None) -> None:
        """Have limbs follow the walk up to now, where no message holds them.

        along  route of those that are looked at; None = every limb
        """
        step = step_at(self._prototype.motion, self._speed)
        now = self._phase, step.eighths
        if now == self._settled:
            return
        if self._pose is None or self._pose[0] != now:
            rig = self._prototype.rig
            turns, shift = pose_at(with_share(self._prototype, step.eighths), self._phase)
            offset = rig.offset + shift * (rig.parent < 0)[:, None]
            pose = zip(map(tuple, offset.tolist()), map(tuple, turns.tolist()), strict=True)
            self._pose = now, tuple(pose)
        if along is None:
            self._settled = now
        self._follow_below(self._tree, self._pose[1], along)


@lru_cache(maxsize=256)
def reach_in_plan(prototype: RiggedPrototype) -> float:
    """Compute how far from the vertical through its place anything of a body at rest is [m]."""
    origin, turn = prototype.rig.frames()
    found = 0.0
    for table in prototype.full_detail_sticks():
        at, radius = table.posed(origin, turn).spheres
        found = max(found, float((np.hypot(at[:, 0], at[:, 1]) + radius).max(initial=0.0)))
    return found


def _towards(now: float, wanted: float, most: float) -> float:
    return now + min(max(wanted - now, -most), most)


def _in_order(names: Route, route: Route) -> bool:
    rest = iter(route)
    return all(name in rest for name in names)


class CameraBody(PositionableObject):
    """A camera on the preset's path; a message may put it elsewhere, turn it, or release it.

    Its eye is its origin; it looks along its own y, its own z upwards.
    """

    def __init__(self, on_path: Eye) -> None:
        super().__init__(name="camera")
        self._placed = self._faced = False
        self._stand(on_path)

    @query
    def eye(self) -> Eye:
        """Return where it is and where it looks."""
        return self._eye

    @query
    def moved(self) -> bool:
        """Tell whether messages have put it elsewhere than the preset has it."""
        return self._placed or self._faced

    @mutator
    def follow_path(self, on_path: Eye) -> None:
        """Go on along the preset's path, as far as no message has moved it."""
        now = self._eye
        place = (now if self._placed else on_path)[:3]
        self._stand(Eye(*place, *(now if self._faced else on_path)[3:]))

    @mutator
    def stand(self, x: float, y: float, height: float) -> None:
        """Stand at a place [m], so high above the ground [m]."""
        if height <= 0:
            raise InputError("camera.stand", height, "a height above 0 m")
        self._placed = True
        self._stand(Eye(float(x), float(y), float(height), *self._eye[3:]))

    @mutator
    def face(self, heading: float, pitch: float) -> None:
        """Look along a heading, clockwise from north, and a pitch above the horizon [degrees]."""
        if abs(pitch) > 90:
            raise InputError("camera.face", pitch, "a pitch within ±90 degrees")
        self._faced = True
        self._stand(Eye(*self._eye[:3], float(heading), float(pitch)))

    @mutator
    def release(self) -> None:
        """Go back to the preset's path, from the next frame on."""
        self._placed = self._faced = False

    def _stand(self, eye: Eye) -> None:
        turn = rotation(UP, -eye.heading) * rotation(EAST, eye.pitch)
        self._set_joint(RevoluteJoint(eye[:3], turn))
        self._eye = eye
