"""Which methods are there? Readings of the metric, baselines, and methods of other packages.

A package names its methods (``bench.methods.method.Method``) in the entry-point group
``lodbench.arms``.
"""

from dataclasses import replace
from functools import partial

import numpy as np

from bench.methods.discrete_levels import DISCRETE
from bench.methods.method import DETAILS_PX, Method, Updater, by_view, frame_of
from bench.methods.stochastic import STOCHASTIC
from lod.errors import InputError
from lod.metric import METRICS, Metric, full
from lod.view import View, in_view
from scenes.field.cells import candidates
from scenes.field.species_field import SpeciesField
from scenes.frame.frame_input import (
    DisplayedRepresentation,
    FrameInput,
    can_be_copied,
    display,
    display_copies,
)
from scenes.plugins import installed, load_entry
from scenes.scene import Scene, frame_quality

GROUP = "lodbench.arms"


def metric_method(name: str, bare: bool = False, **more: float | str) -> Method:
    """Return the method of one reading of the metric, with everything lodbench does beside it.

    What is large is not drawn whole, as copies of a model: no other method that simplifies has any.
    ``more`` are other keys of the preset's table ``view``. What is ``bare`` has no cover of the
    ground for what is not displayed, and its leaf appearances have their own albedo.
    """

    def prepare(scene: Scene, setting: float) -> Updater:
        keys = {"metric": name, "detail": setting, "copies": 0.0, **more}
        view = scene.preset.view.model_copy(update=keys)
        if bare:
            plain = tuple(replace(each, illumination=None) for each in scene.world.fields)
            ground = replace(scene.world.terrain, aggregate_cover=None)
            scene = scene.with_world(replace(scene.world, terrain=ground, fields=plain))
        return scene.with_preset(scene.preset.model_copy(update={"view": view})).input

    metric, knob = METRICS[name], "detail threshold τ [px]"
    settings = tuple(metric.finer * each for each in DETAILS_PX)
    return Method(name, metric.about, "Blake 1987, §2.4", knob, settings, prepare)


BARE = replace(
    metric_method(
        "blake", bare=True, offscreen_detail=1.0, fade=0.0, haze_aware=False, smear="off"
    ),
    name="bare",
    about="blake as the paper has it: one m all round, no air, fading, far cover or fitted tone",
)
"""The metric without all that the other methods are given, too."""


def _prepare_unpruned(scene: Scene, setting: float) -> Updater:
    """Where nothing moves the first frame's input is used again, camera aside."""
    if any(field.moves for field in scene.world.fields):
        return scene.input
    kept: list[FrameInput] = []

    def update(frame: int, variant: str) -> FrameInput:
        if not kept:
            kept.append(scene.input(frame, variant))
        camera = scene.camera(frame, kept[0].camera.corner)
        return replace(kept[0], camera=camera, seconds={})

    return update


def culled_beyond(view: View, distance_m: float) -> View:
    """Return a view in which everything nearer than a distance is displayed and nothing beyond."""

    def limit(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
        return np.full(np.broadcast_shapes(np.shape(P), np.shape(R)), distance_m * view.m / m)

    return replace(view, metric=Metric("distance", limit, "culled by distance"))


def _culled_out_of_view(view: View, setting: float) -> View:
    """Return a view in which all parts that reach into the pyramid of view are displayed.

    It finds the objects that ``in_view`` keeps, and estimates their memory, but for parts that lie
    outside though their object reaches in: few in a world much larger than its objects.
    """
    metric = Metric("in view", full, "culled by view", along_axis=True, finite=False)
    return replace(view, metric=metric)


def _display_in_view(field: SpeciesField, view: View, copies: bool) -> DisplayedRepresentation:
    """Display every part of the objects whose spheres reach into the pyramid of view.

    Objects are kept or dropped as a whole: for parts dropped one by one, leaf appearances of what
    owns them would stand in the picture, right before an eye that stands among trees.
    """
    pyramid = _culled_out_of_view(view, 0.0)
    samples, examined = candidates(field.cells, pyramid, field.search_bounds(pyramid))
    grown = field.in_habitat(view.camera.corner, samples)
    roots = field.prototypes.wholes(field.instances_in_view(grown, view), view)
    kept = grown.take(in_view(pyramid, roots.centre, roots.bound))
    if copies and can_be_copied(field, view):
        return display_copies(field, view, chosen=kept)
    cut = field.prototypes.cut(field.instances_in_view(kept, view), view, examined)
    return display(field, cut, view)


METHODS: dict[str, Method] = {
    method.name: method
    for method in (
        *map(metric_method, ("blake", "bounded", "solid_angle", "depth", "contrast_weighted")),
        BARE,
        Method(
            "full",
            "the unpruned reference, built once where nothing moves",
            "no method",
            "none",
            (0.0,),
            _prepare_unpruned,
            lambda view, setting: view,
        ),
        DISCRETE,
        STOCHASTIC,
        Method(
            "distance",
            "full detail up to a distance, nothing beyond",
            "distance culling",
            "distance [m]",
            (800.0, 400.0, 200.0, 100.0, 50.0),
            by_view(culled_beyond),
            culled_beyond,
        ),
        Method(
            "in_view",
            "all of the objects that reach into the pyramid of view, no others",
            "view culling",
            "none",
            (0.0,),
            lambda scene, setting: (
                lambda n, variant: frame_of(
                    *(scene, n, variant),
                    partial(
                        _display_in_view, copies=frame_quality(scene.preset, variant).draws_copies
                    ),
                )
            ),
            _culled_out_of_view,
        ),
    )
}
"""The methods of this package by name; ``full`` is what the others are compared with."""


def methods() -> dict[str, Method]:
    """Return every method by name, this package's first.

    Raises InputError for an installed one that cannot be imported, and for one of a taken name.
    """
    found = dict(METHODS)
    for name in installed(GROUP):
        if name in found:
            rule = "a name that no method has"
            raise InputError(f"{GROUP} {name}", name, rule, "rename the method")
        found[name] = load_entry(GROUP, name, Method)
    return found
