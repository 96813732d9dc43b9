"""Same seed, same bytes: over repeats, processes and thread counts; nothing else is random."""

import hashlib
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lod.air import Air
from scenes.frame.frame_input import FrameInput
from scenes.render.render import render_frame

LAYERS = ("rgb", "Z", "N", "albedo", "object", "part", "level")


def digest(layers):
    return hashlib.sha256(b"".join(getattr(layers, k).tobytes() for k in LAYERS)).hexdigest()


def small_frame(make, variant, seed=1, frame=0, spp=5, most_samples=2**19):
    """A film of a few odd blocks, with haze, silhouettes and bounces."""
    scene = [make.balls([(x, 8.0, 1.0) for x in range(-3, 4)]), make.ground()]
    quality = replace(make.quality(variant, spp, seed), most_samples=most_samples)
    return render_frame(
        FrameInput(
            make.camera((50, 35)),
            tuple(scene),
            Air(391.2),
            make.light,
            quality,
        ),
        frame,
    )


def in_a_fresh_process(variant, threads):
    room = Path(__file__).parent
    code = f"""
import importlib.util
import drjit as dr
dr.set_thread_count({threads})
def load(name, file):
    spec = importlib.util.spec_from_file_location(name, {str(room)!r} + "/" + file)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
test = load("test_determinism", "test_determinism.py")
print(test.digest(test.small_frame(load("conftest", "conftest.py").Making, {variant!r})))
"""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, env=environment, timeout=600
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_threads_and_processes_do_not_matter(make, variant):
    here = digest(small_frame(make, variant))
    assert {in_a_fresh_process(variant, threads) for threads in (1, 5)} == {here}


@pytest.mark.parametrize("change", [{"seed": 2}, {"seed": 2**63 - 1}, {"frame": 1}])
def test_seed_and_frame_change_the_noise(make, variant, change):
    assert digest(small_frame(make, variant)) != digest(small_frame(make, variant, **change))


def test_bands_are_seamless_and_independent_of_memory(make, variant):
    """Tracing in small runs gives another noise, but the same picture and as many samples."""
    whole = small_frame(make, variant, spp=64)
    pieces = small_frame(make, variant, spp=64, most_samples=20_000)
    assert digest(whole) != digest(pieces)
    assert np.abs(whole.rgb - pieces.rgb).mean() < 0.02 * whole.rgb.mean()
    assert (whole.object != pieces.object).mean() < 0.05
