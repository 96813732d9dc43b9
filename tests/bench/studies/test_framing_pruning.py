"""Panoramas and stereo pairs at one pixel of detail against a quarter: what does pruning change?

One cut serves all directions of a panorama, and both eyes of a pair. Both pictures of a comparison
have the exposure of one of them and the curve of scenes.render.pictures, and are displayed
at 67 pixels per degree. Trees and people stand on flat ground, without grass, which nothing shows
at this size.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.images.compare import LEAST_PAIRS, mean_flip, one_sided_excess
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.scene import assemble_frame
from scenes.world.world import build_world

SCENE = (
    *("species.sward.density=0", "species.tree.prototypes=1", "species.figure.prototypes=2"),
    *("terrain.amplitude=0", "camera.height=3", "render.max_depth=2"),
)
FRAMINGS = {
    "panorama": ("camera.projection=panorama", "render.size=160x80", "render.spp=64"),
    "pair": ("camera.stereo=0.065", "render.size=64x48", "render.spp=100"),
}
BOUND = 0.5
"""The most that one pixel of detail may add to mean FLIP, as a share of the noise in it."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        variants.works(variants.JIT_VARIANT) is not True, reason="panoramas need a JIT variant"
    ),
]


@cache
def frame(framing, detail):
    chosen = load_preset("meadow", [*SCENE, *FRAMINGS[framing], f"view.detail={detail}"])
    return assemble_frame(build_world(chosen), chosen, 1, variants.JIT_VARIANT)


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


@pytest.mark.parametrize("framing", FRAMINGS)
def test_one_pixel_of_detail_adds_little_beside_the_noise_and_four_show(framing):
    tested, noise = ([flip(framing, each, k) for k in range(LEAST_PAIRS)] for each in (1, 0.25))
    excess = one_sided_excess(np.array(tested), np.array(noise))
    assert excess.high < BOUND * excess.floor
    assert flip(framing, 4, 0) - noise[0] > 2 * BOUND * excess.floor
