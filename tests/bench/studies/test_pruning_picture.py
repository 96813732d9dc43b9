"""The picture of pruning shows the same view three times, with the numbers that were counted."""

from pathlib import Path

import numpy as np
from click.testing import CliRunner
from PIL import Image

from bench.studies.pruning_picture import command, side_by_side


def test_panels_stand_side_by_side_in_their_order() -> None:
    panels = [(str(k), np.full((20, 30, 3), 40 * k, np.uint8)) for k in range(3)]
    sheet = np.asarray(side_by_side(panels))
    assert sheet.shape == (42, 3 * 30 + 2 * 6, 3)
    assert [int(sheet[10, 15 + 36 * k, 0]) for k in range(3)] == [0, 40, 80]
    assert (sheet[:20, 30:36] == 255).all()


def test_pruned_there_is_less_and_the_view_is_the_same(tmp_path: Path) -> None:
    flags = "--preset crowd --extent 40 --detail 8 --size 32x18 --spp 1".split()
    done = CliRunner().invoke(command, [*flags, "-o", str(tmp_path / "a.png")])
    assert done.exit_code == 0, done.output
    whole, pruned = _counts(done.output)
    assert 0 < pruned < whole / 10
    with Image.open(tmp_path / "a.png") as sheet:
        assert sheet.width == 3 * 32 + 2 * 6


def _counts(text: str) -> list[int]:
    words = text.replace(",", "").split()
    return [int(words[k - 1]) for k, word in enumerate(words) if word == "parts"]
