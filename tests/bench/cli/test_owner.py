"""A folder belongs to one kind of settings at a time, while frames are rendered and afterwards."""

import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from scenes.render.exr.frames_on_disk import sequences_in, settings_hash

ROOT = Path(__file__).resolve().parents[3]
TINY = Path(__file__).with_name("tiny.toml")


def start(folder: Path, *words: str) -> subprocess.Popen[str]:
    """Start the program in a folder."""
    return subprocess.Popen(
        [sys.executable, "-P", "-m", "bench.cli.main", *words],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(ROOT), "LODBENCH_TRUSTED_VARIANT": "scalar_rgb"},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process: subprocess.Popen[str]) -> tuple[int, str]:
    """Its code and what it said."""
    _, err = process.communicate(timeout=300)
    return process.returncode, err


def render(folder: Path, *words: str, frames: str = "1-2", name: str = "a") -> tuple[int, str]:
    words = "render", "tiny.toml", "-o", f"out/{name}.####.exr", "--frames", frames, *words
    return ended(start(folder, *words))


def states(folder: Path) -> dict[str, str]:
    whole, _ = sequences_in(folder / "out")
    return {name: settings_hash(each.settings) for name, each in whole.items()}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(TINY, tmp_path)
    return tmp_path


def test_while_one_renders_others_are_refused(folder: Path) -> None:
    """With other settings, whatever their frames are called, and --overwrite, too."""
    words = "render", "tiny.toml", "-o", "out/a.####.exr", "--frames", "1-900"
    first = start(folder, *words)
    assert first.stdout
    assert "a.0001.exr" in first.stdout.readline()
    says = f"process {first.pid} on "
    for name, flags in (("b", ("--seed", "1")), ("a", ("--seed", "1", "--overwrite"))):
        code, err = render(folder, *flags, name=name)
        assert code == 2
        assert says in err
        assert "renders there with other settings; wait for its end" in err
        assert err.count("\n") == 1
    assert len(set(states(folder).values())) == 1
    assert render(folder, name="b") == (0, "")  # a farm's processes share a folder
    first.send_signal(signal.SIGTERM)
    assert ended(first)[0] == 143
    code, err = render(folder, "--seed", "1")
    assert code == 2
    assert "there with other settings (seed: 0 → 1); choose another folder, or --overw" in err
    assert ended(start(folder, "verify", "out")) == (0, "")
    assert ended(start(folder, "verify", "out", "--frames", "1-900"))[0] == 1  # some never were
    assert render(folder, "--seed", "1", "--overwrite", frames="1-3") == (0, "")
    assert len(set(states(folder).values())) == 2
    assert not (folder / "out" / ".lodbench").exists()


def test_of_two_that_start_at_once_one_is_refused(folder: Path) -> None:
    pair = [
        start(folder, "render", "tiny.toml", "-o", "out/a.####.exr", "--seed", f"{seed}")
        for seed in (1, 2)
    ]
    codes = sorted(ended(process)[0] for process in pair)
    assert codes == [0, 2]
    assert ended(start(folder, "verify", "out")) == (0, "")


def test_a_killed_owner_owns_nothing(folder: Path) -> None:
    first = start(folder, "render", "tiny.toml", "-o", "out/a.####.exr", "--frames", "1-900")
    assert first.stdout
    first.stdout.readline()
    first.kill()
    first.communicate()
    assert (folder / "out" / ".lodbench").exists()
    assert render(folder, "--seed", "1", name="b") == (0, "")
    assert not (folder / "out" / ".lodbench").exists()
