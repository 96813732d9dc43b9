"""What is a method of the comparison? One way to make frames of a world, with one knob."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, display
from scenes.scene import Scene

DETAILS_PX = (0.5, 1.0, 2.0, 4.0, 8.0)
"""Detail thresholds that methods with one are tried at, from the finest [px]."""

Updater = Callable[[int, str], FrameInput]
"""A function from a frame's number, from 1, and a Mitsuba variant to the frame's input.

Frames are asked for in order. Where the input's ``displayed`` is the very object of the frame
before, nothing but the camera has changed, and the scene is not built again.
"""


@dataclass(frozen=True)
class Method:
    """One way to make frames, and how finely it can be set.

    name, about   what tables show
    source        where the method is published
    knob          what its setting means, with the unit
    settings      the settings that are tried, from the finest to the coarsest
    prepare       function from a scene and a setting to an ``Updater``, called once. The scene's
                  preset is unpruned (its metric is ``full``) and its world has an edge
    widest        function from the unpruned view and a setting to a view that displays at least
                  what the method does, from which its memory is estimated. None: small parts far
                  away are always left out, and nothing is estimated
    """

    name: str
    about: str
    source: str
    knob: str
    settings: tuple[float, ...]
    prepare: Callable[[Scene, float], Updater]
    widest: Callable[[View, float], View] | None = None


def frame_of(
    scene: Scene,
    frame: int,
    variant: str,
    shown: Callable[[SpeciesField, View], DisplayedRepresentation],
) -> FrameInput:
    """Make the input of a frame whose fields are thinned by ``shown``; all else is unpruned."""
    rest = scene.with_world(replace(scene.world, fields=())).input(frame, variant)
    view = scene.view(frame)
    fields = tuple(shown(each, view) for each in scene.world.fields)
    return replace(rest, displayed=(*rest.displayed, *fields))


def by_view(change: Callable[[View, float], View]) -> Callable[[Scene, float], Updater]:
    """Return the ``prepare`` of a method that prunes fields in a view changed by its setting."""

    def prepare(scene: Scene, setting: float) -> Updater:
        def shown(field: SpeciesField, view: View) -> DisplayedRepresentation:
            mine = change(view, setting)
            return display(field, prune(field, mine), mine)

        return lambda frame, variant: frame_of(scene, frame, variant, shown)

    return prepare


def engine_view(view: View) -> View:
    """Return the view without what only the paper's metric knows: air, eye, fading, off-screen."""
    return replace(view, conditions=None, fade=0.0, offscreen_detail=1.0)
