"""Which worlds does the study ``full`` render, whole and pruned?

The ground is level and ends with the window, so that it is the same few triangles in both frames:
what differs is what stands on it. ``meadow`` repeats 8 people and 12 trees, nobody moving; of
``crowd`` only the people are left, each in a pose of its own. Whole frames hold every object's own
sticks either way, for Mitsuba 3.9.1 cannot instance in its JIT variants; a renderer that can would
hold those of ``meadow`` once, and some 3 kB for every object. Nothing of ``crowd`` could be shared.
"""

from dataclasses import dataclass, replace

from bench.fields.windows import Picture, window_preset
from lod.law.uneven_ground import max_ground_distance
from scenes.preset.tables import Preset
from scenes.world.view import view_at
from scenes.world.world import build_world


@dataclass(frozen=True)
class Kind:
    """A kind of world: a preset whose window grows.

    preset, settings  the preset, and what is changed in it
    worlds            mean objects of worlds that are rendered whole and pruned
    beyond            mean objects of worlds that are rendered pruned alone
    searched          mean objects of the world in which the detail of equal error is searched
    confirmed         mean objects of a larger world in which that detail's error is measured
    to_the_limit      whether the largest world that memory holds whole is rendered, too
    """

    preset: str
    settings: tuple[str, ...]
    worlds: tuple[float, ...]
    beyond: tuple[float, ...]
    searched: float
    confirmed: float
    to_the_limit: bool = True


KINDS = {
    "meadow": Kind("meadow", (), (300, 1e3, 3e3, 1e4), (1e6, 1e9, 1e12), 3e3, 1e4),
    "crowd": Kind(
        "crowd",
        ("species.tree.density=0",),
        (1e3, 1e4, 3e4, 1e5),
        (1e6, 1e12),
        1e4,
        3e4,
    ),
}
QUICK = {
    name: replace(
        kind,
        worlds=(30.0, 120.0),
        beyond=(),
        searched=30.0,
        confirmed=120.0,
        to_the_limit=False,
    )
    for name, kind in KINDS.items()
}
"""Tiny worlds that try the study in seconds; their numbers mean nothing."""


def world_preset(kind: Kind, objects: float, picture: Picture, detail: float | None) -> Preset:
    """Make a preset with a window of so many objects about the eye.

    ``detail`` is τ [px]; None leaves the world unpruned.
    """
    return window_preset(kind.preset, kind.settings, objects, picture, detail)


def limit_distance(kind: Kind, picture: Picture, detail: float) -> float:
    """Greatest distance [m] at which anything of the kind is displayed at a detail [px]."""
    preset = world_preset(kind, kind.worlds[0], picture, detail)
    world = build_world(preset)
    view = view_at(world, preset, 1)
    return max(
        max_ground_distance(each.prototypes.part_tables.hierarchies, view) for each in world.fields
    )
