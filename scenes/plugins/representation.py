"""What a package of others offers for a scene: how it is made, and from where it is looked at."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from lod.camera import Camera
from lod.errors import InputError
from lod.pruning.representation import Representation
from scenes.plugins.entry_points import REPRESENTATION, distribution, installed, load_entry
from scenes.terrain.ground import Ground


@runtime_checkable
class GroundedRepresentation(Representation, Protocol):
    """A representation that stands on the ground."""

    @property
    def top_m(self) -> float:
        """Height above the ground under it that nothing of it is above [m]."""


@dataclass(frozen=True, eq=False)
class RepresentationPlugin:
    """The value of an entry point of ``lodbench.representations``.

    about   one line, for `lodbench list`
    make    (name, seed, ground, **options) → a GroundedRepresentation of that name, the same
            for the same arguments; options are those of the preset's table, each with a default
    camera  where the suite of rules looks from: has some of it in view and some not, near enough
            that parts of parts are displayed
    detail  τ at which that camera displays some of its parts and not all [px]
    """

    about: str
    make: Callable[..., GroundedRepresentation]
    camera: Camera
    detail: float = 1.0


def plugin_by_name(name: str) -> RepresentationPlugin:
    """An installed offer. Raises InputError for an unknown one, and a broken one."""
    known = installed(REPRESENTATION)
    if name not in known:
        rule = f"one that is installed: {', '.join(known) or 'none is'}"
        raise InputError("representation", name, rule, "see `lodbench list`")
    found: RepresentationPlugin = load_entry(REPRESENTATION, name, RepresentationPlugin)
    return found


def make_representation(
    name: str, kind: str, seed: int, ground: Ground, options: dict[str, Any]
) -> GroundedRepresentation:
    """A representation as a preset asks for it. Raises InputError where it cannot be made."""
    offer = plugin_by_name(kind)
    where = f"representations.{name}"
    cure = f"see what {distribution(installed(REPRESENTATION)[kind])} says"
    try:
        made = offer.make(name, seed, ground, **options)
    except InputError:
        raise
    except Exception as error:  # whatever a stranger's code does
        rule = f"options that {kind} takes ({type(error).__name__}: {error})"
        raise InputError(where, options, rule, cure) from None
    if not isinstance(made, GroundedRepresentation) or made.name != name:
        rule = f"{kind} makes a representation called {name}, with a top_m"
        raise InputError(where, type(made).__name__, rule, cure)
    return made
