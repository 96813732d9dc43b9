"""From a preset to its live actors: bodies on a stage, with what they do.

Messages in words: ``joe right leg/lower leg/foot orient y 40deg`` and ``joe heading``.

First comes the name of an actor or ``camera``, then the route to a part, if it is a part that is
meant, then what is asked for, then numbers. Angles may end in ``deg``, lengths in ``m``, speeds in
``m/s``; an axis is x, y, z, or three numbers.

>>> parse_words("joe right leg/lower leg/foot orient y 40deg")
Words(who='joe', part='right leg/lower leg/foot', action='orient', arguments=('y', 40.0))
>>> parse_words("joe right arm/hand where").message(changes=False)
<ask joe/right arm/hand: where()>
"""

import re
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from lod.actors.actor import Quaternion, RevoluteJoint, Vector, components, rotation
from lod.actors.object_with_parts import Message, Refused, ask, change, parse_route
from lod.camera import GRID_M
from lod.errors import InputError
from scenes.actors.acting import Acting, Acts, Lens, Me, Process, Rules, own_random_numbers
from scenes.actors.behaviours import behaviour_by_name
from scenes.actors.body import Body, CameraBody
from scenes.actors.limb import Limb
from scenes.actors.performance import Cast, Eye, Performance
from scenes.actors.stage import CAMERA, Stage
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import model_prototypes
from scenes.presets.schema import ActorPreset, Preset
from scenes.rig.rigged_prototype import RiggedPrototype, rigged
from scenes.trees.species import Weather
from scenes.world.camera_path import camera_at, height_at, path_pose

_NUMBER = re.compile(r"([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)(deg|m/s|m|s|)")
_AXES: dict[str, Vector] = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}
_KINDS = (Body, Limb, CameraBody)
_INNER = {"advance", "follow", "follow_path", "set_appearance", "guard", "frames"}
"""What is no matter of words."""

EASES: dict[str, Callable[[float], float]] = {
    "linear": lambda share: share,
    "smooth": lambda share: share * share * (3 - 2 * share),
}
"""How a change goes on from its beginning, 0, to its end, 1."""


def _actions(changes: bool) -> frozenset[str]:
    names = {name for kind in _KINDS for name in dir(kind)} - _INNER
    return frozenset(
        name
        for name in names
        if any(getattr(getattr(kind, name, None), "changes", None) is changes for kind in _KINDS)
    )


QUESTIONS, CHANGES = _actions(changes=False), _actions(changes=True)


class Words(NamedTuple):
    """A message in words: who, the route to the part, what is asked for, and with what."""

    who: str
    part: str
    action: str
    arguments: tuple[str | float, ...]

    @property
    def route(self) -> tuple[str, ...]:
        """Return the route from the scene."""
        return (self.who, *parse_route(self.part))

    def message(self, changes: bool) -> Message:
        """Build the message that these words mean."""
        build = change if changes else ask
        return build(self.route, self.action, *_arguments(self))


class Line(NamedTuple):
    """A line of a script: when it begins [s], how long it takes [s], and how it goes on."""

    at: float
    words: Words
    over: float = 0.0
    ease: str = "smooth"


def parse_words(text: str, where: str = "--say") -> Words:
    """Read a message in words. Raises InputError for what is none."""
    words = text.split()
    known = QUESTIONS | CHANGES
    found = [k for k, word in enumerate(words) if k and word in known]
    if not found:
        rule = "WHO [ROUTE] ACTION [NUMBERS]"
        raise InputError(where, text, rule, f"actions are {', '.join(sorted(known))}")
    at = found[0]
    arguments = tuple(_argument(word, where) for word in words[at + 1 :])
    return Words(words[0], " ".join(words[1:at]), words[at], arguments)


def plain(answer: Any) -> Any:
    """Give an answer as plain data: a quaternion is the list of its components x, y, z, w."""
    if isinstance(answer, Quaternion):
        return list(components(answer))
    if isinstance(answer, RevoluteJoint):
        return {"position": list(answer.position), "orientation": list(answer.turn)}
    if isinstance(answer, tuple) and hasattr(answer, "_asdict"):
        return {name: plain(value) for name, value in answer._asdict().items()}
    if isinstance(answer, tuple | list):
        return [plain(each) for each in answer]
    return answer if isinstance(answer, int | float | str | bool | None) else repr(answer)


def check_action(words: Words, changes: bool, where: str) -> None:
    """Raise InputError where words ask a question and a change is wanted, or the other way."""
    if words.action not in (CHANGES if changes else QUESTIONS):
        rule = "a change, which gives no answer" if changes else "a question, which changes nothing"
        listed = ", ".join(sorted(CHANGES if changes else QUESTIONS))
        raise InputError(where, words.action, rule, f"one of {listed}")


