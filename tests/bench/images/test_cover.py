"""Each picture has its own bands, and the verdicts follow from the light there."""

from dataclasses import replace

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.cover import (
    LOOKS,
    Seen,
    Shot,
    cases,
    coverage,
    displayed,
    in_bands,
    land_light,
    pictures,
    preset_of,
    tone,
    whole,
    window_view,
    world_seed,
)
from bench.records.records import Point
from bench.seeds import BUILDING_SEEDS
from lod.air import rgb_extinction
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import in_view
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset
from scenes.scene import Scene
from scenes.sticks.prototype import LUMINANCE


def picture(Z, value):
    Z = np.array(Z)
    three, none = np.full((*Z.shape, 3), value), np.zeros(Z.shape)
    return Layers(three, Z, three, three, none, none, none)


def seen(layers, land=0.0):
    return Seen(layers, np.full(layers.Z.shape, land))


def test_light_is_summed_by_the_distances_of_each_picture():
    edges = 10.0, 20.0, 40.0
    unpruned = picture([[5, 10, 19], [20, 39, 1e10]], 0.5)
    tested = picture([[5, 15, 25], [25, 1e10, 39]], 0.25)
    found = in_bands(seen(tested, 0.1), seen(unpruned, 0.2), edges)
    point = Point({}, samples=found)

    def sums(quantity, which):
        return [point.column(quantity, picture=which, band=k)[0] for k in (0, 1)]

    assert sums("light", "whole") == [1_000_000, 1_000_000] and sums("rays", "whole") == [2, 2]
    assert sums("light", "pruned") == [250_000, 750_000] and sums("rays", "pruned") == [1, 3]
    assert sums("land", "pruned") == [100_000, 300_000]
    assert sums("land", "whole") == [400_000, 400_000]


def test_the_light_of_the_land_is_what_the_air_lets_through():
    """As dark as the extinction says at each distance; nothing of the sky is left."""
    air = Scene(load_preset("aerial")).air
    found = land_light(picture([[0.0, 1000.0, 1e10]], 0.5), air)
    through = np.exp(-1000 * rgb_extinction(air)) @ LUMINANCE
    assert found[0] == pytest.approx([0.5, 0.5 * through, 0.0], abs=1e-6)
    assert 0.4 < through < 0.8


def test_a_tree_that_stands_elsewhere_keeps_its_tone():
    """Half a picture of dark tree before bright sky, its gaps redrawn."""
    rng = np.random.default_rng(2)
    both = []
    for _ in range(2):
        tree = rng.random((50, 80)) < 0.5
        light = np.where(tree, 0.01, 0.1)[..., None].repeat(3, axis=2)
        both.append(replace(picture(np.where(tree, 30.0, 1e10), 0.0), rgb=light))
    found = in_bands(*map(seen, both), (10.0, 40.0))
    four = tuple(replace(each, values=each.values * 4) for each in found)
    point = Point(vars(pictures()[0]), samples=four)
    assert tone(point, 0).value == pytest.approx(1.0, abs=1e-6)
    assert coverage(point, 0).value == pytest.approx(1.0, abs=0.1)


def test_coordinates_are_about_the_window_where_leaves_shade_one_another():
    """And not about the eye, 5 km from there; what is in view is the same."""
    others = [f"species.{s}.density=0" for s in ("broadleaf", "birch", "shrub", "figure")]
    some = *others, "species.conifer.prototypes=1"
    scene = Scene(preset_of("far_5_km", "clear", 1, some))
    view, usual = window_view(scene), scene.view(1)
    assert view.camera.eye[:2] == pytest.approx([0.0, -5000.0])
    field = next(each for each in scene.world.fields if each.name == "conifer")
    one, two = (prune(field, replace(each, detail=0.2)).parts for each in (view, usual))
    assert len(one) > 1000 and abs(one.position).max() < 300 < abs(two.position).max()
    assert one.position - two.position == pytest.approx(
        np.tile(view.camera.eye - usual.camera.eye, (len(one), 1)), abs=1e-6
    )


def test_fields_that_are_judged_were_never_looked_at():
    topic = EXPERIMENT.topics["cover"]
    full = [world_seed(*c.args[1:], 0) for c in cases(**topic.sizes("full"))]
    quick = [world_seed(*c.args[1:], 4) for c in cases(**topic.sizes("quick"))]
    assert min(full) > BUILDING_SEEDS >= max(quick)


def test_the_whole_has_every_leaf_in_view_and_no_cover_is_bare_ground():
    """One kind of tree, few of them."""
    kept = ("species.shrub.density=0.0002",)
    others = [f"species.{s}.density=0" for s in ("broadleaf", "birch", "conifer", "figure")]
    case = Shot("aerial", "clear", 12.0, True)
    preset = preset_of(case.look, case.air, 1, (*kept, *others, "species.shrub.prototypes=1"))
    scene = Scene(preset)
    (ground, shrubs), (bare, _) = whole(scene, LOOKS[case.look]), displayed(scene, 48.0, False)
    view = replace(scene.view(1), metric=METRICS["full"])
    all_of_it = prune(scene.world.fields[0], view).parts
    in_it = in_view(view, all_of_it.centre, all_of_it.bound).sum()
    assert in_it > 5000 and len(shrubs.cut) > 0.98 * in_it and len(ground.shape) > 1000
    left = displayed(scene, 48.0, True)[0].shape.colours
    assert not np.array_equal(left, bare.shape.colours)
