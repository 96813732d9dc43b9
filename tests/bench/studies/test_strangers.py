"""No study replaces what it did not make: it says so before it measures anything."""

import os
from pathlib import Path

import pytest

from bench.cli.main import main
from bench.studies.films.forest_walk import load_walk

STRANGERS = [
    ("zoo.png", "gallery", "zoo", "-o", "."),
    ("zoo_level.png", "gallery", "zoo", "-o", "."),
    ("README.md", "gallery", "zoo", "-o", "."),
    ("sheet.png", "films", "walk", "."),
    ("pan.0003.exr", "films", "clips", "-o", ".", "--clip", "pan"),
    ("pan.png", "films", "clips", "-o", ".", "--clip", "pan"),
    ("fields.csv", "tone", "."),
]


@pytest.mark.parametrize(("name", "words"), [(name, words) for name, *words in STRANGERS])
def test_a_study_replaces_nothing_of_others(name, words, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    Path(name).write_text("name,age\nyears of work,9\n")
    with pytest.raises(SystemExit) as left:
        main(["study", *words])
    out, err = capfd.readouterr()
    assert (left.value.code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("lodbench: error: ") and name in err
    assert Path(name).read_text() == "name,age\nyears of work,9\n"
    assert os.listdir() == [name]


def test_a_pair_of_frames_that_cannot_be_read_is_named(tmp_path):
    (tmp_path / "fading.0001.npz").write_text("no pair of frames")
    with pytest.raises(ValueError, match=r"fading\.0001\.npz': a pair of frames, as this study"):
        load_walk(tmp_path, "fading")
