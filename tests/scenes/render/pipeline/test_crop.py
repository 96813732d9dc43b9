"""A crop is the same pixels as the whole frame's, to the last bit, in every driver and layer."""

from dataclasses import fields, replace

import numpy as np
import pytest

from lod.air import Air
from lod.camera import ThinLens
from scenes.frame.frame_input import FrameInput, Window
from scenes.render.render import render_frame

SIZE = 24, 14
WINDOW = Window(5, 3, 17, 12)


def frame(make, variant, window, **changes):
    """Balls on a ground in haze, in runs of which no border is a row's."""
    balls = make.balls([(x, 12.0, 1.0 + x / 5) for x in range(-4, 5, 2)], radius=0.8)
    camera = replace(make.camera(SIZE), lens=ThinLens(0.1, 8.0))
    quality = replace(
        make.quality(variant, spp=5), window=window, most_samples=5 * 100, coverage=True, **changes
    )
    after = make.camera(SIZE, heading=1.0)
    return render_frame(
        FrameInput(camera, (balls, make.ground()), Air(300.0), make.light, quality, after)
    )


def test_a_crop_is_the_same_pixels(make, variant):
    same_pixels(make, variant)


@pytest.mark.slow
def test_a_crop_is_the_same_pixels_in_a_medium(make, variant):
    same_pixels(make, variant, haze="medium", max_depth=4)


def same_pixels(make, variant, **changes):
    whole, crop = (frame(make, variant, window, **changes) for window in (None, WINDOW))
    rows, columns = slice(WINDOW.top, WINDOW.bottom), slice(WINDOW.left, WINDOW.right)
    layers = [
        each.name for each in fields(whole) if isinstance(getattr(whole, each.name), np.ndarray)
    ]
    assert {"rgb", "Z", "object", "motion", "albedo"} <= set(layers)
    for name in layers:
        np.testing.assert_array_equal(
            getattr(crop, name), getattr(whole, name)[rows, columns], err_msg=name
        )
    number = np.full(SIZE[::-1], -1)
    number[rows, columns] = np.arange(crop.Z.size).reshape(crop.Z.shape)
    at = number.ravel()[whole.coverage.pixel]
    np.testing.assert_array_equal(at[at >= 0], crop.coverage.pixel)
    np.testing.assert_array_equal(whole.coverage.object[at >= 0], crop.coverage.object)
    np.testing.assert_allclose(whole.coverage.share[at >= 0], crop.coverage.share)
