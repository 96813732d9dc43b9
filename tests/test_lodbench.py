"""The names that `import lodbench` promises do what they say."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import lodbench
from scenes.render.pictures import preview

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


def test_the_module_runs_the_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "lodbench", "list", "-h"], capture_output=True, text=True, check=True
    )
    assert done.stdout.startswith("Usage: lodbench list")
