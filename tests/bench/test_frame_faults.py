"""Faults planted in frames are named by the comparison with a run before; without one, none is.

Frames are rendered and measured as the bar measures places. Runs have samples of their own, so that
what is named is named beside the noise of rendering; but for one species that is too bright, which
has the samples of the run before, as runs have by default.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.compare_runs import drifts, problems
from bench.experiments.bar import EXPERIMENT
from bench.images import as_shipped as bar
from bench.images.differences import REFERENCE, TESTED, Looks, look
from bench.records.records import Point, columns, merge_points
from lod.shapes import Sticks, SticksAndTriangles
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import Scene
from tests.bench.edited import record_of

pytestmark = pytest.mark.slow

PLACES, LOOKS = 8, Looks((16, 64), 32)
WORDS = (
    *("render.size=64x36", "world.extent=60", "terrain.reach=60", "camera.height=3"),
    *('terrain.cover="grassy"', "terrain.finest=0.25"),
    *("species.tree.density=0", "species.figure.density=0.1"),
    'species.rabbit={model="rabbit", density=0.3, sizes=[3.0]}',
)
"""People among rabbits as tall as they are, in a small world."""


def scene_of(place, *words):
    own = (f"seed={901 + place}", f"camera.heading={45 * place}", *words)
    scene = Scene(load_preset("crowd", (*WORDS, *own)))
    plain = tuple(replace(each, illumination=None) for each in scene.world.fields)
    ground = replace(scene.world.terrain, aggregate_cover=None)  # which takes minutes to measure
    return scene.with_world(replace(scene.world, terrain=ground, fields=plain))


def seen(made, seed, *firsts):
    quality = replace(made.quality, seed=seed, spp=max(LOOKS.samples))
    edges = bar.band_edges(load_preset("crowd", WORDS))
    return look(replace(made, quality=quality), LOOKS, edges, *firsts)


@cache
def frames(place):
    """The frame of a place, and its reference, eight times as fine and without fades."""
    fine = "view.detail=0.25", "view.fade=0"
    return tuple(scene_of(place, *words).input(1, choose()) for words in (("view.detail=2",), fine))


@cache
def references(place, seed):
    return seen(frames(place)[1], seed, REFERENCE, TESTED)


def record(seed, plant=lambda made: made, swapped=False):
    """A run of all places: samples of a seed, a fault in what is tested, or pictures swapped."""
    points = []
    for place in range(PLACES):
        whole = references(place, seed)
        tested = seen(plant(frames(place)[0]), seed, TESTED)
        if swapped:
            whole, tested = replace(tested, pictures=tested.pictures * 2), whole
        compared = {"tested": tested.pictures[0], "floor": whole.pictures[1]}
        found = {"place": [place], "sticks": [tested.sticks], "triangles": [tested.triangles]}
        edges = bar.band_edges(load_preset("crowd", WORDS))
        samples = (
            *columns(found),
            *bar._flip_columns(LOOKS, compared, whole.pictures[0]),
            *bar._band_columns({"tested": tested, "reference": whole}, edges),
        )
        case = {"topic": "stills", "preset": "crowd", "sun": "in turn"}
        points.append(Point(case, samples=samples))
    return record_of(replace(EXPERIMENT, topics={}), merge_points(points))


@cache
def before():
    return record(0)


def changed(name, change):
    """A plant: a change of the sticks of one representation, or of all but the ground."""

    def of(shape):
        if isinstance(shape, SticksAndTriangles):
            return replace(shape, sticks=of(shape.sticks))
        return change(shape) if isinstance(shape, Sticks) else shape

    def plant(made):
        shown = [
            replace(each, shape=of(each.shape)) if k and name in (None, each.name) else each
            for k, each in enumerate(made.displayed)
        ]
        return replace(made, displayed=tuple(shown))

    return plant


def shifted(made):
    """The frame from a camera that is turned to the right by a tenth of a pixel."""
    camera = made.camera
    aside = 0.1 * camera.pixel_angle * np.cross(camera.forward, camera.up)
    forward = (camera.forward + aside) / np.linalg.norm(camera.forward + aside)
    return replace(made, camera=replace(camera, forward=forward))


FAULTS = {
    "swapped pictures": ({"swapped": True}, "sticks"),
    "one species 3 % too bright": (
        {"plant": changed("figure", lambda s: replace(s, tints=np.minimum(1.03 * s.tints, 1.0)))},
        "light",
    ),
    "coverage 3 % too small": (
        {
            "plant": changed(
                None,
                lambda s: replace(
                    s, start_radius=0.97 * s.start_radius, end_radius=0.97 * s.end_radius
                ),
            )
        },
        "rays",
    ),
    "a shift of a tenth of a pixel": ({"plant": shifted}, "flip_ppm"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_the_frames_is_named(fault):
    planted, quantity = FAULTS[fault]
    found = drifts(before(), record(0 if "species" in fault else 1, **planted))
    assert quantity in {each.quantity for each in found}, found


@pytest.mark.parametrize("seed", range(1, 6))
def test_nothing_is_named_where_nothing_is_planted(seed):
    after = record(seed)
    assert (problems(after), drifts(before(), after)) == ((), ())
