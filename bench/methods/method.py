"""What is a method of the comparison? One way to make frames of a world, with one knob."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from lod.pruner import cut_from_parts, prune
from lod.view import View
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, display
from scenes.scene import Scene

DETAILS_PX = (0.25, 0.5, 1.0, 2.0, 4.0)
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
    pruned: Callable[[View], View] = lambda view: view,
) -> FrameInput:
    """Make the input of a frame whose fields are thinned by ``shown``; all else is unpruned.

    ``pruned`` gives the view by whose metric the ground has its cover of what is not displayed:
    ``scenes.field.far_cover`` is no part of any method, and the same for all. A method that makes
    up for what it leaves out has none.
    """
    world, view = scene.world, scene.view(frame)
    rest = scene.with_world(replace(world, fields=())).input(frame, variant)
    mine = pruned(view)
    if mine is not view:
        tiles = prune(world.terrain, view).parts
        tiles = replace(tiles, state=replace(tiles.state, view=mine))
        ground = display(world.terrain, cut_from_parts(tiles, len(tiles), len(tiles)), mine)
        rest = replace(rest, displayed=(ground, *rest.displayed[1:]))
    fields = tuple(shown(each, view) for each in world.fields)
    return replace(rest, displayed=(*rest.displayed, *fields))


def by_view(change: Callable[[View, float], View]) -> Callable[[Scene, float], Updater]:
    """Return the ``prepare`` of a method that prunes fields in a view changed by its setting."""

    def prepare(scene: Scene, setting: float) -> Updater:
        def shown(field: SpeciesField, view: View) -> DisplayedRepresentation:
            mine = change(view, setting)
            return display(field, prune(field, mine), mine)

        return lambda frame, variant: frame_of(
            scene, frame, variant, shown, lambda view: change(view, setting)
        )

    return prepare
