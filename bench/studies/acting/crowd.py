"""Crowds of walkers for the study, and their scenes ready to act."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from lod.actors.message import ask
from scenes.actors.acting import Acting
from scenes.actors.behaviour import Acts, Me
from scenes.actors.behaviours.people import walk
from scenes.actors.behaviours.registry import BEHAVIOURS
from scenes.actors.cast import Cast
from scenes.actors.performance import Performance
from scenes.preset.load import preset_from
from scenes.preset.tables import Preset
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes
from scenes.world.world import make_terrain


class Troupe(NamedTuple):
    """Actors of a scene while they act, and as the pruner sees them."""

    acting: Acting
    cast: Cast


def walkers(count: int, side: float, frames: int, threshold: float, seed: int) -> Preset:
    """Make a preset of walkers in a square, seen from 10 m south of it."""
    options = {"side": min(side, 40.0), "waves": 0.0}
    if side <= 40.0:
        options |= {"centre_x": 0.0, "centre_y": 0.0}
    troupe = {"model": "figure", "count": count, "side": side, "prototypes": 2}
    return preset_from(
        {
            "seed": seed,
            "camera": {"position": (0.0, -side / 2 - 10.0), "height": 2.0},
            "terrain": {"amplitude": 0.0, "reach": 100.0},
            "troupes": {"walker": troupe | {"behaviour": "walk", "options": options}},
            "acting": {"frames": frames, "threshold": threshold},
        }
    )


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
