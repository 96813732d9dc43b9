"""The air of a preset prunes as it paints; an eye looks only where a preset says so."""

import math

import numpy as np
import pytest

from lod.air import Air, Mist, least_extinction, rgb_extinction
from lod.eye import CONTRAST_CLASSES, Display, Eye
from lod.pruner import prune
from scenes.presets.load import load_preset, preset_names
from scenes.scene import Scene
from scenes.world.light import preset_air

FEW = (
    "species.sward.density=0",
    "species.tree.density=0",
    "species.figure.prototypes=2",
    "render.size=320x180",
)


def sight(*settings, frame=1):
    preset = load_preset("meadow", (*FEW, *settings))
    scene = Scene(preset)
    return scene.view(frame).conditions


def test_the_air_is_the_presets_own():
    keys = ["air.visibility=5km", "air.mist=300m", "air.mist_base=-4m", "air.mist_scale=20m"]
    assert preset_air(load_preset("meadow", keys)) == Air(5000.0, Mist(300.0, -4.0, 20.0))
    assert preset_air(load_preset("fly_in")) == Air()


def test_haze_alone_prunes_by_the_clearest_band_it_is_painted_in():
    found = sight("air.visibility=5km")
    assert not found.acuity
    painted = rgb_extinction(preset_air(load_preset("meadow", ["air.visibility=5km"])))
    assert found.extinction == painted.min() == painted[0]
    assert found.widths.effective == found.widths.pixel


@pytest.mark.parametrize("off", ["air.visibility=clear", "view.haze_aware=false"])
def test_clear_or_ignored_air_and_no_eye_are_nothing_at_all(off):
    assert sight(off) is None


def test_a_display_or_an_eye_means_that_someone_looks():
    display, eye = sight("display.pixels_per_degree=40"), sight("eye.signal_to_noise=4")
    assert display.acuity and eye.acuity
    assert (display.display, display.eye) == (Display(40.0), Eye())
    assert (eye.display, eye.eye) == (Display(), Eye(signal_to_noise=4.0))
    assert display.widths.eye > 0
    assert display.extinction > 0
    assert sight("eye={}", "view.haze_aware=false").extinction == 0


def test_seeing_widens_the_pixel():
    found = sight("air.visibility=clear", "air.seeing=60")
    assert found.widths.atmosphere == pytest.approx(math.radians(1 / 60))
    assert not found.acuity


def test_mist_counts_only_as_far_up_as_anything_reaches():
    """On flat ground the tallest thing decides; from high above, the mist is all but gone."""
    flat = ("terrain.amplitude=0", "air.visibility=5km", "air.mist=300m", "air.mist_scale=20m")
    preset = load_preset("meadow", (*FEW, *flat))
    scene = Scene(preset)
    world = scene.world
    top = world.top_m
    tall = max(
        t.hierarchy.position[0, 2] + t.hierarchy.B[0]
        for field in world.fields
        for t in field.prototypes.rigged
    )
    assert top == pytest.approx(tall)
    low = scene.view(1).conditions.extinction
    assert low == least_extinction(preset_air(preset), top)
    assert low > 1.5 * least_extinction(Air(5000.0))
    high = sight(*flat, "camera.height=2000").extinction
    assert high == pytest.approx(least_extinction(Air(5000.0)), rel=1e-9)


def test_nothing_reaches_above_the_top():
    preset = load_preset("zoo", ["render.size=160x90", "air.mist=1km", "species.tree.density=0"])
    scene = Scene(preset)
    world = scene.world
    for each in world.fields:
        parts = prune(each, scene.view(1)).parts
        assert (parts.centre[:, 2] <= world.top_m).all()


@pytest.mark.parametrize("name", [name for name, _ in preset_names()])
def test_presets_look_through_their_own_air_and_no_eye(name):
    preset = load_preset(name)
    assert preset.display is None
    assert preset.eye is None
    assert preset.view.haze_aware


def test_haze_takes_only_what_is_beyond_the_last_of_its_contrast():
    """V = 500 m: what is left is nearer than where its class is gone; clear cuts go further."""
    people = (*FEW, "species.figure.density=1e-3", "render.size=640x360", "air.visibility=500m")
    aware = load_preset("meadow", people)
    blind = load_preset("meadow", (*people, "view.haze_aware=false"))
    scene = Scene(aware)
    world = scene.world
    views = scene.view(1), scene.with_preset(blind).view(1)
    assert views[0].m == views[1].m
    (field,) = world.fields
    contrast = np.concatenate([tree.contrast for tree in field.prototypes.part_tables.hierarchies])
    gone = np.array(
        [views[0].conditions.weighted(c, 1.0).vanishing_distance for c in CONTRAST_CLASSES]
    )
    kept, left = (prune(field, view).parts for view in views)
    for parts in (kept, left):
        far = np.linalg.norm(parts.position - views[0].camera.eye, axis=1)
        within = far < gone[contrast[parts.part]]
        assert within.all() == (parts is kept)
    assert set(map(tuple, kept.position.tolist())) < set(map(tuple, left.position.tolist()))
