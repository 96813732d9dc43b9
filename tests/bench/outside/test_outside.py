"""Programs outside: what they are given, and that an environment is whole or is not there."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from bench.experiments.rivals.cycles import measure_cycles
from bench.experiments.rivals.noise import noise
from bench.experiments.rivals.walk import changes
from bench.experiments.rivals.windows import Window
from bench.fields.windows import Picture
from bench.outside import environments
from bench.outside.child_process import answer_of
from bench.outside.environments import CYCLES, VIDEO
from bench.outside.scene_arrays import chains
from bench.outside.video import just_objectionable_differences
from bench.records.points import where
from lod.errors import InputError


@pytest.fixture
def none_made(tmp_path, monkeypatch):
    monkeypatch.setattr(environments.platformdirs, "user_data_path", lambda *args, **more: tmp_path)
    return tmp_path


def test_joined_sticks_of_one_colour_are_one_chain():
    """Segments 0-1, 1-2 and 2-3, of which the last has another colour, and 5-6 apart."""
    ends = np.arange(28.0).reshape(7, 4)
    curve = {
        "segment_indices": np.array([0, 1, 2, 5], np.uint32),
        "control_points": ends.ravel(),
        "tint": np.array([0, 0, 1, 1], np.uint32),
        "tints": np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]),
    }
    points, counts, tints = chains(curve)
    assert counts.tolist() == [3, 2, 2]
    assert points[:, 0].tolist() == [0.0, 4.0, 8.0, 8.0, 12.0, 20.0, 24.0]
    assert tints[:, 0].tolist() == [0.1, 0.4, 0.4]


def test_an_environment_is_there_when_it_was_made_whole_from_these_requirements(none_made):
    python = CYCLES.folder / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.touch()
    assert none_made in python.parents and CYCLES.python() is None
    (CYCLES.folder / "made-from").write_text(CYCLES._digest(), encoding="utf-8")
    assert CYCLES.python() == python
    assert replace(CYCLES, requirements=VIDEO.requirements).python() is None


@pytest.mark.usefixtures("none_made")
def test_what_cannot_be_made_or_asked_is_refused_in_a_line(monkeypatch):
    with pytest.raises(InputError, match="study environments cycles"):
        answer_of(CYCLES, "cycles_child.py", "{}")
    with pytest.raises(InputError, match=r"Python 2\.7 alone"):
        replace(CYCLES, needs_python="2.7").make()
    full = SimpleNamespace(free=1e9)
    monkeypatch.setattr(environments.shutil, "disk_usage", lambda path: full)
    with pytest.raises(InputError, match=r"downloads 3\.1 GB"):
        VIDEO.make()


def test_noise_is_the_variance_of_one_sample():
    """Light of 1 with a standard deviation of 0.1 at 4 samples: 0.04 × exposure² of each pixel."""
    random = np.random.default_rng(1)
    few, many = (
        [1.0 + spread * random.standard_normal((90, 160, 3)) for _ in range(3)]
        for spread in (0.1, 0.05)
    )
    assert np.mean(noise(few, 4)) == pytest.approx(np.mean(noise(many, 16)), rel=0.03)
    assert 0.02 * 1e6 < np.mean(noise(few, 4)) <= 0.042 * 1e6


def test_what_moves_as_the_whole_does_leaves_nothing():
    """A constant difference is one of pictures and not of steps; what flickers is one of both."""
    whole = np.linspace(0.2, 0.6, 4 * 9 * 16 * 3, dtype="f4").reshape(4, 9, 16, 3)
    flip, residual = changes(whole + np.float32(0.1), whole)
    assert min(flip.values) > 0 and max(residual.values) <= 1
    flicker = whole + np.array([0, 0.1, 0, 0.1], "f4")[:, None, None, None]
    assert changes(flicker, whole)[1].values == pytest.approx([1e5] * 3, rel=1e-3)


@pytest.mark.slow
@pytest.mark.skipif(CYCLES.python() is None, reason="no environment with Cycles was made here")
def test_both_renderers_show_the_same_light():
    points = measure_cycles(Window("crowd", 100.0, 0, Picture("64x36", 16), 1, 1, "scalar_rgb"), 0)
    for arm, setting in (("full", 0.0), ("blake", 4.0)):
        means = [
            where(points, arm=arm, setting=setting, renderer=name)[0].values("light").mean()
            for name in ("mitsuba", "cycles")
        ]
        assert means[1] == pytest.approx(means[0], rel=0.005)


@pytest.mark.slow
@pytest.mark.skipif(VIDEO.python() is None, reason="no environment with ColorVideoVDP was made")
def test_the_same_video_has_ten_points_and_a_noisy_one_fewer():
    random = np.random.default_rng(0)
    whole = random.random((8, 36, 64, 3)).astype("f4")
    noisy = np.clip(whole + 0.1 * random.standard_normal(whole.shape), 0, 1).astype("f4")
    found = just_objectionable_differences({"same": whole, "noisy": noisy}, whole, 24.0)
    assert found["same"] == pytest.approx(10.0) and found["noisy"] < 9.5
