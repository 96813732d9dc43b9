"""Memory: what is free, what a frame needs by its counts, and a refusal with both figures."""

import resource
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import psutil
import pytest

from lod.shapes import Triangles
from scenes.frame.frame_input import Quality
from scenes.presets.load import load_preset
from scenes.processes.memory_limit import free_bytes
from scenes.render import build, frame_session, variants
from scenes.render.exr.header import frame_settings
from scenes.render.frame_session import FrameSession
from scenes.render.memory import count_shapes, forecast, frame_bytes, predict_bytes
from scenes.scene import Scene

SIZE = 640, 360


def test_more_of_anything_needs_more_until_the_samples_go_in_groups():
    least = predict_bytes(0, 0, (16, 9), Quality("llvm_ad_rgb", 1))
    assert 300e6 < least < 600e6
    assert predict_bytes(10**6, 0, (16, 9), Quality("llvm_ad_rgb", 1)) - least == pytest.approx(
        210e6, rel=0.01
    )
    assert predict_bytes(0, 10**6, (16, 9), Quality("llvm_ad_rgb", 1)) - least == pytest.approx(
        204e6, rel=0.01
    )
    few, many, more = (
        predict_bytes(0, 0, SIZE, Quality("scalar_rgb", spp)) for spp in (1, 16, 4096)
    )
    assert few < many == more


GIB = 2**30


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> None:
    class Memory:
        available = 64 * GIB

    monkeypatch.setattr(psutil, "virtual_memory", Memory)


def own(folder: Path, line: str) -> Path:
    (folder / "own").write_text(line)
    return folder / "own"


def group(folder: Path, limit: str, used: int, cached: int, version: int = 2) -> None:
    names = ("memory.max", "memory.current", "inactive_file")
    if version == 1:
        names = ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / names[0]).write_text(f"{limit}\n")
    (folder / names[1]).write_text(f"{used}\n")
    (folder / "memory.stat").write_text(f"anon 7\n{names[2]} {cached}\n")


@pytest.mark.usefixtures("machine")
@pytest.mark.parametrize("version", [1, 2])
def test_a_container_s_limit_counts_and_file_caches_are_free(tmp_path: Path, version: int) -> None:
    root = tmp_path / "cgroups"
    line = "0::/\n" if version == 2 else "5:cpu:/\n4:memory:/\n"
    group(root if version == 2 else root / "memory", str(4 * GIB), 3 * GIB, GIB, version)
    assert free_bytes(root, own(tmp_path, line)) == 2 * GIB


@pytest.mark.usefixtures("machine")
def test_the_tightest_of_nested_groups_counts(tmp_path: Path) -> None:
    root = tmp_path / "cgroups"
    group(root / "job", str(8 * GIB), 6 * GIB, 0)
    group(root / "job" / "step", "max", GIB, 0)
    assert free_bytes(root, own(tmp_path, "0::/job/step\n")) == 2 * GIB


@pytest.mark.usefixtures("machine")
def test_a_path_of_the_host_s_leads_to_the_root_that_is_mounted(tmp_path: Path) -> None:
    root = tmp_path / "cgroups"
    group(root, str(GIB), 0, 0)
    assert free_bytes(root, own(tmp_path, "0::/docker/0123abc\n")) == GIB


