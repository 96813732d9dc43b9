"""The readings of the metric, everything, and culling alone, as arms.

Which arms are there? Those of this package, and those of other packages by entry point.

A package names its arms (``bench.methods.method.Arm``) in the group ``lodbench.arms``.
"""

from dataclasses import replace

import numpy as np

from bench.methods.discrete_levels import DISCRETE
from bench.methods.method import DETAILS_PX, Arm, Updater, by_view, engine_view, frame_of
from bench.methods.stochastic import STOCHASTIC
from lod.errors import InputError
from lod.metric import METRICS, Metric, full
from lod.view import View, in_view
from scenes.field.cells import candidates
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, display
from scenes.plugins import installed, load_entry
from scenes.presets.schema import Preset
from scenes.scene import assemble_frame, camera_between
from scenes.world.world import World

DISTANCES_M = (800.0, 400.0, 200.0, 100.0, 50.0)


def metric_arm(name: str, **more: float) -> Arm:
    """Return the arm of one reading of the metric, with everything that lodbench does beside it.

    ``more`` are other keys of the preset's table ``view``.
    """

    def prepare(world: World, preset: Preset, setting: float) -> Updater:
        view = preset.view.model_copy(update={"metric": name, "detail": setting, **more})
        pruned = preset.model_copy(update={"view": view})
        return lambda frame, variant: assemble_frame(world, pruned, frame, variant)

    about = METRICS[name].about
    return Arm(name, about, "Blake 1987, §2.4", "detail threshold τ [px]", DETAILS_PX, prepare)


CLIPPED = replace(
    metric_arm("blake", fade=0.0),
    name="clipped",
    about="blake, with parts that switch at once instead of fading",
)
"""The metric as the paper has it, for moving pictures; still ones hardly differ from ``blake``."""


def prepare_everything(world: World, preset: Preset, setting: float) -> Updater:
    """Keep everything. Where nothing moves the first frame's input is used again, camera aside."""
    if any(field.moves for field in world.fields):
        return lambda frame, variant: assemble_frame(world, preset, frame, variant)
    kept: list[FrameInput] = []

    def update(frame: int, variant: str) -> FrameInput:
        if not kept:
            kept.append(assemble_frame(world, preset, frame, variant))
        first = kept[0]
        camera = camera_between(world, preset, frame, first.camera.corner)
        return replace(first, camera=camera, seconds={})

    return update


def culled_beyond(view: View, distance_m: float) -> View:
    """Return a view in which everything nearer than a distance is displayed and nothing beyond."""

    def limit(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
        return np.full(np.broadcast_shapes(np.shape(P), np.shape(R)), distance_m)

    return replace(engine_view(view), metric=Metric("distance", limit, "culled by distance"))


def culled_out_of_view(view: View, setting: float) -> View:
    """Return a view in which all parts that reach into the pyramid of view are displayed.

    It finds the objects that ``IN_VIEW`` keeps, and foretells their memory, but for parts that lie
    outside though their object reaches in: few in a world much larger than its objects.
    """
    metric = Metric("in view", full, "culled by view", along_axis=True, finite=False)
    return replace(engine_view(view), metric=metric)


def display_in_view(field: SpeciesField, view: View) -> DisplayedRepresentation:
    """Display every part of the objects whose spheres reach into the pyramid of view.

    Objects are kept or dropped whole: for parts dropped one by one, leaf appearances of what owns
    them would stand in the picture, right before an eye that stands among trees.
    """
    pyramid, whole = culled_out_of_view(view, 0.0), engine_view(view)
    samples, examined = candidates(field.cells, pyramid, field.search_bounds(pyramid))
    grown = field.in_habitat(view.camera.corner, samples)
    roots = field.prototypes.wholes(field.instances_in_view(grown, whole), whole)
    kept = grown.take(in_view(pyramid, roots.centre, roots.bound))
    cut = field.prototypes.cut(field.instances_in_view(kept, whole), whole, examined)
    return display(field, cut, whole)


def prepare_in_view(world: World, preset: Preset, setting: float) -> Updater:
    """Cull the objects of every frame by its view."""
    return lambda frame, variant: frame_of(world, preset, frame, variant, display_in_view)


EVERYTHING = Arm(
    "full",
    "everything there is, built once where nothing moves",
    "no method",
    "none",
    (0.0,),
    prepare_everything,
    lambda view, setting: view,
)
DISTANCE = Arm(
    "distance",
    "whole detail up to a distance, nothing beyond",
    "distance culling",
    "distance [m]",
    DISTANCES_M,
    by_view(culled_beyond),
    culled_beyond,
)
IN_VIEW = Arm(
    "in_view",
    "whole objects that reach into the pyramid of view, no others",
    "view culling",
    "none",
    (0.0,),
    prepare_in_view,
    culled_out_of_view,
)


ARMS = "lodbench.arms"

OURS: dict[str, Arm] = {
    arm.name: arm
    for arm in (
        *map(metric_arm, ("blake", "bounded", "solid_angle", "depth")),
        EVERYTHING,
        DISCRETE,
        STOCHASTIC,
        DISTANCE,
        IN_VIEW,
    )
}
"""The arms of this package by name; ``full`` is what the others are compared with."""


def arms() -> dict[str, Arm]:
    """Return every arm by name, this package's first.

    Raises InputError for an installed arm that cannot be imported, and for one of a taken name.
    """
    found = dict(OURS)
    for name in installed(ARMS):
        if name in found:
            raise InputError(f"{ARMS} {name}", name, "a name that no arm has", "rename the arm")
        found[name] = load_entry(ARMS, name, Arm)
    return found
