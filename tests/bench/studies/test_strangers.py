"""No study replaces what it did not make: it says so before it measures anything."""

import os
from pathlib import Path

import pytest

from bench.cli.main import main

STRANGERS = [
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
