"""How a body that goes only where it faces takes a velocity, keeping clear of the others.

ORCA wants a body that goes any way at once. One that must turn first is given a wider berth, as in
Alonso-Mora et al., "Optimal reciprocal collision avoidance for multiple non-holonomic robots" (DARS
2010): ``BERTH_M`` on top of both radii.
"""

import math
from collections.abc import Generator
from typing import Any

import numpy as np

from lod.actors.message import Message, ask, change
from scenes.actors.behaviour import Me
from scenes.actors.behaviours.orca import orca_velocity
from scenes.actors.body import Course

BODY_M = 0.2
"""Radius of the upright cylinder round a body that no other's comes into [m]."""

BERTH_M = 0.25
HORIZON_S, STEP_S = 2.0, 0.25
MOST_OTHERS = 8
"""The nearest that are heeded."""

_QUICKEST_TURN_DEG = 150.0

Steps = Generator[Message | None, Any, Any]


def own_course(me: Me) -> Steps:
    """Ask where one is oneself, and how one goes."""
    course: Course = yield ask(me.name, "course")
    return course


def others_near(me: Me, radius: float) -> Steps:
    """Ask who is near, and how the nearest go: (name, course) of each."""
    names = yield ask("", "near", me.name, radius)
    found = []
    for name in names[:MOST_OTHERS]:
        course: Course = yield ask(name, "course")
        found.append((name, course))
    return found


def steer(me: Me, course: Course, others: list[tuple[str, Course]], wanted: np.ndarray) -> Steps:
    """Take the velocity nearest to the wanted one (2,) [m/s] that keeps clear of these others."""
    radius = BODY_M if not me.options.get("radius") else me.option("radius", BODY_M)
    fastest = max(float(np.hypot(*wanted)), 0.3)
    rows = [(o.x, o.y, o.vx, o.vy, radius + BODY_M + BERTH_M) for _, o in others]
    table = np.array(rows).reshape(-1, 5)
    own = course.x, course.y, course.vx, course.vy
    goal = float(wanted[0]), float(wanted[1])
    vx, vy = orca_velocity(own, goal, table, HORIZON_S, STEP_S, fastest)
    yield from go_along(me, course, vx, vy)


def go_along(me: Me, course: Course, vx: float, vy: float) -> Steps:
    """Turn towards a velocity, and go as fast as it is along where one faces."""
    speed = math.hypot(vx, vy)
    if speed < 0.02:
        yield change(me.name, "go", 0.0, 0.0)
        return
    aside = (math.atan2(vy, vx) - course.yaw + math.pi) % (2 * math.pi) - math.pi
    turn = min(max(math.degrees(aside) * 3.0, -_QUICKEST_TURN_DEG), _QUICKEST_TURN_DEG)
    yield change(me.name, "go", speed * max(0.0, math.cos(aside)), turn)
