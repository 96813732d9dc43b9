"""The behaviours that come with the program, how bodies steer, and behaviours by name.

Who walks keeps clear of all others by optimal reciprocal collision avoidance (ORCA: van den Berg,
Guy, Lin & Manocha, "Reciprocal n-body collision avoidance", Robotics Research, ISRR 2011). Every
other one leaves a half-plane of velocities, from which each of the two takes half of the change.
The best of what all leave is a linear program in two dimensions, solved line by line; where nothing
is left, the velocity is taken that violates the half-planes by the least.

ORCA wants a body that goes any way at once. One that goes only where it faces, and must turn first,
is given a wider berth, as in Alonso-Mora et al., "Optimal reciprocal collision avoidance for
multiple non-holonomic robots" (DARS 2010): ``BERTH_M`` on top of both radii.
"""

import math
from collections.abc import Callable, Generator, Iterator
from typing import Any

import numpy as np

from lod.actors.actor import Vector
from lod.actors.object_with_parts import Message, ask, change
from lod.errors import InputError
from lod.kernels import njit
from scenes.actors.acting import Acts, Behaviour, Me
from scenes.actors.body import Course
from scenes.plugins import BEHAVIOUR, distribution, installed, load_entry

_PARALLEL = 1e-9


@njit(cache=True)
def orca_velocity(own, wanted, others, horizon_s, step_s, fastest):  # type: ignore[no-untyped-def]
    """Compute the velocity to take [m/s].

    own      place and velocity; wanted: velocity that it would take by itself
    others   (k, 5) place [m], velocity [m/s], and distance to be kept to each [m]
    horizon_s  time for which it keeps clear; step_s: time to get clear of whom it overlaps
    fastest  greatest speed
    """
    x, y, vx, vy = own
    wx, wy = wanted
    n = len(others)
    lines = np.empty((n, 4))
    for k in range(n):
        px, py = others[k, 0] - x, others[k, 1] - y
        ux, uy, dx, dy = _half_plane(
            px, py, vx - others[k, 2], vy - others[k, 3], others[k, 4], horizon_s, step_s
        )
        lines[k, 0], lines[k, 1] = vx + 0.5 * ux, vy + 0.5 * uy
        lines[k, 2], lines[k, 3] = dx, dy
    failed, rx, ry = _program_2(lines, n, fastest, wx, wy, False)
    if failed < n:
        rx, ry = _program_3(lines, n, failed, fastest, rx, ry)
    return rx, ry


@njit(cache=True)
def _half_plane(px, py, vx, vy, radius, horizon, step):  # type: ignore[no-untyped-def]
    """Find the least change u of the relative velocity that avoids another, and the line's way."""
    square = px * px + py * py
    near = square <= radius * radius
    per_s = 1.0 / (step if near else horizon)
    wx, wy = vx - per_s * px, vy - per_s * py
    w = math.sqrt(wx * wx + wy * wy)
    along = wx * px + wy * py
    if near or (along < 0 and along * along > radius * radius * w * w):
        if w < 1e-12:
            wx, wy, w = -px, -py, max(math.sqrt(square), 1e-12)
            ex, ey, w = wx / w, wy / w, 0.0
        else:
            ex, ey = wx / w, wy / w
        shift = radius * per_s - w
        return shift * ex, shift * ey, ey, -ex
    leg = math.sqrt(square - radius * radius)
    if px * wy - py * wx > 0:
        dx, dy = (px * leg - py * radius) / square, (px * radius + py * leg) / square
    else:
        dx, dy = -(px * leg + py * radius) / square, -(-px * radius + py * leg) / square
    ahead = vx * dx + vy * dy
    return ahead * dx - vx, ahead * dy - vy, dx, dy


@njit(cache=True)
def _program_1(lines, k, radius, ox, oy, as_direction):  # type: ignore[no-untyped-def]
    """Find the best velocity on line k that the lines before it and the speed allow."""
    px, py, dx, dy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
    along = px * dx + py * dy
    inside = along * along + radius * radius - px * px - py * py
    if inside < 0:
        return False, 0.0, 0.0
    low, high = -along - math.sqrt(inside), -along + math.sqrt(inside)
    for i in range(k):
        cross = dx * lines[i, 3] - dy * lines[i, 2]
        over = lines[i, 2] * (py - lines[i, 1]) - lines[i, 3] * (px - lines[i, 0])
        if abs(cross) <= _PARALLEL:
            if over < 0:
                return False, 0.0, 0.0
            continue
        t = over / cross
        if cross >= 0:
            high = min(high, t)
        else:
            low = max(low, t)
        if low > high:
            return False, 0.0, 0.0
    if as_direction:
        t = high if ox * dx + oy * dy > 0 else low
    else:
        t = min(max(dx * (ox - px) + dy * (oy - py), low), high)
    return True, px + t * dx, py + t * dy


@njit(cache=True)
def _program_2(lines, n, radius, ox, oy, as_direction):  # type: ignore[no-untyped-def]
    """Find the velocity nearest to (ox, oy); the first line that leaves nothing, or n."""
    length = math.sqrt(ox * ox + oy * oy)
    rx, ry = ox, oy
    if as_direction or length > radius:
        rx, ry = ox * radius / max(length, 1e-12), oy * radius / max(length, 1e-12)
    for k in range(n):
        beyond = lines[k, 2] * (lines[k, 1] - ry) - lines[k, 3] * (lines[k, 0] - rx)
        if beyond > 0:
            found, x, y = _program_1(lines, k, radius, ox, oy, as_direction)
            if not found:
                return k, rx, ry
            rx, ry = x, y
    return n, rx, ry


