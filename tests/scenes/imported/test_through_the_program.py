"""Imported models through the whole program: counted, rendered, resumed, verified, refused."""

import json
import os
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bench.cli.commands import model
from bench.cli.commands.model import SIDE
from bench.cli.output import SIGN_OF_LIFE_VARIABLE
from lod.errors import InputError
from scenes.imported.library import keep_model, model_by_digest, read_model
from scenes.model_files import user_model_names
from scenes.presets.load import load_preset
from scenes.render.exr.frames_on_disk import read_whole
from scenes.render.exr.header import frame_settings
from scenes.render.exr.layer_file import read_exr
from scenes.render.frame_session import FrameSession
from scenes.render.variants import choose
from tests.said import said
from tests.scenes.imported.sample_models import lamp_tree, mill

PRESET = """
[camera]
height = 3.0
speed = 0.0
[terrain]
amplitude = 0.5
finest = 1.0
[species.mill]
model = "mill.usda"
density = 0.001
[species.lamps]
model = "lamps"
density = 0.002
[placed.near]
model = "mill.usda"
position = [6.0, 20.0]
heading = 200.0
[render]
size = [64, 40]
spp = 1
"""


@pytest.fixture
def run(tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    return partial(said, capfd)


@pytest.fixture
def preset(tmp_path: Path, run: Any) -> str:
    """A preset beside whose file lies one model, and whose other model was added."""
    mill(tmp_path / "mill.usda")
    keep_model("lamps", read_model(lamp_tree(tmp_path / "lamps.glb")), overwrite=False)
    (tmp_path / "scene.toml").write_text(PRESET)
    return str(tmp_path / "scene.toml")


@pytest.mark.slow
def test_the_law_holds_for_them(preset: str, run: Any) -> None:
    code, out, err = run("count", preset, "--json", "--seed", "3")
    assert code == 0, err
    found = json.loads(out)["by_species"]
    for name in ("mill", "lamps"):
        for what in ("objects", "parts"):
            each = found[name][what]
            assert each["displayed"] > 150
            assert abs(each["displayed"] - each["predicted"]) < 4 * each["predicted_sd"]


@pytest.mark.slow
@pytest.mark.parametrize("variant", ["scalar_rgb", "auto"])
def test_they_are_rendered_resumed_and_verified(
    variant: str, preset: str, run: Any, tmp_path: Path
) -> None:
    out = str(tmp_path / "out/a.####.exr")
    words = ("render", preset, "-o", out, "--variant", variant, "--threads", "1")
    flags = ("--cryptomatte", "-D", "output.motion=true", "-D", "world.extent=120")
    assert run(*words, *flags, "--frames", "1-1")[0] == 0
    first = (tmp_path / "out/a.0001.exr").stat().st_mtime_ns
    code, _, err = run(*words, *flags, "--frames", "1-2")
    assert code == 0, err
    assert (tmp_path / "out/a.0001.exr").stat().st_mtime_ns == first
    assert (tmp_path / "out/a.0002.exr").exists()
    code, _, err = run("verify", str(tmp_path / "out"))
    assert code == 0, err
    layers = read_exr(tmp_path / "out/a.0001.exr")[0]
    moving = np.linalg.norm(layers.motion, axis=-1) > 0
    assert moving.any() and not moving.all()
    assert (layers.level[moving] >= 2).all()  # sails, and nothing of what stands still
    code, said, _ = run("list", "--objects", str(tmp_path / "out/a.0001.exr"), "--json")
    assert code == 0
    assert {"mill", "lamps", "near"} & set(said.replace('"', " ").split())
    # Another model under the same name: other settings.
    mill(tmp_path / "other.usda", turning=False).replace(tmp_path / "mill.usda")
    code, _, err = run(*words, *flags, "--frames", "1-2")
    assert (code, len(err.splitlines())) == (2, 1)
    assert "model_sha256" in err


@pytest.mark.slow
def test_a_model_is_added_with_a_picture_of_its_levels(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(SIGN_OF_LIFE_VARIABLE, "0.02")
    lamps = str(lamp_tree(tmp_path / "lamps.glb"))
    code, _, err = run("model", "add", lamps)
    assert code == 0
    for phase in ("reading lamps.glb", "fitting appearances", "rendering a picture of each level"):
        assert phase in err
    with Image.open(tmp_path / "data/lodbench/models/lamps.png") as sheet:
        assert sheet.width > 5 * SIDE and sheet.height > 2 * SIDE
        pixels = np.asarray(sheet)
    assert (pixels != pixels[0, 0]).any(axis=-1).mean() > 0.5


def test_a_model_whose_picture_fails_is_not_kept_and_can_be_added_again(
    run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lamps = str(lamp_tree(tmp_path / "lamps.glb"))
    with monkeypatch.context() as full:

        def fails(*_: object) -> None:
            raise OSError(28, "No space left on device")

        full.setattr(model, "_picture", fails)
        code, _, err = run("model", "add", lamps)
        assert code == 1 and "make room, then give the same command again" in err
    monkeypatch.setattr(model, "_picture", lambda *_: None)
    assert run("model", "add", lamps)[0] == 0


def test_a_home_that_cannot_be_read_holds_no_models(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    home = tmp_path / "home"
    home.mkdir(mode=0)
    monkeypatch.setenv("XDG_DATA_HOME", str(home))
    user = os.geteuid()
    os.seteuid(65534 if user == 0 else user)
    try:
        assert user_model_names() == ()
    finally:
        os.seteuid(user)


def test_settings_hold_the_model_and_only_that_one_will_do(preset: str, tmp_path: Path) -> None:
    chosen = load_preset(preset)
    settings = frame_settings(chosen, choose("scalar_rgb"))
    digest = settings["species"]["mill"]["model_sha256"]
    assert digest == settings["placed"]["near"]["model_sha256"]
    assert str(tmp_path) not in json.dumps(settings)
    FrameSession(settings)  # as a worker does, which knows of no folder
    (tmp_path / "mill.usda").unlink()
    FrameSession(settings)
    other = "0" * 64
    settings["species"]["mill"]["model_sha256"] = other
    with pytest.raises(InputError, match="not on this machine; bring it by"):
        FrameSession(settings)
    with pytest.raises(InputError, match="not on this machine"):
        model_by_digest("model", "lamps", other)


@pytest.mark.parametrize(
    ("setting", "rule"),
    [
        ("species.mill.model=none.usda", "a file that is there"),
        ("species.mill.prototypes=2", "one build"),
        ("species.lamps.model_sha256=" + "0" * 64, "whose SHA-256 is 000000000000"),
    ],
)
def test_what_is_no_model_is_refused_in_one_line(
    setting: str, rule: str, preset: str, run: Any
) -> None:
    code, _, err = run("count", preset, "-D", setting)
    assert (code, len(err.splitlines())) == (2, 1), err
    assert rule in err and setting.partition("=")[0].partition(".")[0] in err + "species"


ACTS = """
[terrain]
amplitude = 0
[acting]
frames = 3
[actors.mill]
model = "mill.usda"
position = [0, 20]
heading = 60
behaviour = "face_wind"
[render]
size = [16, 9]
spp = 1
"""


def test_an_imported_model_acts(tmp_path: Path, run: Any) -> None:
    """It turns into the wind, answers for its parts, is drawn, and is held to its hash."""
    mill(tmp_path / "mill.usda")
    (tmp_path / "acts.toml").write_text(ACTS)
    scene = str(tmp_path / "acts.toml")
    headings, parts = [], []
    for frame in ("1", "3"):
        code, out, err = run("ask", scene, "mill heading", "--json", "--frame", frame)
        assert code == 0, err
        headings.append(json.loads(out)["answer"])
    assert headings[0] == pytest.approx(60.0) and headings[1] != headings[0]
    code, out, err = run("ask", scene, "mill part_names", "--json")
    parts = json.loads(out)["answer"]
    assert code == 0 and parts == ["rotor"]
    target = tmp_path / "out" / "a.####.exr"
    code, out, err = run("render", scene, "-o", str(target), "--frames", "2", "--json")
    assert code == 0, err
    kept = read_whole(tmp_path / "out" / "a.0002.exr").settings
    assert len(kept["actors"]["mill"]["model_sha256"]) == 64
