"""Many fields in a file: what is kept of them, and how bands are judged."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench.studies import tone as tone_benchmark
from bench.studies.tone import COLUMNS, band_count, command, judge_bands, read_fields, write_fields
from lod.errors import InputError


def planted(ratio: float, fields: int = 200) -> dict:
    """Fields of ``forest`` whose pruned bands are so bright beside the whole ones, give or take."""
    rng = np.random.default_rng(3)
    found = {}
    for seed in range(fields):
        rows = []
        for band in range(band_count("forest")):
            rays, light = rng.integers(800, 1200, 2), 1e6 * rng.normal(1 + band, 0.05, 2)
            rows.append(
                [int(ratio * light[0] * rays[0]), rays[0], int(light[1] * rays[1]), rays[1]]
            )
        found["forest", seed] = [[int(each) for each in row] for row in rows]
    return found


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(1.0, "holds"), (0.95, "refuted"), (1.05, "refuted")]
)
def test_bands_are_judged_by_what_was_planted(ratio, verdict):
    claims = judge_bands(planted(ratio), "forest")
    assert [each.verdict for each in claims] == [verdict] * band_count("forest")
    assert [each.measured for each in claims] == pytest.approx([ratio] * len(claims), abs=0.03)


def test_fields_are_kept_whole_or_not_at_all(tmp_path):
    path, found = tmp_path / "fields.csv", planted(1.0, 3)
    assert read_fields(path) == {}
    write_fields(path, found)
    assert read_fields(path) == found
    text = path.read_text()
    assert text.splitlines()[0] == ",".join(COLUMNS)
    path.write_text(text[: text.rindex("forest")])  # the last band of the last field is missing
    assert read_fields(path) == {key: found[key] for key in sorted(found)[:2]}
    write_fields(path, read_fields(path) | found)
    assert path.read_text() == text and list(tmp_path.iterdir()) == [path]


def test_the_head_of_another_table_is_refused(tmp_path):
    (tmp_path / "fields.csv").write_text("name,age\n")
    with pytest.raises(InputError, match="a table with the columns look, seed, band"):
        read_fields(tmp_path / "fields.csv")


def test_pruned_pictures_are_measured_anew_beside_whole_ones_that_are_kept(tmp_path, monkeypatch):
    path, old = tmp_path / "fields.csv", planted(0.95, 4)
    write_fields(path, old)
    text, asked = path.read_text(), []

    def stopped_once(missing, wholes, processes):
        asked.append(missing)
        assert wholes == old
        for key in missing if len(asked) > 1 else missing[:1]:
            yield key, [[10 * band[0], band[1], *band[2:]] for band in wholes[key]]
        if len(asked) == 1:
            raise KeyboardInterrupt

    monkeypatch.setattr(tone_benchmark, "_measure_fields", stopped_once)
    arguments = [str(tmp_path), "--again"]
    assert CliRunner().invoke(command, arguments).exit_code == 1  # stopped
    assert path.read_text() == text
    CliRunner().invoke(command, arguments)
    assert [len(each) for each in asked] == [4, 3]
    found = read_fields(path)
    assert [found[key][0][0] / old[key][0][0] for key in sorted(old)] == [10.0] * 4
    assert not (tmp_path / "again.csv").exists()
