"""Frames that follow each other: one set of compiled kernels, and nothing that another one left."""

import numpy as np
import pytest

from lod.shapes import Sticks
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput
from scenes.render import variants
from scenes.render.render import build_frame, render_frame, trace

TINTS = np.array([[0.5, 0.2, 0.1], [0.1, 0.5, 0.2], [0.2, 0.1, 0.5]])


@pytest.fixture
def jit():
    answer = variants.works(variants.JIT_VARIANT)
    if answer is not True:
        pytest.skip(f"no JIT variant works here: {answer}")
    variants.use(variants.JIT_VARIANT)
    return variants.JIT_VARIANT


def clump(make, counts, at=(0.0, 8.0, 1.0)):
    """So many sticks of each tint; one object and part each."""
    n, tint = sum(counts), np.repeat(np.arange(len(counts)), counts)
    balls = make.balls(np.asarray(at) + np.random.default_rng(n).uniform(-2, 2, (n, 3)), 0.2)
    end = balls.shape.start + np.array([0.0, 0.0, 0.5])
    radius = balls.shape.start_radius
    shape = Sticks(balls.shape.start, end, radius, radius, tint, TINTS, np.arange(n))
    return DisplayedRepresentation("clump", balls.cut, shape)


def test_twelve_frames_of_a_walk_compile_once(make, jit):
    """Of every tint there may be no stick, one, or many; the camera moves and turns."""
    import drjit as dr

    quality = make.quality(jit, spp=2)
    counts = [(3, 4, 9), (1, 1, 1), (0, 2, 5), (0, 0, 0), (1, 0, 7), (2, 1, 0)]
    misses = []
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for number in range(12):
            camera = make.camera((13, 7), heading=0.7 * number, eye=(0.2 * number, 0.0, 2.0))
            scene = [clump(make, counts[number % len(counts)]), make.ground(1500 + 10 * number)]
            dr.kernel_history_clear()
            render_frame(FrameInput(camera, tuple(scene), make.clear, make.light, quality), number)
            misses.append([not k["cache_hit"] for k in dr.kernel_history() if "cache_hit" in k])
    assert all(misses) and not any(any(each) for each in misses[1:])


def test_another_scene_that_is_still_there_takes_no_ids(make, jit):
    quality = make.quality(jit)
    lit = make.clear, make.light, quality
    seen = FrameInput(make.camera(), (clump(make, (2, 3, 4)), make.ground()), *lit)
    alone = render_frame(seen)
    balls = make.balls([(0.0, 5.0, 1.0)] * 3)
    other = build_frame(FrameInput(make.camera(), (make.ground(), balls), *lit))
    beside = render_frame(seen)
    late = trace(other, quality)
    for name in ("object", "part", "level"):
        assert np.array_equal(getattr(alone, name), getattr(beside, name))
    assert set(np.unique(late.object).tolist()) <= {0, 1, 2, 3, 4} and late.object.any()
