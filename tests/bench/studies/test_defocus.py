"""The study of defocus: what it says where the answer is known."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench.studies import defocus
from bench.studies.defocus import BANDS_M, Pictures, errors_by_distance, law_ratio

PRESET = """
about = "people on flat ground"
[camera]
height = 1.6
[species.figure]
model = "figure"
density = 0.02
prototypes = 2
"""


@pytest.fixture
def people(tmp_path):
    path = tmp_path / "people.toml"
    path.write_text(PRESET, encoding="utf-8")
    return str(path)


def test_only_the_band_that_differs_has_an_error_and_noise_has_none():
    """Two columns of distance, of which the far one is other in what is tested."""
    away = np.repeat([[8.0] * 160 + [30.0] * 160], 48, axis=0)
    chance = np.random.default_rng(1)
    tested, everything = {}, {}
    for samples in (16, 64, 256):
        noise = 0.04 / samples**0.5
        grey = [
            np.clip(0.5 + chance.normal(0, noise, (48, 320, 3)), 0, 1).astype(np.float32)
            for _ in range(12)
        ]
        other = [np.where(away[..., None] > 20, 0.8, each).astype(np.float32) for each in grey[8:]]
        everything[samples] = Pictures(grey[:8], away.ravel())
        tested[samples] = Pictures(other, away.ravel())
    found = errors_by_distance(tested, everything, 48.0)
    assert list(found) == ["6 to 12 m", "24 to 48 m", "0 to 48 m"]
    assert found["24 to 48 m"]["low"] > 0.1
    assert max(abs(each["floor"]) for each in found.values()) < 0.01  # FLIP is not linear in noise
    assert abs(found["6 to 12 m"]["error"]) < 0.2 * found["24 to 48 m"]["error"]


def test_the_law_knows_how_many_parts_a_lens_leaves():
    ratio = law_ratio(0.025, 12.0, 6)
    assert ratio.low < 1.01 and ratio.high > 0.99
    assert ratio.high - ratio.low < 0.1


def test_the_table_says_what_is_saved(people):
    said = CliRunner().invoke(defocus.command, [people, "--pairs", "0", "--fields", "0"])
    assert said.exit_code == 0, said.output
    rows = [line.split() for line in said.output.splitlines()[1 : len(BANDS_M)]]
    sharp, lens = (np.array([int(row[k].replace(",", "")) for row in rows]) for k in (-3, -2))
    assert (lens <= sharp).all() and lens.sum() < 0.8 * sharp.sum()
    saved = 1 - lens / np.maximum(sharp, 1)
    assert saved[-1] == saved.max() and saved[2] < 0.1  # at the focus hardly any


@pytest.mark.slow
def test_pictures_are_compared_with_everything(people):
    flags = "--fields", "0", "--extent", "60", "--size", "24x14", "--spp", "1", "--spp", "4"
    said = CliRunner().invoke(defocus.command, [people, *flags])
    assert said.exit_code == 0, said.output
    assert said.output.count("against everything") == 2 and "0 to 30 m" in said.output
