"""Crowds of walkers and others for the study, and their scenes ready to act."""

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

from lod.actors.message import ask
from scenes.actors.acting import Acting
from scenes.actors.behaviour import Acts, Me
from scenes.actors.behaviours import BEHAVIOURS, walk
from scenes.actors.performance import Cast, Performance
from scenes.preset.load import preset_from
from scenes.preset.tables import Preset
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes
from scenes.world.world import make_terrain


class Troupe(NamedTuple):
    """Actors of a scene while they act, and as the pruner sees them."""

    acting: Acting
    cast: Cast


def walkers(
    count: int, side: float, frames: int, threshold: float, seed: int, waving: bool = False
) -> Preset:
    """Make a preset of walkers in a square, seen from 10 m south of it.

    waving  whether they wave as often as is shipped, or never
    """
    options = {"side": min(side, 40.0)} | ({} if waving else {"waves": 0.0})
    if side <= 40.0:
        options |= {"centre_x": 0.0, "centre_y": 0.0}
    troupe = {"model": "figure", "count": count, "side": side, "prototypes": 2}
    who = {"troupes": {"walker": troupe | {"behaviour": "walk", "options": options}}}
    return _in_a_square(who, side, frames, threshold, seed)


def by_behaviour(count: int, side: float, frames: int, seed: int) -> dict[str, Preset]:
    """Make presets of actors in a square, who do as is shipped: one of each behaviour of bodies.

    Two kinds of rabbits flee from each other, and of those who follow each follows the one before.
    """

    def troupe(model: str, behaviour: str, share: float = 1.0) -> dict[str, Any]:
        return {
            "model": model,
            "count": round(share * count),
            "side": side,
            "behaviour": behaviour,
        }

    leader = {"model": "figure", "behaviour": "walk", "options": {"side": side, "waves": 0.0}}
    across = math.ceil(math.sqrt(count))
    queue = {}
    for k in range(count):
        x, y = (side * (each / across - 0.5) for each in divmod(k, across))
        behind = {"behaviour": "follow", "options": {"whom": f"queue_{k - 1}"}} if k else {}
        queue[f"queue_{k}"] = leader | behind | {"position": (x, y)}
    hares = {name: troupe("rabbit", "flee", 0.5) for name in ("hare", "rabbit")}
    scenes: dict[str, Mapping[str, Any]] = {
        "follow": {"actors": queue},
        "flee": {"troupes": hares},
        "herd": {"troupes": {"ostrich": troupe("ostrich", "herd")}},
        "face_wind": {"troupes": {"mill": troupe("windmill", "face_wind")}},
    }
    made = {name: _in_a_square(who, side, frames, 0.0, seed) for name, who in scenes.items()}
    walking = {
        "walk without waving": walkers(count, side, frames, 0.0, seed),
        "walk": walkers(count, side, frames, 0.0, seed, waving=True),
    }
    return walking | made


def _in_a_square(
    who: Mapping[str, Any], side: float, frames: int, threshold: float, seed: int
) -> Preset:
    scene = {
        "seed": seed,
        "camera": {"position": (0.0, -side / 2 - 10.0), "height": 2.0},
        "terrain": {"amplitude": 0.0, "reach": 100.0},
        "acting": {"frames": frames, "threshold": threshold},
    }
    return preset_from(scene | dict(who))


def troupe_of(preset: Preset) -> Troupe:
    """Make the actors of a preset."""
    terrain, roles = make_terrain(preset), tuple(preset_roles(preset))
    acting = make_acting(preset, terrain, roles, role_prototypes(preset, roles))
    names = [each.name for each in roles]
    done = Performance(names, (), acting.act, preset.acting.frames)
    return Troupe(acting, make_cast(preset, terrain, done))


@contextmanager
def dearer(messages: int) -> Iterator[None]:
    """Have every walker ask itself so many more questions at each update, within."""

    def ponder(me: Me) -> Acts:
        walking, told = walk(me), None
        while True:
            for _ in range(messages):
                yield ask(me.name, "course")
            sent = walking.send(told)
            while sent is not None:
                sent = walking.send((yield sent))
            told = yield None

    BEHAVIOURS["walk"] = ponder if messages else walk
    try:
        yield
    finally:
        BEHAVIOURS["walk"] = walk
