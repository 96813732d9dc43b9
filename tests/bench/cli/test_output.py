"""Bars on terminals only, never beside JSON; and whole frames, whatever becomes of the streams."""

import json
import math
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import click
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

from bench.cli.flags import StrictCommand
from bench.cli.output import (
    TimeLeft,
    _Doing,
    bars_are_shown,
    frame_progress,
    progress_bar,
    progress_shown,
)
from scenes.processes.progress import tell, work


def make_something():
    with progress_shown(), work("fitting things", 34):
        tell()
        tell(12.0)
        tell(22.0)


def test_what_is_made_is_shown_with_the_time_left_and_cleared(monkeypatch, capsys):
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
    make_something()
    said = capsys.readouterr().err.replace("\r", "\n")
    assert "fitting things 0/34" in said and "fitting things 12/34" in said and " left" in said
    assert said.splitlines()[-1].strip() == ""


def test_away_from_a_terminal_a_line_says_what_takes_long(monkeypatch, capsys):
    monkeypatch.setenv("LODBENCH_SIGN_OF_LIFE", "0.05")
    with progress_shown(), work("fitting things", 4):
        tell()
        time.sleep(0.01)
        tell(1.0)
        time.sleep(0.2)
        with progress_bar("step") as show:
            show(1, 2, "weighing")
            time.sleep(0.2)
    lines = capsys.readouterr().err.splitlines()
    assert any("fitting things 1/4" in line and " left" in line for line in lines)
    assert any("weighing 1/2" in line for line in lines)
    time.sleep(0.2)
    assert capsys.readouterr().err == ""


def test_steps_that_were_kept_tell_nothing_of_the_time_left(monkeypatch):
    doing, clock = _Doing(), iter((0.0, 0.1, 0.1, 10.1, 10.1))
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    doing.tell("kept", 0, 48, True)
    doing.tell("measured", 27, 48, True)
    assert str(doing) == "measured 27/48"
    doing.tell("measured", 28, 48)
    assert str(doing) == "measured 28/48, 3 min left"


def test_steps_with_names_of_their_own_share_one_time_left(monkeypatch):
    doing, now, said = _Doing(), [0.0], []
    monkeypatch.setattr("bench.cli.output.time.monotonic", lambda: now[0])
    for now[0], *told in ((0, "one", 0, 10), (50, "two", 5, 10), (52, "a kernel", 0, 0)):
        doing.tell(*told)
        said.append(str(doing))
    now[0] = 63.0
    assert [*said, str(doing)] == ["one 0/10", "two 5/10, 50 s left", "a kernel", said[1]]
    doing.tell("three", 6, 10)
    assert str(doing) == "three 6/10, 42 s left"


@given(st.lists(st.tuples(st.floats(1, 89), st.floats(0, 30)), min_size=2))
def test_no_time_left_rises_by_more_than_a_tenth(estimates):
    left, now, before = TimeLeft(), 0.0, math.inf
    for seconds, later in estimates:
        now += later
        told = int(left.tell(seconds, now).split()[-3])
        assert told <= min(1.1 * (before + 0.5), seconds) + 0.5
        before = told


@pytest.mark.parametrize(("flags", "shown"), [([], True), (["--json"], False)])
def test_no_bar_stands_beside_json(flags, shown, monkeypatch):
    @click.command(cls=StrictCommand)
    def command(out):
        monkeypatch.setattr(sys.stderr, "isatty", lambda: True)
        assert bars_are_shown() is shown
        with progress_bar("step") as show, frame_progress(2) as frames:
            show(0, 2, "one")
            frames.show_samples(1, 0, 0)
        make_something()

    result = CliRunner().invoke(command, flags)
    assert result.exit_code == 0, result.output
    assert bool(result.stderr) is shown


ROOT = Path(__file__).resolve().parents[3]
TINY = Path(__file__).with_name("tiny.toml")
LODBENCH = f"'{sys.executable}' -P -m bench.cli.main"
FULL = "lodbench: error: stdout could not be written (No space left on device)"


def shell(folder: Path, script: str) -> subprocess.CompletedProcess[str]:
    """Run a line of bash in which $lodbench is the program; the code is that of the program."""
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "LODBENCH_TRUSTED_VARIANT": "scalar_rgb"}
    return subprocess.run(
        ["bash", "-c", f"{script.replace('$lodbench', LODBENCH)}; exit ${{PIPESTATUS[0]}}"],
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
    )


@pytest.fixture(scope="module")
def right(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two right frames in out."""
    folder = tmp_path_factory.mktemp("right")
    shutil.copy(TINY, folder)
    done = shell(folder, "$lodbench render tiny.toml -o out/a.####.exr --frames 1-2")
    assert done.returncode == 0, done.stderr
    return folder


@pytest.mark.parametrize(
    "redirection",
    [
        "2>&-",
        "<&-",
        "--json <&- >&- 2>&-",
        "| true",
    ],
)
def test_a_right_folder_is_right(right: Path, redirection: str) -> None:
    done = shell(right, f"$lodbench verify out {redirection}")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("command", ["verify out --json", "list"])
def test_what_a_full_disk_did_not_take_is_said(right: Path, command: str) -> None:
    done = shell(right, f"$lodbench {command} >/dev/full")
    assert done.returncode == 1
    assert done.stderr == f"{FULL}: what was printed is lost, the work is done\n"


def test_a_wrong_folder_stays_wrong(right: Path, tmp_path: Path) -> None:
    subprocess.run(["cp", "-r", right / "out", tmp_path], check=True)
    (tmp_path / "out" / "a.0002.exr").write_text("half")
    done = shell(tmp_path, "$lodbench verify out | true")
    assert done.returncode == 1
    assert "1 file is wrong" in done.stderr
    both = shell(tmp_path, "$lodbench verify out >/dev/full")
    assert both.returncode == 1
    assert "1 file is wrong" in both.stderr
    assert "stdout could not be written" in both.stderr


@pytest.mark.parametrize("redirection", [">&- 2>&-", "--json | head -1"])
def test_frames_are_rendered_whoever_reads_of_it(
    right: Path, tmp_path: Path, redirection: str
) -> None:
    shutil.copy(TINY, tmp_path)
    render = "$lodbench render tiny.toml -o out/a.####.exr --frames 1-2"
    assert shell(tmp_path, f"{render} {redirection}").returncode == 0
    for frame in ("a.0001.exr", "a.0002.exr"):
        assert (tmp_path / "out" / frame).read_bytes() == (right / "out" / frame).read_bytes()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP, signal.SIGINT])
def test_each_signal_ends_a_sequence_tidily(right: Path, tmp_path: Path, number: int) -> None:
    shutil.copy(TINY, tmp_path)
    words = ["render", "tiny.toml", "-o", "out/a.####.exr", "--frames", "1-500", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "bench.cli.main", *words],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(ROOT), "LODBENCH_TRUSTED_VARIANT": "scalar_rgb"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    assert process.stdout
    first = json.loads(process.stdout.readline())
    os.killpg(process.pid, number)  # as a terminal does, to the processes that render, too
    out, err = process.communicate(timeout=60)
    assert (process.returncode, err) == (128 + number, "lodbench: interrupted\n")
    end = json.loads(out.splitlines()[-1])
    frames = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert len(frames) == end["done"] < 500
    assert Path(first["path"]).name == frames[0]
    time.sleep(0.1)
    with pytest.raises(ProcessLookupError):  # nobody of its group is left
        os.killpg(process.pid, 0)
