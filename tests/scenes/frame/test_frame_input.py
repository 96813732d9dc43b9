"""A preset becomes a frame's input: every representation cut, air and light as it says."""

import numpy as np
import pytest

from lod.air import CLEAR, haze_extinction
from scenes.presets.load import load_preset
from scenes.scene import Scene, frame_quality
from scenes.world.light import preset_air, sun_and_sky

SMALL = (
    "render.size=64x36",
    "camera.fps=10",
    'species={figure={model="figure", density=0.01, prototypes=1}}',
)


def test_at_the_visibility_two_per_cent_of_contrast_is_left_at_550_nm() -> None:
    air = preset_air(load_preset("meadow", ["air.visibility=20km"]))
    beta = haze_extinction(air, np.array([550.0]))[0]
    assert np.exp(-beta * 20_000) == pytest.approx(0.02, rel=1e-12)


def test_clear_air_is_clear() -> None:
    assert preset_air(load_preset("meadow", ["air.visibility=clear"])) == CLEAR


def test_light_and_quality_are_the_presets_own() -> None:
    keys = ["light.sun_azimuth=12", "light.sun_elevation=34", "light.turbidity=5"]
    preset = load_preset("meadow", [*keys, "render.spp=3", "render.max_depth=7", "seed=9"])
    light = sun_and_sky(preset)
    assert (light.sun_azimuth_deg, light.sun_elevation_deg, light.turbidity) == (12, 34, 5)
    quality = frame_quality(preset, "scalar_rgb")
    assert (quality.variant, quality.spp, quality.seed) == ("scalar_rgb", 3, 9)
    assert quality.max_depth == 7


def test_a_frame_holds_every_representation_once() -> None:
    preset = load_preset("meadow", SMALL)
    scene = Scene(preset)
    world = scene.world
    shot = scene.input(1, "scalar_rgb")
    assert [each.name for each in shot.displayed] == [each.name for each in world.representations]
    for each in shot.displayed:
        assert len(each.shape.owner)
        assert each.shape.owner.max() < len(each.cut)
        assert each.cut.part.max() < 2**32
    assert shot.quality.variant == "scalar_rgb"
    assert set(shot.seconds) == {"prune", "appearance"}
    assert (shot.camera.width, shot.camera.height) == (64, 36)


def test_the_same_frame_is_the_same_input_and_the_next_is_not() -> None:
    preset = load_preset("meadow", SMALL)
    one, two = (Scene(preset).input(3, "scalar_rgb") for _ in range(2))
    for first, second in zip(one.displayed, two.displayed, strict=True):
        assert np.array_equal(first.cut.parts.position, second.cut.parts.position)
        assert np.array_equal(first.shape.owner, second.shape.owner)
    after = Scene(preset).input(4, "scalar_rgb")
    step = after.camera.eye[:2] - one.camera.eye[:2]
    assert np.hypot(*step) == pytest.approx(preset.camera.speed / preset.camera.fps)
