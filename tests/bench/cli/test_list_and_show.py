"""What there is to choose from, a preset as a file to edit, and what is kept between runs."""

import json
from pathlib import Path

import numpy as np
import pytest

from bench.cli.commands import doctor
from bench.cli.main import main
from lod.errors import InputError
from scenes.presets.load import load_preset
from scenes.processes.cache import cache_contents, kept


def run(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


def test_all_keys_are_listed_with_their_unit(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("list", "--keys") == 0
    line = next(x for x in capsys.readouterr().out.splitlines() if " camera.height " in x)
    assert line.split()[:3] == ["camera.height", "number", "m"]


def test_the_keys_of_a_preset_have_its_values(capfd: pytest.CaptureFixture[str]) -> None:
    assert run("list", "--keys", "fly_in", "--json") == 0
    keys = json.loads(capfd.readouterr().out)["keys"]
    assert keys["view.detail"] == {"value": 60.0}


def test_a_shown_preset_can_be_edited_and_used(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run("show", "meadow", "--size", "40x30", "-D", "camera.height=3") == 0
    mine = tmp_path / "mine.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    preset = load_preset(str(mine))
    assert (preset.render.size, preset.camera.height) == ((40, 30), 3.0)
    assert preset == load_preset("meadow", ["render.size=40x30", "camera.height=3.0"])


def test_help_keeps_its_short_flag_after_frames(capsys: pytest.CaptureFixture[str]) -> None:
    """`frames` parses the words of `render` itself; a command keeps the names it first gets."""
    from bench.cli.commands.render import command as render

    render._help_option = None
    run("frames", "--print-commands", "meadow", "-o", "a.####.exr", "--variant", "scalar_rgb")
    assert run("render", "-h") == 0


def test_doctor_shows_and_clears_what_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    kept("tree", "a", lambda: {"a": np.zeros(1000)})
    assert cache_contents(tmp_path)[0].kind == "tree"
    doctor._clear_cache()
    assert cache_contents(tmp_path) == []


def test_a_cache_without_a_folder_names_the_cure(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("no folder can be made below a file")
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path / "file"))
    with pytest.raises(InputError, match="set LODBENCH_CACHE to a folder"):
        doctor._clear_cache()
