"""Clips, pruned beside everything drawn, and what motion does not explain of both."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench import motion_clips
from bench.motion_clips import CLIPS, WAYS
from scenes.preset import load_preset
from scenes.render.exr import read_exr


@pytest.mark.parametrize("name", list(CLIPS))
@pytest.mark.parametrize("way", list(WAYS))
def test_every_clip_is_a_preset(name, way):
    preset = load_preset("meadow", (*motion_clips.WORLD, *CLIPS[name], *WAYS[way]))
    assert (preset.view.metric == "full") == (way == "everything")


@pytest.mark.slow
def test_a_clip_lies_side_by_side_on_disk_and_has_its_rows(tmp_path):
    words = ["-o", str(tmp_path), "--frames", "2", "--size", "48x27", "--spp", "8"]
    told = CliRunner().invoke(motion_clips.main, [*words, "--clip", "pan"])
    assert told.exit_code == 0, told.output
    assert "everything" in told.output
    assert {"pan.png", "pan.0001.exr", "pan.0002.exr"} <= {p.name for p in tmp_path.iterdir()}
    shown = read_exr(tmp_path / "pan.0001.exr")[0].rgb
    assert shown.shape == (27, 96, 3)
    assert np.abs(shown[:, :48] - shown[:, 48:]).mean() < 0.1 * shown.mean()
