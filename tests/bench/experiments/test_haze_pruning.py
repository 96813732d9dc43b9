"""Pruning that knows the haze makes no error of its own, where half of what is large is gone.

A picture 5.33° and 128 pixels wide has pixels as fine as one of 1590 across 60°. From 12 m up it
shows trees from 180 m to the horizon, V = 2 km. Displayed at 67 pixels per degree, with the
exposure of one blind picture and the curve of scenes.render.pictures.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.images.differences import FLOOR, LEAST_PAIRS, mean_flip, one_sided_excess
from lod.air import CLEAR
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.scene import Scene

OPEN_FIELD = (
    "species.figure.density=0",
    "species.sward.density=0",
    "species.tree.density=0.0006",
    "species.tree.prototypes=2",
    "terrain.amplitude=0",
    "air.visibility=2km",
    "camera.fov=5.33",
    "camera.heading=70",
    "camera.height=12",
    "camera.pitch=-1.4",
    "view.offscreen_detail=0.01",
    "render.size=128x96",
    "render.spp=144",
    "render.max_depth=2",
)
CUTS = {
    "aware": (),
    "blind": ("view.haze_aware=false",),
    "planted": ("view.haze_aware=false", "view.detail=2"),
}

pytestmark = pytest.mark.slow


@cache
def scene(cut):
    preset = load_preset("meadow", (*OPEN_FIELD, *CUTS[cut]))
    return Scene(preset) if cut == "blind" else scene("blind").with_preset(preset)


@cache
def frame(cut):
    from scenes.render.variants import choose

    return scene(cut).input(1, choose("auto"))


@cache
def rendered(cut, seed, clear=False):
    from scenes.render.render import render_frame

    made = frame(cut)
    air = CLEAR if clear else made.air
    quality = replace(made.quality, seed=seed)
    return render_frame(replace(made, air=air, quality=quality)).rgb


def displayed(cut, seed, clear=False):
    from scenes.render.pictures import auto_exposure, to_srgb_8bit

    exposure = auto_exposure(rendered("blind", 0, clear))
    return to_srgb_8bit(rendered(cut, seed, clear), exposure).astype(np.float32) / 255


def larger_than_1m(cut):
    (field,) = scene(cut).world.fields
    parts = prune(field, scene(cut).view(1)).parts
    P = np.concatenate([tree.P for tree in field.prototypes.part_tables.hierarchies])
    return int(np.count_nonzero(P[parts.part] > 1.0))


def excess_of(cut):
    pairs = [(2 * k, 2 * k + 1) for k in range(LEAST_PAIRS)]
    flips = [
        [mean_flip(displayed(each, a), displayed("blind", b)) for a, b in pairs]
        for each in (cut, "blind")
    ]
    tested, noise = np.array(flips)
    return one_sided_excess(tested, noise), noise.mean()


def test_the_detail_angle_is_the_same_and_more_than_half_of_the_large_parts_are_gone():
    angles = [scene(cut).view(1).m for cut in ("aware", "blind")]
    assert angles[0] == angles[1]
    assert larger_than_1m("aware") < 0.5 * larger_than_1m("blind")


def test_the_haze_aware_cut_stays_within_the_noise_and_twice_the_angle_does_not():
    (aware, floor), (planted, _) = excess_of("aware"), excess_of("planted")
    assert floor <= FLOOR
    assert aware.high < 0.1 * floor
    assert planted.low > floor


def test_in_clear_air_the_same_cut_would_show():
    """So what is gone was in the picture, and haze hid it: pictures with the same seed."""
    hazy, clear = (
        mean_flip(displayed("aware", 0, air), displayed("blind", 0, air)) for air in (False, True)
    )
    assert clear > 0.005
    assert hazy < clear / 50
