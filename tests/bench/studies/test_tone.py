"""Many fields in a file: what is kept of them, and how bands are judged."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench.experiments.cover.claims import SAME_RAYS
from bench.records.records import columns
from bench.seeds import BUILDING_SEEDS
from bench.studies import tone as tone_benchmark
from bench.studies.tone import (
    COLUMNS,
    FIRST_SEED,
    band_count,
    command,
    judge_fields,
    read_fields,
    write_fields,
)
from lod.errors import InputError


def planted(ratio: float, fields: int = 200) -> dict:
    """Fields of ``forest`` whose pruned bands are so bright beside the whole ones, give or take."""
    rng = np.random.default_rng(3)
    found = {}
    for seed in range(fields):
        bands = []
        for band in range(band_count("forest")):
            rays = rng.integers(800, 1200)
            for picture, share in (("pruned", ratio), ("whole", 1.0)):
                light = int(1e6 * rng.normal(1 + band, 0.05) * share * rays)
                sums = {"light": [light], "land": [light // 2], "rays": [int(rays)]}
                bands += columns(sums, picture=picture, band=band)
            bands += columns({"light": [1]}, picture=SAME_RAYS, band=band)
        found["forest", "clear", seed] = tuple(bands)
    return found


@pytest.mark.parametrize(
    ("ratio", "verdict"), [(1.0, "holds"), (0.95, "refuted"), (1.05, "refuted")]
)
def test_bands_are_judged_by_what_was_planted(ratio, verdict):
    claims = {c.name: c for c in judge_fields(planted(ratio))}
    tone = [c for name, c in claims.items() if not name.endswith("coverage")]
    assert [each.verdict for each in tone] == [verdict] * band_count("forest")
    assert [each.measured for each in tone] == pytest.approx([ratio] * len(tone), abs=0.03)
    assert claims["forest/clear/tau_12/band_8/coverage"].measured == 1.0
    assert FIRST_SEED > BUILDING_SEEDS


def test_fields_are_kept_whole_or_not_at_all(tmp_path):
    path, found = tmp_path / "fields.csv", planted(1.0, 3)
    assert read_fields(path) == {}
    write_fields(path, found)
    assert read_fields(path) == found
    text = path.read_text()
    assert text.splitlines()[0] == ",".join(COLUMNS)
    path.write_text(text[: text.rindex("forest")])  # the last sum of the last field is missing
    assert read_fields(path) == {key: found[key] for key in sorted(found)[:2]}
    write_fields(path, read_fields(path) | found)
    assert path.read_text() == text and list(tmp_path.iterdir()) == [path]


def test_another_table_and_rows_of_other_sources_are_refused(tmp_path, monkeypatch):
    path = tmp_path / "fields.csv"
    path.write_text("name,age\n")
    with pytest.raises(InputError, match="a table with the columns look, air, seed"):
        read_fields(path)
    write_fields(path, planted(1.0, 2))
    monkeypatch.setattr(tone_benchmark, "sources", lambda: "others")
    with pytest.raises(InputError, match="written by the sources that are here"):
        read_fields(path)


def test_a_run_that_was_stopped_goes_on(tmp_path, monkeypatch):
    known, asked = planted(0.95, 1)["forest", "clear", 0], []

    def stopped_once(missing, processes):
        asked.append(missing)
        for number, key in enumerate(missing):
            if len(asked) == 1 and number == 3:
                raise KeyboardInterrupt
            yield key, known

    monkeypatch.setattr(tone_benchmark, "_measure_fields", stopped_once)
    arguments = [str(tmp_path), "--fields", "4"]
    assert CliRunner().invoke(command, arguments).exit_code == 1  # stopped
    assert CliRunner().invoke(command, arguments).exit_code == 0
    assert [len(each) for each in asked] == [8, 5]
    assert not set(asked[1]) & set(asked[0][:3])
