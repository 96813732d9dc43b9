"""A denoised picture is nearer to the truth, leaves the raw one alone, and comes out the same."""

import sys
from dataclasses import replace

import drjit
import numpy as np
import pytest

from lod.errors import InputError
from scenes.frame.frame_input import FrameInput
from scenes.render.pictures.denoise import denoise as denoise_layers
from scenes.render.pipeline.render import render_frame


def frame(make, spp, denoise=False, size=(48, 32)):
    scene = [make.balls([(x, 8.0, 1.0) for x in range(-3, 4)]), make.ground()]
    quality = make.quality("scalar_rgb", spp)
    camera = make.camera(size)
    return render_frame(
        FrameInput(camera, tuple(scene), make.clear, make.light, quality, denoise=denoise)
    )


def test_the_error_falls_and_the_raw_picture_stays(make):
    pytest.importorskip("mitsuba_oidn")
    raw, with_it = (frame(make, 1, each, (96, 64)) for each in (False, True))
    truth = frame(make, 256, size=(96, 64)).rgb
    assert raw.denoised is None
    assert np.array_equal(raw.rgb, with_it.rgb)
    assert with_it.denoised.shape == truth.shape and (with_it.denoised >= 0).all()
    before, after = (np.mean((each - truth) ** 2) for each in (raw.rgb, with_it.denoised))
    assert after < before / 4, before / after
    assert with_it.seconds["denoise"] > 0


def test_threads_and_repeats_do_not_matter(make):
    pytest.importorskip("mitsuba_oidn")
    layers, threads = frame(make, 1), drjit.thread_count()
    try:
        pictures = []
        for count in (1, 2, 3, 2):
            drjit.set_thread_count(count)
            pictures.append(denoise_layers(layers).denoised)
    finally:
        drjit.set_thread_count(threads)
    assert all(np.array_equal(pictures[0], other) for other in pictures[1:])


def test_nothing_bright_or_black_upsets_it(make):
    pytest.importorskip("mitsuba_oidn")
    layers = frame(make, 1, size=(20, 12))
    rgb = np.array(layers.rgb)
    rgb[:6], rgb[6:] = 0.0, 1e5
    assert np.isfinite(denoise_layers(replace(layers, rgb=rgb)).denoised).all()


def test_without_the_denoiser_the_extra_is_named(make, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    with pytest.raises(InputError, match=r"lodbench\[denoise\]"):
        frame(make, 1, denoise=True)
