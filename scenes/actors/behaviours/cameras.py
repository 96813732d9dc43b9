"""What a camera does by itself: watch somebody, or follow."""

import math

from lod.actors.message import ask, change
from lod.actors.vectors import Vector
from scenes.actors.behaviour import Acts, Me


def watch(me: Me) -> Acts:
    """Keep to the preset's path, and face whom it is told to: a part, as joe right arm/hand.

    Options: whom; first, whom it faces in the beginning; over, how long its look then takes to pass
    from the one to the other [s].
    """
    route, over, now = _route(me, "whom"), me.option("over", 0.0), 0.0
    first = _route(me, "first") if "first" in me.options else route
    while True:
        mine, theirs = (yield ask(me.name, "where")), (yield ask(route, "where"))
        share = min(1.0, now / over) if over else 1.0
        if share < 1.0:
            before = yield ask(first, "where")
            passed = share * share * (3 - 2 * share)
            theirs = tuple(a + passed * (b - a) for a, b in zip(before, theirs, strict=True))
        yield change(me.name, "face", *_facing(mine, theirs))
        now = yield None


def chase(me: Me) -> Acts:
    """Go behind whom it is told to, and face that one.

    Options: whom; distance, 6 [m]; height, 2.2 [m].
    """
    route, distance, height = (
        _route(me, "whom"),
        me.option("distance", 6.0),
        me.option("height", 2.2),
    )
    while True:
        theirs = yield ask(route, "where")
        mine = yield ask(me.name, "where")
        east, north = mine[0] - theirs[0], mine[1] - theirs[1]
        away = max(math.hypot(east, north), 1e-6)
        share = distance / away
        place = theirs[0] + share * east, theirs[1] + share * north
        yield change(me.name, "stand", *place, height)
        mine = yield ask(me.name, "where")
        target = theirs[0], theirs[1], theirs[2] + 1.0
        yield change(me.name, "face", *_facing(mine, target))
        yield None


def _route(me: Me, option: str) -> tuple[str, ...]:
    who, _, part = me.text(option).partition(" ")
    return (who, *(name.strip() for name in part.split("/") if name.strip()))


def _facing(eye: Vector, target: Vector) -> tuple[float, float]:
    """Heading and pitch from an eye to a target [degrees]."""
    east, north, up = (b - a for a, b in zip(eye, target, strict=True))
    return math.degrees(math.atan2(east, north)), math.degrees(
        math.atan2(up, math.hypot(east, north))
    )
