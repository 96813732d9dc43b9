"""What people do: walk about, step aside for each other, wave, and follow whom they belong to."""

import math

import numpy as np

from lod.actors.message import ask, change
from scenes.actors.behaviour import Acts, Me
from scenes.actors.behaviours.steering import Steps, others_near, own_course, steer

_SIGHT_M = 4.0
_RAISED_S, _WAVE_S = 0.4, 1.8
_UPPER, _FORE = (-130.0, 0.0, 0.0), (0.0, -50.0, 0.0)


def walk(me: Me) -> Acts:
    """Walk from place to place in a square, step aside for others, and wave to some of them.

    Options: side of the square about where it begins [m], 20; speed, 1.3 [m/s]; waves, 0.1: share
    of those met that are waved to.
    """
    side, speed, waves = me.option("side", 20.0), me.option("speed", 1.3), me.option("waves", 0.1)
    course = yield from own_course(me)
    home = np.array((course.x, course.y))
    if "centre_x" in me.options:
        home = np.array((me.option("centre_x", 0.0), me.option("centre_y", 0.0)))
    goal, met, waving, now = _some_place(me, home, side), set[str](), -1.0, 0.0
    pace = speed * me.rng.uniform(0.8, 1.1)
    while True:
        course = yield from own_course(me)
        others = yield from others_near(me, _SIGHT_M)
        way = goal - (course.x, course.y)
        left = float(np.hypot(*way))
        if left < 1.0:
            goal = _some_place(me, home, side)
        yield from steer(me, course, others, way / max(left, 1e-9) * pace)
        names = {name for name, _ in others}
        if waving < 0 and any(me.rng.random() < waves for _ in sorted(names - met)):
            waving = now
        met = names
        if waving >= 0:
            waving = yield from _wave(me, now, waving)
        now = yield None


def follow(me: Me) -> Acts:
    """Follow another, a step behind, and step aside for everyone else.

    Options: whom, the other's name; distance, 0.8 [m]; speed at most, 2.0 [m/s].
    """
    whom, distance, most = me.text("whom"), me.option("distance", 0.8), me.option("speed", 2.0)
    while True:
        course = yield from own_course(me)
        leader = yield ask(whom, "course")
        others = yield from others_near(me, _SIGHT_M)
        behind = np.array((math.cos(leader.yaw), math.sin(leader.yaw))) * -distance
        way = np.array((leader.x, leader.y)) + behind - (course.x, course.y)
        wanted = np.array((leader.vx, leader.vy)) + 0.8 * way
        length = float(np.hypot(*wanted))
        yield from steer(me, course, others, wanted * min(1.0, most / max(length, 1e-9)))
        yield None


def _some_place(me: Me, home: np.ndarray, side: float) -> np.ndarray:
    place: np.ndarray = home + me.rng.uniform(-side / 2, side / 2, 2)
    return place


def _wave(me: Me, now: float, since: float) -> Steps:
    """Wave with the right hand for a while; gives since when, or −1 once the arm is let go."""
    arm, fore = (me.name, "right arm"), (me.name, "right arm", "forearm")
    if now - since > _WAVE_S:
        yield change(arm, "release")
        return -1.0
    up = min(1.0, (now - since) / _RAISED_S, (_WAVE_S - now + since) / _RAISED_S)
    swing = 25.0 * math.sin(8.0 * (now - since)) * up
    yield change(arm, "bend", tuple(up * angle for angle in _UPPER))
    yield change(fore, "bend", (0.0, _FORE[1] * up - abs(swing), swing))
    return since
