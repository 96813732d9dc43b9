"""`lodbench verify`, and `render` with a frame that cannot be: with a renderer of no cost."""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from bench.cli.main import main
from scenes.render import worker as worker_module

CHILD = """
import os
import signal

import numpy as np

from scenes.render.exr.layer_file import write_exr
from scenes.frame.layers import Layers
from scenes.render.exr.header import settings_attributes
from scenes.render.worker import serve


class Session:
    def __init__(self, settings):
        self.settings = settings

    def preflight(self, frames, folder, most_bytes):
        return {}

    def render(self, frame, target, watch, most_bytes):
        with open("tries", "a") as file:
            file.write(f"{frame} ")
        if frame == 7:
            os.kill(os.getpid(), signal.SIGSEGV)
        width, height = self.settings["render"]["size"]
        ids, colour = np.full((height, width), frame), np.full((height, width, 3), 0.5)
        layers = Layers(colour, ids, colour, colour, ids, ids, ids)
        digest = write_exr(target, layers, settings_attributes(self.settings, frame))
        record = {"frame": frame, "sha256": digest, "peak_rss_bytes": 1}
        return {**record, "seconds": {}, "statistics": {}}


serve(Session)
"""

Lines = list[dict[str, Any]]
Lodbench = Callable[..., tuple[int, Lines, str]]


@pytest.fixture
def lodbench(
    capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Lodbench:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "child.py").write_text(CHILD)
    child = (sys.executable, "-P", str(tmp_path / "child.py"))
    monkeypatch.setattr(worker_module, "CHILD", child)

    def runner(*arguments: str) -> tuple[int, Lines, str]:
        with pytest.raises(SystemExit) as left:
            main([*arguments, "--json"])
        out, err = capfd.readouterr()
        return left.value.code, [json.loads(line) for line in out.splitlines()], err

    return runner


def render(lodbench: Lodbench, frames: str) -> tuple[int, Lines, str]:
    flags = "--frames", frames, "--size", "8x4", "--variant", "scalar_rgb"
    return lodbench("render", "meadow", "-o", "out/a.####.exr", *flags)


def test_one_poisonous_frame_in_twenty_costs_that_frame(lodbench: Lodbench, tmp_path: Path) -> None:
    code, (*lines, end), err = render(lodbench, "1-20")
    assert code == 1
    assert [line["frame"] for line in lines] == [n for n in range(1, 21) if n != 7]
    (failure,) = end["failures"]
    assert (end["done"], end["failed"], failure["frame"], failure["tries"]) == (19, 1, 7, 3)
    assert "1 of 20 frames failed: frame 7: it ended its worker 3 times (SIGSEGV)" in err
    assert (tmp_path / "tries").read_text().split().count("7") == 3
    code, (found, counts), err = lodbench("verify", "out")
    assert (code, found["frame"], found["wrong"]) == (1, 7, ["there is no such file"])
    assert counts == {"frames": 20, "wrong": 1, "repaired": 0}


def test_verify_finds_and_repairs(lodbench: Lodbench, tmp_path: Path) -> None:
    render(lodbench, "1-3")
    assert lodbench("verify", "out") == (0, [{"frames": 3, "wrong": 0, "repaired": 0}], "")
    (tmp_path / "out" / "a.0002.exr").write_bytes(bytes(99))
    (tmp_path / "out" / ".a.0003.exr.gone-1.part").write_text("half")
    (tmp_path / "tries").unlink()
    code, (first, second, counts), err = lodbench("verify", "out")
    assert (code, first["path"], counts["wrong"]) == (1, "out/a.0002.exr", 2)
    assert second["path"].endswith(".part") and "--repair" in err
    code, (*_, removed, mended, counts), err = lodbench("verify", "out", "--repair")
    assert (code, err) == (0, "")
    assert mended == {"frame": 2, "path": "out/a.0002.exr", "repaired": "rendered again"}
    assert removed["repaired"] == "removed" and counts["repaired"] == 2
    assert (tmp_path / "tries").read_text().split() == ["2"]
    assert lodbench("verify", "out")[0] == 0


def test_what_stands_in_the_place_of_a_frame_is_repaired(
    lodbench: Lodbench, tmp_path: Path
) -> None:
    render(lodbench, "1-4")
    (tmp_path / "out" / "a.0002.exr").write_text("of others")
    code, (wrong, mended, counts), err = lodbench("verify", "out", "--repair")
    assert (code, err, counts) == (0, "", {"frames": 4, "wrong": 1, "repaired": 1})
    assert (wrong["frame"], mended["repaired"]) == (2, "rendered again")
    assert lodbench("verify", "out")[0] == 0


def test_what_is_wrong_still_beside_the_frames_is_said_with_what_was_repaired(
    lodbench: Lodbench, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """Frames were repaired, and a file of others stays: both lines say so, and agree."""
    render(lodbench, "1-4")
    for number in (1, 2, 3):
        (tmp_path / "out" / f"a.000{number}.exr").write_bytes(b"")
    (tmp_path / "out" / "a.0009.exr").write_text("of nobody")
    with pytest.raises(SystemExit) as left:
        main(["verify", "out", "--repair"])
    out, err = capfd.readouterr()
    assert left.value.code == 1
    assert out.splitlines()[-1] == (
        "4 frames: 4 right, 0 wrong, 1 file beside them wrong, 3 repaired"
    )
    assert err.startswith("lodbench: error: 1 file is wrong, first out/a.0009.exr: ")


def test_one_folder_by_two_names_keeps_its_frames(lodbench: Lodbench, tmp_path: Path) -> None:
    render(lodbench, "1-2")
    (tmp_path / "other").symlink_to("out")
    flags = "--frames", "1", "--size", "8x4", "--variant", "scalar_rgb", "--seed", "5"
    code, _, err = lodbench("render", "meadow", "-o", "other/a.####.exr", *flags)
    assert code == 2 and "there with other settings" in err
    assert lodbench("verify", "out") == (0, [{"frames": 2, "wrong": 0, "repaired": 0}], "")


def test_a_frame_that_became_a_device_is_wrong(lodbench: Lodbench, tmp_path: Path) -> None:
    render(lodbench, "1-2")
    (tmp_path / "out" / "a.0001.exr").unlink()
    (tmp_path / "out" / "a.0001.exr").symlink_to("/dev/zero")
    code, (found, _), _ = lodbench("verify", "out")
    assert (code, found["frame"]) == (1, 1)


def test_where_no_frame_is_whole_the_same_command_goes_on(
    lodbench: Lodbench, tmp_path: Path
) -> None:
    render(lodbench, "1-2")
    for path in (tmp_path / "out").glob("*.exr"):
        path.write_bytes(path.read_bytes()[:-1])
    code, _, err = lodbench("verify", "out", "--repair")
    assert (code, err.count("\n")) == (1, 1)
    assert lodbench("verify", "out")[0] == 1
    assert render(lodbench, "1-2")[0] == 0
    assert lodbench("verify", "out")[0] == 0


@pytest.mark.parametrize("folder", ["none", "child.py", "."])
def test_a_folder_without_frames_is_bad_input(lodbench: Lodbench, folder: str) -> None:
    code, lines, err = lodbench("verify", folder)
    assert (code, lines) == (2, [])
    assert f"DIR: {folder!r}: a folder with frames of lodbench" in err
