"""Panoramas and stereo pairs: counts by the law, and what one pixel of detail changes.

Fields of people that differ in their seed alone are pruned on flat ground: all round as a panorama,
and for two eyes, all round and in their field of view, near each other as a viewer's are and so far
apart that the baseline is much of D. Pictures at one pixel of detail are held against a quarter.

One cut serves all directions of a panorama, and both eyes of a pair. Both pictures of a comparison
have the exposure of one of them and the curve of scenes.render.pictures, and are displayed
at 67 pixels per degree. Trees and people stand on flat ground, without grass, which nothing shows
at this size.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.frame_counts import predict
from bench.images.differences import LEAST_PAIRS, mean_flip, one_sided_excess
from bench.statistics.estimates import LEAST_REPEATS, two_sided_mean
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.scene import Scene

COUNTED = (
    *("terrain.amplitude=0", "camera.height=1.6", "species.tree.density=0", "view.detail=12"),
    *("species.figure.density=0.3", "species.figure.prototypes=2", "render.size=1024x512"),
)
"""Keys of all fields: flat ground, and people enough for narrow intervals."""

WAYS = {
    "panorama": ("camera.projection=panorama", "view.detail=3"),
    "pair, 65 mm apart, all round": ("camera.stereo=0.065", "view.look_around=true"),
    "pair, 65 mm apart, in view": ("camera.stereo=0.065",),
    "pair, 10 m apart, all round": ("camera.stereo=10", "view.look_around=true"),
    "pair, 10 m apart, in view": ("camera.stereo=10",),
}


def over_law(keys, seed, baseline_m=None):
    """Objects and parts displayed ÷ predicted, of one field; by the law of another baseline."""
    scene = Scene(load_preset("crowd", [*COUNTED, *keys, f"seed={seed}"]))
    view = scene.view(1)
    law_view = view
    if baseline_m is not None:
        law_view = replace(view, camera=replace(view.camera, baseline_m=baseline_m))
    (field,) = scene.world.fields
    cut, law = prune(field, view), predict(field, law_view)
    displayed = np.array((cut.displayed_objects, cut.displayed_parts))
    return displayed / (field.species.density * np.array((law.objects, law.parts)))


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_every_framing_displays_as_many_as_the_law_says(way):
    ratios = np.array([over_law(WAYS[way], seed) for seed in range(LEAST_REPEATS)])
    for each in ratios.T:
        found = two_sided_mean(each)
        assert found.low < 1.005 and found.high > 0.995
        assert found.high - found.low < 0.1


def test_counts_of_another_law_are_found_out():
    """Held against the law of one eye, a pair 20 m apart displays too many."""
    keys = "camera.stereo=20", "view.look_around=true", "species.figure.density=0.1"
    assert over_law(keys, 0)[0] == pytest.approx(1, abs=0.05)
    assert over_law(keys, 0, baseline_m=0.0)[0] > 1.1


SCENE = (
    *("species.sward.density=0", "species.tree.prototypes=1", "species.figure.prototypes=2"),
    "species.tree.model=birch",  # whose leaves are drawn as they are counted
    *("terrain.amplitude=0", "camera.height=3", "render.max_depth=2"),
)
FRAMINGS = {
    "panorama": ("camera.projection=panorama", "render.size=160x80", "render.spp=64"),
    "pair": ("camera.stereo=0.065", "render.size=64x48", "render.spp=100"),
}
BOUND = 0.5
"""The most that one pixel of detail may add to mean FLIP, as a share of the noise in it."""


@cache
def frame(framing, detail):
    chosen = load_preset("meadow", [*SCENE, *FRAMINGS[framing], f"view.detail={detail}"])
    return Scene(chosen).input(1, variants.JIT_VARIANT)


@cache
def rendered(framing, detail, seed):
    """The picture, of a pair both, side by side."""
    from scenes.render.render import render_frame

    made = frame(framing, detail)
    layers = render_frame(replace(made, quality=replace(made.quality, seed=seed)))
    eyes = [layers, layers.right] if layers.right else [layers]
    return np.concatenate([each.rgb for each in eyes], axis=1)


def displayed(framing, detail, seed):
    from scenes.render.pictures import auto_exposure, to_srgb_8bit

    exposure = auto_exposure(rendered(framing, 0.25, 0))
    return to_srgb_8bit(rendered(framing, detail, seed), exposure).astype(np.float32) / 255


def flip(framing, detail, pair):
    seeds = 2 * pair, 2 * pair + 1
    return mean_flip(displayed(framing, detail, seeds[0]), displayed(framing, 0.25, seeds[1]))


@pytest.mark.slow
@pytest.mark.skipif(
    variants.works(variants.JIT_VARIANT) is not True, reason="panoramas need a JIT variant"
)
@pytest.mark.parametrize("framing", FRAMINGS)
def test_one_pixel_of_detail_adds_little_beside_the_noise_and_four_show(framing):
    tested, noise = ([flip(framing, each, k) for k in range(LEAST_PAIRS)] for each in (1, 0.25))
    excess = one_sided_excess(np.array(tested), np.array(noise))
    floor = np.mean(noise)
    assert excess.high < BOUND * floor
    assert flip(framing, 4, 0) - noise[0] > 2 * BOUND * floor