@njit(cache=True)
def _program_3(lines, n, first, radius, rx, ry):  # type: ignore[no-untyped-def]
    """Find the velocity that violates the lines by the least, from the first that leaves none."""
    worst = 0.0
    for k in range(first, n):
        px, py, dx, dy = lines[k, 0], lines[k, 1], lines[k, 2], lines[k, 3]
        if dx * (py - ry) - dy * (px - rx) <= worst:
            continue
        between, m = np.empty((k, 4)), 0
        for i in range(k):
            cross = dx * lines[i, 3] - dy * lines[i, 2]
            if abs(cross) <= _PARALLEL:
                if dx * lines[i, 2] + dy * lines[i, 3] > 0:
                    continue
                between[m, 0], between[m, 1] = (px + lines[i, 0]) / 2, (py + lines[i, 1]) / 2
            else:
                over = lines[i, 2] * (py - lines[i, 1]) - lines[i, 3] * (px - lines[i, 0])
                between[m, 0], between[m, 1] = px + over / cross * dx, py + over / cross * dy
            ex, ey = lines[i, 2] - dx, lines[i, 3] - dy
            length = max(math.sqrt(ex * ex + ey * ey), 1e-12)
            between[m, 2], between[m, 3] = ex / length, ey / length
            m += 1
        failed, x, y = _program_2(between, m, radius, -dy, dx, True)
        if failed == m:
            rx, ry = x, y
        worst = dx * (py - ry) - dy * (px - rx)
    return rx, ry


BODY_M, BERTH_M = 0.2, 0.25
"""Radius of the upright cylinder round a body that no other's comes into, and the berth [m]."""

HORIZON_S, STEP_S = 2.0, 0.25

Steps = Generator[Message | None, Any, Any]


def others_near(me: Me, radius: float) -> Steps:
    """Ask who is near, and how the eight nearest go: (name, course) of each."""
    names = yield ask("", "near", me.name, radius)
    found = []
    for name in names[:8]:
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
    # Turn towards that velocity, and go as fast as it is along where one faces.
    speed = math.hypot(vx, vy)
    if speed < 0.02:
        yield change(me.name, "go", 0.0, 0.0)
        return
    aside = (math.atan2(vy, vx) - course.yaw + math.pi) % (2 * math.pi) - math.pi
    turn = min(max(math.degrees(aside) * 3.0, -150.0), 150.0)
    yield change(me.name, "go", speed * max(0.0, math.cos(aside)), turn)


_SIGHT_M = 4.0
_RAISED_S, _WAVE_S = 0.4, 1.8
_UPPER, _FORE = (-130.0, 0.0, 0.0), (0.0, -50.0, 0.0)


def walk(me: Me) -> Acts:
    """Walk from place to place in a square, step aside for others, and wave to some of them.

    Options: side of the square about where it begins [m], 20; speed, 1.3 [m/s]; waves, 0.1: share
    of those met that are waved to.
    """
    side, speed, waves = me.option("side", 20.0), me.option("speed", 1.3), me.option("waves", 0.1)
    course = yield ask(me.name, "course")
    home = np.array((course.x, course.y))
    if "centre_x" in me.options:
        home = np.array((me.option("centre_x", 0.0), me.option("centre_y", 0.0)))
    goal, met, waving, now = _some_place(me, home, side), set[str](), -1.0, 0.0
    pace = speed * me.rng.uniform(0.8, 1.1)
    while True:
        course = yield ask(me.name, "course")
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
        course = yield ask(me.name, "course")
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


def flee(me: Me) -> Acts:
    """Run from whoever comes near and is not of one's own kind; hop about otherwise.

    Options: sight, 6 [m]; speed, 3 [m/s]. Of one's kind is whose name begins as one's own does.
    """
    sight, speed = me.option("sight", 6.0), me.option("speed", 3.0)
    kind, rest, heading, now = me.name.partition("_")[0], 0.0, 0.0, 0.0
    while True:
        course = yield ask(me.name, "course")
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
        course = yield ask(me.name, "course")
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
    distance, height = me.option("distance", 6.0), me.option("height", 2.2)
    route = _route(me, "whom")
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
    east, north, up = (b - a for a, b in zip(eye, target, strict=True))
    pitch = math.atan2(up, math.hypot(east, north))
    return math.degrees(math.atan2(east, north)), math.degrees(pitch)


BEHAVIOURS: dict[str, Behaviour] = {
    each.__name__: each for each in (walk, follow, flee, herd, face_wind, watch, chase)
}


def behaviour_by_name(name: str, where: str) -> Behaviour:
    """Find a behaviour. Raises InputError for a name that none has."""
    if name in BEHAVIOURS:
        return BEHAVIOURS[name]
    if name not in installed(BEHAVIOUR):
        rule = f"one of {', '.join((*BEHAVIOURS, *installed(BEHAVIOUR)))}"
        raise InputError(where, name, rule, "see `lodbench list`")
    found: Behaviour = load_entry(BEHAVIOUR, name, Callable)  # type: ignore[arg-type]
    return found


def described_behaviours() -> Iterator[tuple[str, str]]:
    """Give the name of each behaviour and a line about it."""
    for name, behaviour in BEHAVIOURS.items():
        yield name, (behaviour.__doc__ or "").partition("\n")[0]
    for name, entry in installed(BEHAVIOUR).items():
        yield name, f"from {distribution(entry)}"