@contextmanager
def room(size: int) -> Iterator[None]:
    """Let this process take so many bytes of memory for data more than it has."""
    rows = (line.split() for line in Path("/proc/self/status").read_text().splitlines())
    held = next(int(row[1]) * 1024 for row in rows if row[0] == "VmData:")
    before = resource.getrlimit(resource.RLIMIT_DATA)
    resource.setrlimit(resource.RLIMIT_DATA, (held + size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, before)


@pytest.mark.usefixtures("machine")
def test_the_process_s_own_limit_on_data_counts(tmp_path: Path) -> None:
    with room(GIB):
        assert free_bytes(tmp_path, tmp_path) == pytest.approx(GIB, rel=0.1)


def test_a_scene_for_which_the_renderer_finds_no_room_is_an_error(make, monkeypatch):
    """It would warn, and give a picture of the sky alone."""
    if (variant := variants.choose()) == variants.SCALAR_VARIANT:
        pytest.skip("no variant with a just-in-time compiler works here")
    load, ground, n = build.load_plugin, make.ground(), 10**6

    def loads(plan):
        with room(2**24) if plan["type"] == "scene" else nullcontext():
            return load(plan)

    monkeypatch.setattr(build, "load_plugin", loads)
    corners = np.random.default_rng(1).normal(size=(3 * n, 3))
    flat = np.zeros((3 * n, 3), np.float32)
    faces, owner = np.arange(3 * n).reshape(-1, 3), np.zeros(n, np.int64)
    many = replace(ground, shape=Triangles(corners, flat, flat, faces, owner))
    with pytest.raises(MemoryError, match="no memory left"):
        make.rendered(variant, many)


@pytest.mark.parametrize("copies", [0, 4])
def test_an_estimate_of_a_frame_is_what_its_input_needs(copies):
    keys = 'render.size="640x360"', f"view.copies={copies}", "species.tree.density=0.002"
    scene = Scene(load_preset("crowd", keys))
    made, view = scene.input(1, "llvm_ad_rgb"), scene.view(1)
    found = forecast(scene.world, view, from_size=scene.copied_from(view, made.quality))
    copied = sum(len(each.copies.which) for each in made.displayed if each.copies is not None)
    assert found.copies == pytest.approx(copied, rel=0.3)
    assert (copied > 0) == (copies > 0)
    needed = predict_bytes(*count_shapes(made), (640, 360), made.quality, copies=copied)
    assert 0.8 < frame_bytes(found, scene.preset, "llvm_ad_rgb") / needed < 1.3


def test_a_session_estimates_each_frame_once_and_renders_none(tmp_path, monkeypatch):
    preset, asked = load_preset("zoo", ['render.size="64x36"']), []
    monkeypatch.setattr(frame_session, "preflight", lambda scene, new, *of: asked.append(new))
    session = FrameSession(frame_settings(preset, "scalar_rgb"))
    for frames in ((1, 2), (2, 3), (3,)):
        assert session.preflight(frames, tmp_path, 16 * 10**9) == {}
    assert asked == [[1, 2], [3]]
    assert not any(tmp_path.iterdir())


_HELD = """
import sys
from pathlib import Path
from scenes.presets.load import load_preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render import memory
from scenes.render.exr.header import frame_settings
from scenes.render.frame_session import FrameSession
from scenes.scene import Scene
variant, name, *keys = sys.argv[2:]
scene, variant = Scene(load_preset(name, keys)), None if variant == "count" else variant
found = memory.preflight(scene, (1,), 10**12, variant)
print(memory.frame_bytes(found, scene.preset, variant))
if variant is None:
    cut = scene.cut(1)
else:
    path = Path(sys.argv[1]) / "a.0001.exr"
    FrameSession(frame_settings(scene.preset, variant)).render(1, path, most_bytes=0)
print(peak_rss_bytes())
"""
SMALL = 'render.size="320x180"', "render.spp=2"
HELD = [
    ("count", "crowd", "view.detail=0.3", "species.figure.density=0.05"),
    ("count", "meadow", "species.tree.sizes=[10]"),
    ("count", "zoo", "view.detail=0.6"),
    ("count", "forest"),
    ("llvm_ad_rgb", "forest", *SMALL),
    ("llvm_ad_rgb", "crowd", *SMALL, "view.detail=0.4"),
    ("scalar_rgb", "meadow", *SMALL),
    ("llvm_ad_rgb", "zoo", *SMALL, "output.motion=true"),
]


@pytest.mark.slow
@pytest.mark.parametrize("case", HELD, ids=" ".join)
def test_what_is_estimated_is_what_a_process_holds(tmp_path: Path, case: tuple[str, ...]) -> None:
    words = [sys.executable, "-c", _HELD, str(tmp_path), *case]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stdout.split()
    assert 0.9 < int(said[-2]) / int(said[-1]) < 1.3