def cue(line: Line) -> Acts:
    """Wait for the time of a line, and carry it out, a message a frame for as long as it takes."""
    now = 0.0
    while now < line.at - 1e-9:
        now = yield None
    words, route = line.words, line.words.route
    if words.action in ("orient", "turn"):
        yield from _turned(line, now)
    elif words.action == "go":
        message = words.message(changes=True)
        wanted, reached = float(message.action.arguments[0]), False
        while not reached:
            yield message
            course = yield ask(words.who, "course")
            reached = abs(float((course.vx**2 + course.vy**2) ** 0.5) - wanted) < 1e-9
            if not reached:
                yield None
    elif line.over:
        raise Refused("/".join(route), f"{words.action} takes no time: only orient and turn do")
    else:
        yield words.message(changes=True)


def _turned(line: Line, now: float) -> Acts:
    """Turn a part about an axis of its own (orient, figure 4) or of its whole (turn)."""
    *axis, angle = _arguments(line.words)
    before: Quaternion = yield ask(line.words.route, "orientation")
    begun, share = now, 0.0
    while share < 1.0:
        share = min(1.0, (now - begun) / line.over) if line.over else 1.0
        by = rotation(axis[0], EASES[line.ease](share) * angle)
        turned = before * by if line.words.action == "orient" else by * before
        yield change(line.words.route, "orient", turned)
        if share < 1.0:
            now = yield None


def _argument(word: str, where: str) -> str | float:
    if word in _AXES:
        return word
    match = _NUMBER.fullmatch(word)
    if match is None:
        raise InputError(where, word, "a number, as 40deg, 1.4m/s or 3m, or an axis x, y or z")
    return float(match[1])


def _arguments(words: Words) -> tuple[Any, ...]:
    """Give what the action takes: an axis is a vector, and so are the numbers of place and bend."""
    given = words.arguments
    if words.action in ("orient", "turn"):
        match given:
            case (str() as axis, float() as angle):
                return _AXES[axis], angle
            case (float() as x, float() as y, float() as z, float() as angle):
                return (x, y, z), angle
        rule = "an axis and an angle: x, y, z or three numbers, then degrees"
        raise InputError(words.action, " ".join(map(str, given)), rule, "try y 40deg")
    if any(isinstance(each, str) for each in given):
        rule = "numbers alone: only orient and turn take an axis"
        raise InputError(words.action, " ".join(map(str, given)), rule, "leave the axis out")
    if words.action == "place":
        if len(given) not in (2, 3):
            raise InputError("place", given, "two numbers: x and y [m]")
        return ((*given, 0.0)[:3],)
    return (given,) if words.action == "bend" else given


_APART_M = 0.9  # least distance between the members of a troupe at the beginning [m]


class Role(NamedTuple):
    """One actor as a preset has it."""

    name: str
    table: ActorPreset


def make_cast(preset: Preset, terrain: Terrain, performance: Performance | None = None) -> Cast:
    """Make the actors of a preset (``scenes.presets.load`` tells whether it has any).

    performance  what they do, where it is known already; otherwise they act when asked for it
    """
    roles = tuple(preset_roles(preset))
    prototypes = role_prototypes(preset, roles)
    if performance is None:
        acting = make_acting(preset, terrain, roles, prototypes)
        names = [each.name for each in roles]
        performance = Performance(names, (), acting.act, preset.acting.frames)
    return Cast(performance, prototypes, terrain, preset.camera.fps)


def answer_at(preset: Preset, words: str, frame: int) -> Any:
    """Ask a question in words as of a frame, and return the answer.

    Raises InputError where it is refused: who refused, why, and the nearest known route.
    """
    asked = parse_words(words, "ask")
    check_action(asked, False, "ask")
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    roles = tuple(preset_roles(preset))
    prototypes = role_prototypes(preset, roles)
    acting = make_acting(preset, terrain, roles, prototypes)
    for _ in range(frame):
        acting.act()
    try:
        return acting.stage.receive(asked.message(changes=False)).value
    except Refused as refused:
        raise InputError(words, refused.who, f"refuses: {refused.why}") from None


