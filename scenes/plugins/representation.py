"""Representations of other packages: what a package has to offer, and how one is made of it."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, runtime_checkable

from lod.camera import Camera
from lod.errors import InputError
from lod.pruner import Representation
from scenes.ground.relief import Ground
from scenes.plugins.entry_points import REPRESENTATION, distribution, installed, load_entry
from scenes.plugins.guard import StrangersError, guarded


@runtime_checkable
class GroundedRepresentation(Representation, Protocol):
    """A representation that stands on the ground."""

    @property
    def top_m(self) -> float:
        """Greatest height of anything of it above the ground below [m]."""


@dataclass(frozen=True, eq=False)
class RepresentationPlugin:
    """The value of an entry point of ``lodbench.representations``.

    about   one line about it, for `lodbench list`
    make    function (name, seed, ground, **options) → a GroundedRepresentation of that name, which
            is the same for the same arguments; options are the keys of the preset's table, and each
            has a default
    camera  camera of the conformance tests: some of the representation is in view and some is not,
            and it is near enough for parts of parts to be displayed
    detail  τ at which that camera displays some parts and not all [px]
    """

    about: str
    make: Callable[..., GroundedRepresentation]
    camera: Camera
    detail: float = 1.0


def plugin_by_name(name: str) -> RepresentationPlugin:
    """Find an installed plug-in; raises InputError for an unknown one and a broken one."""
    known = installed(REPRESENTATION)
    if name not in known:
        rule = f"one that is installed: {', '.join(known) or 'none is'}"
        raise InputError("representation", name, rule, "see `lodbench list`")
    found: RepresentationPlugin = load_entry(REPRESENTATION, name, RepresentationPlugin)
    return found


def make_representation(
    name: str, kind: str, seed: int, ground: Ground, options: dict[str, Any]
) -> GroundedRepresentation:
    """Make a representation as a preset asks for it; raises InputError where that fails."""
    plugin = plugin_by_name(kind)
    where = f"representations.{name}"
    cure = f"see what {distribution(installed(REPRESENTATION)[kind])} says"
    try:
        with guarded():
            made = plugin.make(name, seed, ground, **options)
    except StrangersError as error:
        if isinstance(error.__cause__, InputError):
            raise error.__cause__ from None
        rule = f"options that {kind} takes ({error})"
        raise InputError(where, options, rule, cure) from None
    if not isinstance(made, GroundedRepresentation) or made.name != name:
        rule = f"{kind} makes a representation called {name}, with a top_m"
        raise InputError(where, type(made).__name__, rule, cure)
    return made
