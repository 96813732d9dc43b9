"""From a preset to its live actors: bodies on a stage, with what they do."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from lod.actors.message import Refused
from lod.camera import GRID_M
from lod.errors import InputError
from scenes.actors.acting import Acting, Lens, Rules
from scenes.actors.behaviour import Me, Process, own_random_numbers
from scenes.actors.behaviours import behaviour_by_name
from scenes.actors.body import Body, CameraBody
from scenes.actors.performance import Cast, Eye, Performance
from scenes.actors.say import Line, check_action, cue, parse_words
from scenes.actors.stage import CAMERA, Stage
from scenes.ground.terrain import Terrain
from scenes.models.catalogue import model_prototypes
from scenes.presets.schema import Preset
from scenes.presets.things import ActorPreset
from scenes.rig.rigged_prototype import RiggedPrototype, rigged
from scenes.trees.species import Weather
from scenes.world.camera_path import camera_at, height_at, path_pose

_APART_M = 0.9
"""Least distance between the members of a troupe at the beginning [m]."""


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
