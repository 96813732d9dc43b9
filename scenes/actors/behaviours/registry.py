"""Behaviours by name: those that come with the program, and those of installed packages."""

from collections.abc import Callable, Iterator

from lod.errors import InputError
from scenes.actors.behaviour import Behaviour
from scenes.actors.behaviours.animals import face_wind, flee, herd
from scenes.actors.behaviours.cameras import chase, watch
from scenes.actors.behaviours.people import follow, walk
from scenes.plugins.entry_points import BEHAVIOUR, distribution, installed, load_entry

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
