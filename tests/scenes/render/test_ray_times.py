"""Ways to trace a frame: the floor keeps the rays that are sent, and all ways see the same."""

from dataclasses import replace

import numpy as np
import pytest

from scenes.frame.frame_input import FrameInput
from scenes.render import variants
from scenes.render.description import describe_frame


def test_the_floor_sees_what_we_see_and_mitsuba_the_same_on_average(make):
    """The floor's picture is ours to the bit; Mitsuba's mean is within five standard errors."""
    variants.use(variants.JIT_VARIANT)
    from scenes.render.build import build_scene
    from scenes.render.light import emitters
    from scenes.render.ray_times import trace_times

    balls = make.balls([(-1.0, 6.0, 0.5), (1.0, 7.0, 0.5)], 0.5, 0.7)
    quality = replace(make.quality(variants.JIT_VARIANT, 64, max_depth=4), most_samples=2**14)
    shown = (balls, make.ground())
    made = FrameInput(make.camera((32, 16)), shown, make.clear, make.light, quality)
    described = describe_frame(made)
    built = build_scene(described, emitters(described["light"]))
    seen = {way: trace_times(built, quality, way)[1] for way in ("ours", "mitsuba", "floor")}
    np.testing.assert_array_equal(seen["floor"], seen["ours"])
    assert seen["ours"].shape == (32 * 16, 3) and seen["ours"].min() > 0
    apart = (seen["mitsuba"] - seen["ours"]).mean(axis=1)
    error = apart.std(ddof=1) / np.sqrt(apart.size)
    assert 0 < error < 0.01 * seen["ours"].mean()
    assert apart.mean() == pytest.approx(0.0, abs=5 * error)
