"""A small scene with live actors, for tests."""

from scenes.presets.load import preset_from
from scenes.scene import make_terrain
from scenes.world.cast import make_acting, make_cast, preset_roles, role_prototypes

JOE = {"model": "figure", "position": (0.0, 0.0), "heading": 180.0}
ANN = {"model": "figure", "position": (3.0, 1.0), "prototype": 2}


def preset(actors=None, script=(), acting=None, **tables):
    """A preset on flat ground, its camera 12 m to the south."""
    data = {
        "camera": {"position": (0.0, -12.0), "height": 1.7},
        "terrain": {"amplitude": 0.0, "reach": 100.0},
        "actors": actors if actors is not None else {"joe": JOE, "ann": ANN},
        "script": script,
        "acting": {"frames": 24} | (acting or {}),
    }
    return preset_from(data | tables)


def acting_of(chosen):
    """The scene of a preset, ready to act."""
    roles = tuple(preset_roles(chosen))
    return make_acting(chosen, make_terrain(chosen), roles, role_prototypes(chosen, roles))


def performance_of(chosen):
    """What the actors of a preset do."""
    return make_cast(chosen, make_terrain(chosen)).performance