def make_acting(
    preset: Preset,
    terrain: Terrain,
    roles: tuple[Role, ...],
    prototypes: tuple[RiggedPrototype, ...],
) -> Acting:
    """Put the actors on a stage, with what each does by itself and what the script says."""

    def height(x: float, y: float) -> float:
        return height_at(terrain, x, y)

    def path(frame: float) -> Eye:
        pose, cell = path_pose(preset.camera, frame, terrain), preset.camera.cell
        x, y = pose.x + cell[0] * GRID_M, pose.y + cell[1] * GRID_M
        return Eye(x, y, pose.height, pose.heading, pose.pitch)

    bodies = {
        each.name: Body(each.name, prototype, each.table.position, each.table.heading)
        for each, prototype in zip(roles, prototypes, strict=True)
    }
    view = camera_at(preset.camera, preset.render.size, 1, terrain)
    eye = CameraBody(path(1))
    stage = Stage(bodies, eye, height, preset.wind.direction)
    half = float(np.arctan(np.hypot(*view.tan_half)))
    share = 1.0 if preset.view.look_around else preset.view.offscreen_detail
    lens = Lens(view.pixel_angle, half, share)
    rules = Rules(preset.acting.threshold, preset.acting.budget)
    processes = dict(_processes(preset, roles))
    cues = [Process(where, cue(line)) for where, line in _lines(preset)]
    return Acting(stage, prototypes, processes, cues, rules, lens, path, preset.camera.fps)


def preset_roles(preset: Preset) -> Iterator[Role]:
    """List every actor of a preset: its own, then its troupes'."""
    for name, table in preset.actors.items():
        if name == CAMERA:
            raise InputError(
                f"actors.{name}", name, "a name of its own", "the camera has that name"
            )
        yield Role(name, table)
    for name, troupe in preset.troupes.items():
        rng = own_random_numbers(preset.seed, name)
        places = _places(rng, troupe.count, troupe.side, f"troupes.{name}")
        for k, (x, y) in enumerate(places.tolist()):
            yield Role(
                f"{name}_{k + 1}",
                ActorPreset(
                    model=troupe.model,
                    model_sha256=troupe.model_sha256,
                    position=(troupe.centre[0] + x, troupe.centre[1] + y),
                    heading=float(rng.uniform(0, 360)),
                    prototype=k % troupe.prototypes + 1,
                    behaviour=troupe.behaviour,
                    options=troupe.options,
                ),
            )


def _places(rng: np.random.Generator, count: int, side: float, where: str) -> np.ndarray:
    across = int(np.ceil(np.sqrt(count)))
    pitch = side / across
    if pitch < _APART_M:
        need = _APART_M * across
        raise InputError(
            f"{where}.side", side, f"room for {count}, each {_APART_M} m apart", f"try {need:g}"
        )
    cells = rng.permutation(across**2)[:count]
    slack = pitch - _APART_M
    corner = np.column_stack(np.divmod(cells, across)) * pitch - side / 2
    places: np.ndarray = corner + pitch / 2 + rng.uniform(-slack / 2, slack / 2, (count, 2))
    return places


def role_prototypes(preset: Preset, roles: Sequence[Role]) -> tuple[RiggedPrototype, ...]:
    """Make the prototype of each actor; those of one model and size are made together."""
    weather = Weather(preset.world.season, preset.wind.speed)
    most: dict[tuple[str, float, str | None], int] = {}
    for _, table in roles:
        kind = table.model, table.size, table.model_sha256
        most[kind] = max(most.get(kind, 1), table.prototype)
    made = {
        (model, size, sha256): [
            rigged(each) for each in model_prototypes(model, n, (size,), True, weather, sha256)
        ]
        for (model, size, sha256), n in most.items()
    }
    kinds = ((table.model, table.size, table.model_sha256) for _, table in roles)
    return tuple(
        made[kind][each.table.prototype - 1] for kind, each in zip(kinds, roles, strict=True)
    )


def _processes(preset: Preset, roles: tuple[Role, ...]) -> Iterator[tuple[str, Process]]:
    shot = preset.camera
    acts = [
        (each.name, f"actors.{each.name}", each.table.behaviour, each.table.options)
        for each in roles
    ]
    acts.append((CAMERA, CAMERA, shot.behaviour, shot.options))
    for name, table, behaviour, options in acts:
        if behaviour:
            where = f"{table}.behaviour {behaviour}"
            found = behaviour_by_name(behaviour, f"{table}.behaviour")
            me = Me(name, own_random_numbers(preset.seed, name), options)
            yield name, Process(where, found(me))


def _lines(preset: Preset) -> Iterator[tuple[str, Line]]:
    for each in preset.script:
        where = f"{each.to} {each.do}"
        words = parse_words(f"{each.to} {each.do}", where)
        check_action(words, True, where)
        yield where, Line(each.at, words, each.over, each.ease)
