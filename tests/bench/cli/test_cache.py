"""`lodbench cache` shows what is kept, and removes it."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.cli.commands.cache import command
from lod.errors import InputError
from scenes.processes.content_cache import kept


def test_it_shows_and_clears_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    kept("tree", "a", lambda: {"a": np.zeros(1000)})
    command.main([], standalone_mode=False)
    shown = capfd.readouterr().out
    assert str(tmp_path) in shown and "tree" in shown and "0.0 MB" in shown
    command.main(["--json"], standalone_mode=False)
    told = json.loads(capfd.readouterr().out)
    assert told["kinds"]["tree"]["files"] == 1 and told["bytes"] > 8000
    command.main(["--clear", "--json"], standalone_mode=False)
    assert json.loads(capfd.readouterr().out)["kinds"] == {}


def test_without_a_folder_it_names_the_cure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "file"))
    with pytest.raises(InputError, match="set LODBENCH_CACHE to a folder"):
        command.main([], standalone_mode=False)
