"""The names that `import lodbench` promises do what they say."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import lodbench
from scenes.render.pictures import preview

ROOT = str(Path(lodbench.__file__).parent)

TINY = {
    "render.size": "32x18",
    "render.spp": 4,
    "render.variant": "scalar_rgb",
    "species.tree.density": 0,  # or every process would measure how light passes a forest
    "species.conifer.density": 0,
}


@pytest.fixture(scope="module")
def campfire() -> lodbench.Preset:
    return lodbench.load_preset("campfire", TINY)


@pytest.fixture(scope="module")
def folder(campfire: lodbench.Preset, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Frames 1 and 2, asked for as an array."""
    made = tmp_path_factory.mktemp("frames")
    assert len(list(lodbench.render_sequence(campfire, made / "a.####.exr", np.arange(1, 3)))) == 2
    return made


def test_a_frame_in_memory_is_the_frame_of_the_file(
    campfire: lodbench.Preset, tmp_path: Path
) -> None:
    frame = lodbench.render(campfire, 2)
    records = list(lodbench.render_sequence(campfire, tmp_path / "a.####.exr", (2,)))
    read = lodbench.read_frame(records[0]["path"])
    for name in ("Z", "object", "part", "level"):
        assert np.array_equal(getattr(read.layers, name), getattr(frame.layers, name))
    for name in ("rgb", "N", "albedo"):  # as halves at the least
        assert np.allclose(getattr(read.layers, name), getattr(frame.layers, name), 1e-3, 1e-4)
    preview(records[0]["path"], tmp_path / "a.png")
    assert np.array_equal(read.preview(), np.asarray(Image.open(tmp_path / "a.png")))
    assert read.preview(view="level").shape == (18, 32, 3)
    ours = {name for name in read.header if name.startswith("lod:")}
    assert ours - set(frame.header) == {"lod:pixels_sha256", "lod:file_sha256"}


def test_counts_take_a_name_or_a_preset(campfire: lodbench.Preset) -> None:
    by_name, by_preset = (
        lodbench.count("campfire"),
        lodbench.count(lodbench.load_preset("campfire")),
    )
    assert by_name.parts == by_preset.parts
    assert by_name.parts.displayed > 0


def test_what_cannot_be_is_one_error_that_names_the_key() -> None:
    with pytest.raises(lodbench.InputError, match=r"camera\.fov"):
        lodbench.load_preset("meadow", {"camera.fov": 200})
    with pytest.raises(lodbench.InputError, match="no preset"):
        lodbench.count("medow")
    with pytest.raises(lodbench.InputError, match="did you mean haze"):
        lodbench.run_experiment("hase")


def test_every_name_is_there_and_none_brings_the_renderer() -> None:
    code = (
        "import sys, lodbench; "
        "heavy = {'mitsuba', 'drjit', 'OpenEXR', 'matplotlib', 'numba.core', 'statsmodels'}; "
        "print(*sorted(heavy & set(sys.modules))); "
        "assert all(hasattr(lodbench, n) for n in lodbench.__all__)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""


def test_a_notebook_shows_a_bar(
    campfire: lodbench.Preset, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "ipykernel", sys)
    lodbench.render(campfire)
    assert "samples: 100%" in capsys.readouterr().err


@pytest.mark.parametrize(
    "frames",
    [np.arange(1, 3), (k for k in (1, 2)), [np.int64(1), np.uint8(2), 1], range(1, 3)],
    ids=["array", "generator", "numbers", "range"],
)
def test_frames_are_any_whole_numbers(frames: Any, campfire: lodbench.Preset, folder: Path) -> None:
    records = list(lodbench.render_sequence(campfire, folder / "a.####.exr", frames))
    assert [(each["frame"], each["kept"]) for each in records] == [(1, True), (2, True)]
    assert json.dumps(records)


@pytest.mark.parametrize(
    "frames", [[], [0], [-3], [1.0], ["1"], 1, "1-2", [10**6], range(1, 10**12), [True, None]]
)
def test_what_are_no_frames_is_refused(
    frames: Any, campfire: lodbench.Preset, tmp_path: Path
) -> None:
    with pytest.raises(lodbench.InputError, match="frames"):
        lodbench.render_sequence(campfire, tmp_path / "a.####.exr", frames)
    for one in (0, -5, 1.5, "1"):
        for call in (lodbench.count, lodbench.render):
            with pytest.raises(lodbench.InputError, match=r"^frame: "):
                call(campfire, one)
    assert not list(tmp_path.iterdir())


def test_keys_take_what_numpy_has_and_paths(tmp_path: Path) -> None:
    plain = {"render.size": [64, 36], "render.spp": 3, "view.haze_aware": True, "seed": 7}
    plain["camera.position"] = [1.0, 2.5]
    numpy = {
        "render.size": np.array([64, 36]),
        "render.spp": np.int64(3),
        "view.haze_aware": np.bool_(True),
        "seed": np.uint64(7),
        "camera.position": np.array([1.0, 2.5], np.float32),
    }
    assert lodbench.load_preset("crowd", numpy) == lodbench.load_preset("crowd", plain)
    (tmp_path / "own.toml").write_text("seed = 3")
    own = lodbench.count(tmp_path / "own.toml")
    assert own.parts == lodbench.count(str(tmp_path / "own.toml")).parts


def test_the_folder_is_that_of_the_call(
    campfire: lodbench.Preset, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "elsewhere").mkdir()
    records = lodbench.render_sequence(campfire, "out/a.####.exr", (1, 2))
    os.chdir("elsewhere")
    found = []
    for record in records:
        found.append(Path(record["path"]))
        os.chdir(tmp_path if len(found) % 2 else tmp_path / "elsewhere")
    assert found == [tmp_path / "out" / f"a.000{k}.exr" for k in (1, 2)]
    assert all(path.is_file() for path in found)
    assert not list((tmp_path / "elsewhere").iterdir())


def test_mitsuba_stays_the_callers(campfire: lodbench.Preset) -> None:
    import mitsuba

    before = mitsuba.variant()
    mitsuba.set_variant("scalar_spectral")
    try:
        lodbench.render(campfire)
        assert mitsuba.variant() == "scalar_spectral"
    finally:
        if before:
            mitsuba.set_variant(before)


def test_it_needs_no_stdout(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdout", None)
    assert lodbench.read_frame(folder / "a.0001.exr").layers.Z.shape == (18, 32)


@pytest.mark.parametrize("name", ["scenes/__init__.py", "bench/__init__.py", "bench.py"])
def test_a_package_of_the_callers_is_named(name: str, tmp_path: Path) -> None:
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).touch()
    (tmp_path / "use.py").write_text("import lodbench")
    words, paths = [sys.executable, "use.py"], {**os.environ, "PYTHONPATH": ROOT}
    done = subprocess.run(words, capture_output=True, text=True, cwd=tmp_path, env=paths)
    assert done.returncode == 1
    assert f"{tmp_path / name} hides a package of lodbench" in done.stderr.splitlines()[-1]
