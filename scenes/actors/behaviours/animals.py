"""What animals and windmills do: flee, herd, and turn into the wind."""

import math

import numpy as np

from lod.actors.message import ask, change
from scenes.actors.behaviour import Acts, Me
from scenes.actors.behaviours.steering import others_near, own_course, steer


def flee(me: Me) -> Acts:
    """Run from whoever comes near and is not of one's own kind; hop about otherwise.

    Options: sight, 6 [m]; speed, 3 [m/s]. Of one's kind is whose name begins as one's own does.
    """
    sight, speed = me.option("sight", 6.0), me.option("speed", 3.0)
    kind, rest, heading, now = me.name.partition("_")[0], 0.0, 0.0, 0.0
    while True:
        course = yield from own_course(me)
        others = yield from others_near(me, sight)
        wanted = np.zeros(2)
        for name, other in others:
            if not name.startswith(kind):
                away = np.array((course.x - other.x, course.y - other.y))
                wanted += away / max(float(away @ away), 0.01)
        if wanted.any():
            wanted *= speed / float(np.hypot(*wanted))
        elif now >= rest:
            rest, heading = now + me.rng.uniform(0.5, 3.0), me.rng.uniform(0, 2 * math.pi)
        elif heading > math.pi:
            wanted = 0.6 * np.array((math.cos(heading), math.sin(heading)))
        yield from steer(me, course, others, wanted)
        now = yield None


def herd(me: Me) -> Acts:
    """Keep with those of one's own kind: near their middle, and going as they go.

    Reynolds, "Flocks, herds, and schools" (SIGGRAPH 1987); that they do not run into each other is
    seen to as among people. Options: sight, 15 [m]; speed, 1.5 [m/s].
    """
    sight, speed = me.option("sight", 15.0), me.option("speed", 1.5)
    kind, heading = me.name.partition("_")[0], me.rng.uniform(0, 2 * math.pi)
    while True:
        course = yield from own_course(me)
        others = yield from others_near(me, sight)
        heading += me.rng.normal(0, 0.05)
        wanted = 0.5 * np.array((math.cos(heading), math.sin(heading)))
        kin = [other for name, other in others if name.startswith(kind)]
        if kin:
            middle = np.mean([(o.x, o.y) for o in kin], axis=0) - (course.x, course.y)
            along = np.mean([(o.vx, o.vy) for o in kin], axis=0)
            wanted = wanted + 0.15 * middle + 0.6 * along
        length = float(np.hypot(*wanted))
        yield from steer(me, course, others, wanted * min(1.0, speed / max(length, 1e-9)))
        yield None


def face_wind(me: Me) -> Acts:
    """Turn into the wind, as a windmill does. Option: rate, 20 [degrees/s]."""
    rate = me.option("rate", 20.0)
    while True:
        blown_to = yield ask("", "wind")
        heading = yield ask(me.name, "heading")
        off = (blown_to + 180.0 - heading + 180.0) % 360.0 - 180.0
        yield change(me.name, "go", 0.0, -min(max(3.0 * off, -rate), rate))
        yield None
