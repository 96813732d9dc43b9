"""`lodbench frames`, `usd` and `ids`: what farms and other programs are handed."""

import json
import shlex
from functools import partial
from pathlib import Path

import pytest

from scenes.presets.load import load_preset
from scenes.render.exr.frames_on_disk import open_job, render_sequence
from scenes.render.exr.header import frame_settings
from scenes.render.frame_session import FrameSession
from tests.said import said

TINY = """
[terrain]
reach = 100
[species.figure]
model = "figure"
density = 0.01
prototypes = 1
[render]
size = "16x9"
spp = 1
variant = "scalar_rgb"
"""


@pytest.fixture
def run(capfd, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("tiny.toml").write_text(TINY)
    return partial(said, capfd)


def test_one_command_a_frame_with_every_flag_and_the_variant_settled(run):
    flags = ("tiny.toml", "-o", "o/a b.####.exr", "-D", "seed=7", "--motion")
    code, out, err = run("frames", "--print-commands", *flags, "--frames", "1-2,5")
    assert code == 0, err
    commands = [shlex.split(line) for line in out.splitlines()]
    assert commands == [
        ["lodbench", "render", *flags, "--variant", "scalar_rgb", "--frames", str(number)]
        for number in (1, 2, 5)
    ]


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (["tiny.toml"], "-o"),
        (["tiny.toml", "-o", "a.####.exr", "--cluster", "2"], "--cluster"),
        (["tiny.toml", "-o", "a\nlodbench.####.exr"], "words of one line"),
    ],
)
def test_what_render_would_refuse_is_refused(run, words, told):
    code, out, err = run("frames", "--print-commands", *words)
    assert (code, out) == (2, "")
    assert told in err and err.count("\n") == 1


def test_usd_counts_what_it_wrote(run):
    pytest.importorskip("pxr")
    code, out, err = run("usd", "tiny.toml", "-o", "u/a.usdc", "--frame", "3", "--json")
    assert code == 0, err
    found = json.loads(out)
    assert found["sticks"] > 50 and found["triangles"] > 10 and Path(found["path"]).is_file()
    code, _, err = run("usd", "tiny.toml", "-o", "a.obj")
    assert code == 2 and "usda" in err
    for key, value in (("projection", "panorama"), ("stereo", "0.1")):
        code, _, err = run("usd", "tiny.toml", "-o", "a.usda", "-D", f"camera.{key}={value}")
        assert code == 2 and f"camera.{key}: " in err and "one camera in perspective" in err


def rendered_frame():
    settings = frame_settings(load_preset("tiny.toml"), "scalar_rgb")
    session, job = FrameSession(settings), open_job("o/a.####.exr", [2], settings)
    list(render_sequence(job, lambda _, frame, path: session.render(frame, path)))


def test_ids_say_who_is_who_in_a_frame(run):
    rendered_frame()
    code, out, err = run("list", "--objects", "o/a.0002.exr", "--json")
    assert code == 0, err
    found = [json.loads(line) for line in out.splitlines()]
    figures = [each for each in found if each["of"] == "figure"]
    assert len({each["key"] for each in figures}) == len(figures) > 3
    last = figures[-1]["object"]
    code, out, _ = run("list", "--objects", "o/a.0002.exr", "--object", str(last), "--json")
    assert json.loads(out) == figures[-1]
    assert run("list", "--objects", "o/a.0002.exr", "--object", "0")[0] == 2
    assert run("list", "--objects", "o/a.0001.exr")[0] == 2
