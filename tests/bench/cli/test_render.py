"""`lodbench render`, small: frames, their record, and what a second run does with them.

No command replaces what it did not write, unless it is told to.
"""

import hashlib
import json
import shutil
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

from scenes.render.pictures import save_picture
from tests.said import said

TINY = Path(__file__).with_name("tiny.toml")
PATTERN = "out/a.####.exr"

Render = Callable[..., tuple[int, list[dict[str, Any]], str]]


@pytest.fixture
def render(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Render:
    monkeypatch.chdir(tmp_path)
    shutil.copy(TINY, tmp_path)

    def runner(*arguments: str) -> tuple[int, list[dict[str, Any]], str]:
        code, out, err = said(capfd, "render", "tiny.toml", "-o", PATTERN, "--json", *arguments)
        return code, [json.loads(line) for line in out.splitlines()], err

    return runner


def test_frames_are_written_and_recorded(render: Render, tmp_path: Path) -> None:
    code, (first, second, end), err = render("--frames", "1,3")
    assert code == 0, err
    assert end == {"done": 2, "failed": 0, "failures": [], "previews": []}
    for record, frame in ((first, 1), (second, 3)):
        path = tmp_path / "out" / f"a.{frame:04d}.exr"
        assert (record["frame"], record["path"]) == (frame, f"out/{path.name}")
        assert record["sha256"] == hashlib.sha256(path.read_bytes()).hexdigest()
        assert record["peak_rss_bytes"] > 2**20
        assert {"world", "prune", "appearance"} <= set(record["seconds"])
    assert first["sha256"] != second["sha256"]


def test_the_same_command_again_keeps_what_is_done(render: Render) -> None:
    _, (first, _), _ = render()
    _, (again, _), _ = render()
    assert again["kept"] is True
    assert again["sha256"] == first["sha256"]
    _, (anew, _), _ = render("--overwrite")
    assert anew["kept"] is False
    assert anew["sha256"] == first["sha256"]


def only_on_path(monkeypatch: pytest.MonkeyPatch, path: str) -> None:
    """No ffmpeg but what stands there."""
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    monkeypatch.setenv("PATH", path)


def test_the_extra_brings_its_own_ffmpeg(
    render: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("imageio_ffmpeg")
    monkeypatch.setenv("PATH", "")
    _, (*_, end), err = render("--frames", "1-2", "--preview")
    assert end["previews"] == ["out/a.png", "out/a.mp4"], err
    assert (tmp_path / "out" / "a.mp4").read_bytes()[4:8] == b"ftyp"


def test_without_ffmpeg_the_sheet_is_all(render: Render, monkeypatch: pytest.MonkeyPatch) -> None:
    only_on_path(monkeypatch, "")
    _, (*_, end), _ = render("--frames", "1-2", "--preview")
    assert end["previews"] == ["out/a.png"]


def test_a_film_that_fails_spoils_nothing(
    render: Render, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    begins = 'for last; do :; done; echo half > "$last"'
    (tmp_path / "ffmpeg").write_text(f"#!/bin/sh\n{begins}\necho no such codec >&2\nexit 1\n")
    (tmp_path / "ffmpeg").chmod(0o755)
    only_on_path(monkeypatch, str(tmp_path))
    code, (*_, end), err = render("--frames", "1-2", "--preview")
    assert code == 0
    assert end["previews"] == ["out/a.png"]
    assert "no mp4: ffmpeg: no such codec" in err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        "a.0001.exr",
        "a.0002.exr",
        "a.png",
    }


@pytest.fixture
def lodbench(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    shutil.copy(TINY, ".")
    return lambda *words: said(capfd, *words)[::2]


def test_usd_replaces_nothing_unasked(lodbench):
    pytest.importorskip("pxr")
    Path("thesis.usda").write_text("years of work")
    code, err = lodbench("usd", "tiny.toml", "-o", "thesis.usda")
    assert (code, err.count("\n")) == (2, 1)
    assert "not there yet; choose another name, or --overwrite" in err
    assert Path("thesis.usda").read_text() == "years of work"
    assert lodbench("usd", "tiny.toml", "-o", "thesis.usda", "--overwrite") == (0, "")
    assert Path("thesis.usda").read_text().startswith("#usda")
    assert lodbench("usd", "tiny.toml", "-o", "other.usda") == (0, "")
    assert not list(Path().glob(".*"))


@pytest.mark.parametrize("name", ["a.png", "a.mp4"])
def test_previews_replace_previews_alone(lodbench, name):
    Path("out").mkdir()
    Path("out", name).write_text("a photograph")
    words = "render", "tiny.toml", "-o", "out/a.####.exr", "--preview"
    code, err = lodbench(*words)
    assert (code, err.count("\n")) == (2, 1)
    assert f"--preview: 'out/{name}': a file that is not there yet" in err
    assert sorted(path.name for path in Path("out").iterdir()) == [name]
    Path("out", name).unlink()
    save_picture(Image.new("RGB", (2, 2)), "out/a.png")
    assert lodbench(*words) == (0, "")
    assert Image.open("out/a.png").size == (16, 9)
