"""The reference: air that is part of the scene, against the closed forms."""

from dataclasses import replace

import numpy as np
import pytest

from lod.air import CLEAR, Air, Mist
from lod.errors import InputError
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z
from scenes.frame.quality import Quality
from scenes.render.description.describe import describe_frame
from scenes.render.haze.haze import airlight_along, make_haze
from scenes.render.haze.scattered_layer import with_scattering_layer
from scenes.render.mitsuba import variants
from scenes.render.mitsuba.build import build_scene
from scenes.render.pipeline.render import render_frame

AIR = Air(2000.0)


def far_along(make, variant, heading, spp=2048):
    """What an endless level path shows, rendered and worked out, (3,) each."""
    camera = make.camera((4, 4), heading=heading, fov=0.001)
    quality = Quality(variant, spp, 1, 16, "medium")
    seen = render_frame(FrameInput(camera, (), AIR, make.light, quality)).rgb.mean(axis=(0, 1))
    variants.use(variant)
    built = build_scene(
        with_scattering_layer(describe_frame(replace(make.frame(), camera=camera)), AIR)
    )
    haze, endless = make_haze(built, AIR), np.array([np.inf])
    return seen, airlight_along(haze, camera.forward[None], endless)[0]


@pytest.mark.parametrize("heading", [20.0, 200.0])
def test_a_level_path_tends_to_the_scattered_airlight(make, variant, heading):
    """Away from the sun and towards it, all orders of scattering together."""
    seen, expected = far_along(make, variant, heading)
    assert np.allclose(seen, expected, rtol=0.03)


def test_the_medium_changes_colour_alone(make, variant):
    """Ids, depth and sky stay those of what is displayed: the box is no object."""
    scene = [make.balls([(x, 12.0, 1.5) for x in range(-8, 9, 4)], 1.5), make.ground(300.0)]
    camera = make.camera((32, 18))
    frames = [
        render_frame(
            FrameInput(camera, tuple(scene), AIR, make.light, Quality(variant, 4, 1, 4, haze))
        )
        for haze in ("analytic", "medium")
    ]
    plain, hazy = frames
    assert set(np.unique(hazy.object)) == set(np.unique(plain.object))
    assert (plain.object != hazy.object).mean() < 0.1
    assert (hazy.Z[hazy.object == 0] == SKY_Z).all()
    assert hazy.statistics["medium_top_m"] == 13 and hazy.statistics["medium_bottom_m"] == -1
    assert not np.array_equal(plain.rgb, hazy.rgb)
    assert plain.rgb.mean() == pytest.approx(hazy.rgb.mean(), rel=0.2)


def test_same_seed_same_bytes(make, variant):
    quality = Quality(variant, 4, 7, 4, "medium")
    one, two = (
        render_frame(FrameInput(make.camera(), (make.ground(),), AIR, make.light, quality))
        for _ in range(2)
    )
    assert np.array_equal(one.rgb, two.rgb)


@pytest.mark.parametrize("air", [CLEAR, Air(2000.0, Mist(500.0, 0.0, 10.0))])
def test_air_that_no_homogeneous_medium_is_like_is_refused(make, air):
    with pytest.raises(InputError, match="--haze"):
        render_frame(
            FrameInput(
                make.camera(), (), air, make.light, Quality(variants.SCALAR_VARIANT, haze="medium")
            )
        )


def test_no_such_haze():
    with pytest.raises(InputError, match="haze"):
        Quality(variants.SCALAR_VARIANT, haze="fog")
