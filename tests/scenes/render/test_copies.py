"""Copies of models against the same objects flat: one picture, whatever shares its shapes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bench.counting import prototypes_of
from bench.methods import known_methods
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View, in_view
from scenes.field.species_field import Species, SpeciesField
from scenes.frame.frame_input import (
    FrameInput,
    Quality,
    display,
    display_copies,
)
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.description import describe_frame
from scenes.render.memory import forecast
from scenes.render.render import render_frame
from scenes.scene import Scene
from tests.scenes.field.brute_force import Waves
from tests.scenes.field.test_species_field import prototype_from

pytestmark = pytest.mark.skipif(
    variants.works(variants.JIT_VARIANT) is not True, reason="copies need a JIT variant"
)


def scene(name, objects, *more):
    more = "species.sward.density=0", *more
    density = sum(each.density for each in load_preset(name, more).species.values())
    side = math.sqrt(objects / density)
    keys = [f"world.extent={side!r}", f"terrain.reach={side!r}", "view.metric=full", *more]
    return Scene(load_preset(name, ["render.size=96x54", "render.spp=4", *keys]))


def copies_of(made):
    return [each.copies for each in made.displayed if each.copies is not None]


def assert_same_picture(copied, flat, differ=0.003):
    """Thin twigs round otherwise far from the origin: some few samples meet what is beside."""
    same = np.abs(copied.Z - flat.Z) < 1e-4 * flat.Z
    assert np.mean(~same) < differ
    for ids in ("object", "part", "level"):
        np.testing.assert_array_equal(getattr(copied, ids)[same], getattr(flat, ids)[same])
    off = np.linalg.norm(copied.N - flat.N, axis=-1)[same]
    assert np.mean(off > 5e-3) < differ
    np.testing.assert_allclose(copied.albedo[same], flat.albedo[same], atol=0.3)
    assert copied.rgb.mean() == pytest.approx(flat.rgb.mean(), rel=1e-3)


def test_a_whole_field_looks_the_same_as_copies_and_flat(make):
    """Models of sticks and of meshes on waves: hits, normals, guides, ids and shares by object."""
    sticks = (prototype_from(np.random.default_rng(seed)) for seed in (1, 2, 3))
    models = *sticks, *prototypes_of("sward", 8.0)
    field = SpeciesField(Species("thing", models, 0.1), 5, Waves(1.5), 40.0)
    camera = make.camera((96, 54), eye=(0.0, -12.0, 4.0))
    view = View(camera, METRICS["full"])
    fine = View(camera, METRICS["blake"], detail=1e-3)
    some = display_copies(field, fine, 25_000)  # pixels, of which 1 is a thousand times the detail
    assert 0 < len(np.unique(some.copies.object)) < len(np.unique(some.cut.object))
    pictures = []
    for one in (display_copies(field, view), some, display(field, prune(field, view), view)):
        quality = replace(make.quality(variants.JIT_VARIANT, 16), coverage=True)
        made = FrameInput(camera, (one, make.ground()), make.clear, make.light, quality)
        flat_shapes = {"mesh000"} if len(one.shape) == 0 else {"mesh000", "mesh001", "sticks000"}
        assert set(describe_frame(made)["shapes"]) == flat_shapes
        pictures.append(render_frame(made, 1))
    *copied, flat = pictures
    assert copied[0].statistics["copies"] > 100
    assert len(np.unique(flat.object)) > 30
    *shares, whole = (np.bincount(p.coverage.object, p.coverage.share) for p in pictures)
    for picture, share in zip(copied, shares, strict=True):
        assert_same_picture(picture, flat)
        np.testing.assert_allclose(share, whole, atol=1e-3 * whole.sum())


def test_what_is_nowhere_large_enough_has_no_copies(make):
    models = (prototype_from(np.random.default_rng(1)),)
    field = SpeciesField(Species("thing", models, 0.1), 5, Waves(1.5), 40.0)
    view = View(make.camera((96, 54), eye=(0.0, -12.0, 4.0)), METRICS["blake"])
    one, flat = display_copies(field, view, 1e6), display(field, prune(field, view), view)
    assert one.copies is None
    here = view.camera, make.clear, make.light, make.quality(variants.JIT_VARIANT, 4)
    pictures = [render_frame(FrameInput(here[0], (each,), *here[1:]), 1) for each in (one, flat)]
    np.testing.assert_array_equal(pictures[0].rgb, pictures[1].rgb)


def test_what_is_near_is_copied_and_the_rest_is_cut_as_ever(make):
    models = [prototype_from(np.random.default_rng(seed)) for seed in (1, 2, 3)]
    field = SpeciesField(Species("thing", tuple(models), 0.1), 5, Waves(1.5), 80.0)
    view = View(make.camera((96, 54), eye=(0.0, -12.0, 4.0)), METRICS["blake"], detail=0.5)
    cut, some = prune(field, view), display_copies(field, view, 160.0)
    wholes = field.prototypes.wholes(cut.parts.state, view)
    away = np.linalg.norm(wholes.position - view.camera.eye, axis=1)
    seen = in_view(view, wholes.centre, wholes.bound)
    pixels = 2 * wholes.bound / away / view.camera.pixel_angle
    near = pixels > 160 * view.detail * np.where(seen, 1, 4)
    assert 0 < near.sum() < np.count_nonzero(pixels > 160 * view.detail) < len(near)
    assert set(some.copies.object) == set(np.flatnonzero(near))
    kept = ~near[cut.object] | (cut.parent < 0)  # of what is near the wholes alone
    shown, expected = (np.stack((each.object, each.part)) for each in (some.cut, cut))
    assert {*map(tuple, shown.T)} == {*map(tuple, expected[:, kept].T)}
    assert some.shape.owner.max() < np.count_nonzero(~near[some.cut.object])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["full", "in_view"])
def test_methods_that_prune_nothing_draw_copies_of_what_stands_still(method, monkeypatch):
    """Trees and people on hills, as the presets have them."""
    here, pictures = scene("meadow", 100), []
    for shared in (True, False):
        monkeypatch.setattr(Quality, "draws_copies", property(lambda quality, _s=shared: _s))
        made = known_methods.METHODS[method].prepare(here, 0.0)(1, variants.JIT_VARIANT)
        assert bool(copies_of(made)) == shared
        pictures.append(render_frame(made, 1))
    assert pictures[0].statistics["copies"] > 10
    assert_same_picture(*pictures)


@pytest.mark.slow
def test_forecasts_count_the_sticks_of_prototypes_once():
    here = scene("meadow", 100_000)
    view = here.view(1)
    flat, shared = (forecast(here.world, view, from_size=from_size) for from_size in (0.0, 1.0))
    assert shared.copies == pytest.approx(100_000, rel=0.15)
    assert shared.sticks < flat.sticks / 100
