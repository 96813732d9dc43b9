"""The study of framing: counts by the law, and a record that can be read again."""

from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner

from bench.records.study_record import read_study_record
from bench.studies import framing
from lod.errors import InputError

FEW = ("view.detail=12", "species.figure.density=0.1", "species.figure.prototypes=2")


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """A record of a panorama alone, of few people."""
    framings = {"panorama": ("camera.projection=panorama", *FEW)}
    monkeypatch.setattr(framing, "FRAMINGS", framings)
    path = tmp_path / "framing.json"
    done = CliRunner().invoke(framing.command, ["--fields", "8", "--record", str(path)])
    assert done.exit_code == 0, done.output
    return path


def test_a_panorama_displays_as_many_as_the_law_says(recorded: Path) -> None:
    found = read_study_record(recorded)
    assert found.study == "framing" and found.settings["fields"] == 8
    for name in ("objects", "parts"):
        each = found.figures["panorama"][name]
        assert each["low"] < 1.02 and each["high"] > 0.98
        assert 0 < each["high"] - each["low"] < 0.3
    assert found.figures["panorama"]["objects_a_field"] > 100
    assert found.provenance["commit"] is None or len(found.provenance["commit"]) >= 40


def test_counts_of_another_law_are_found_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """Held against the law of one eye, a pair 20 m apart displays too many."""
    law = framing.predict

    def of_one_eye(field, view):
        alone = replace(view, camera=replace(view.camera, baseline_m=0.0))
        return law(field, alone)

    monkeypatch.setattr(framing, "predict", of_one_eye)
    keys = ("camera.stereo=20", "view.look_around=true", *FEW)
    assert (
        framing.ratios([framing.counts_of(keys, seed) for seed in (0, 1)])["objects"]["ratio"] > 1.1
    )


def test_what_is_no_record_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    with pytest.raises(FileNotFoundError):
        read_study_record(path)
    for text in ("{", '{"study": "start"}'):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(InputError, match="the record of a study"):
            read_study_record(path)
