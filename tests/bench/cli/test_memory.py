"""What a command would need is estimated, and refused before it is taken: one line, exit code 2."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NoReturn

import psutil
import pytest

from lod.errors import InputError
from scenes import scene as scenes_scene
from scenes.processes import memory_limit
from scenes.render import render as stages
from scenes.render.memory import preflight
from scenes.scene import Scene
from scenes.world import cast
from tests.said import said

GB = 10**9
Run = Callable[..., tuple[int, str, str]]


def began(*_: object) -> NoReturn:
    """Stand in for what no refused command begins: without its check a test ends here, at once."""
    raise AssertionError("it began without being estimated")


@pytest.fixture
def run(capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    """Run a command on a machine with 4 GB free, what this process holds included."""
    monkeypatch.chdir(tmp_path)
    held = psutil.Process().memory_info
    monkeypatch.setattr(memory_limit, "free_bytes", lambda: 4 * GB - held().rss)
    return partial(said, capfd)


FOREST = "species.tree.sizes="
REFUSED = [
    ("count", "meadow", "-D", f"{FOREST}[1000]"),
    ("count", "meadow", "-D", "camera.fov=0.001"),
    ("count", "meadow", "--size", "16384x1", "--detail", "0.3"),
    ("usd", "meadow", "-o", "a.usda", "--density", "tree=100"),
]


@pytest.mark.parametrize("arguments", REFUSED, ids=" ".join)
def test_what_needs_more_than_is_free_is_refused(
    run: Run, tmp_path: Path, arguments: tuple[str, ...]
) -> None:
    code, out, err = run(*arguments)
    assert (code, out) == (2, "")
    assert err.startswith("lodbench: error: --max-memory: ") and len(err.splitlines()) == 1
    assert "80% of what is free" in err and "needs about" in err
    assert "--max-parts" in err and "--max-memory 0" in err
    assert list(tmp_path.iterdir()) == []


def test_many_prototypes_are_refused_before_they_are_made(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scenes_scene, "model_prototypes", began)
    sizes = ",".join(str(1 + k / 64) for k in range(64))
    prototypes = ("-D", "species.tree.prototypes=256", "-D", f"{FOREST}[{sizes}]")
    code, _, err = run("count", "meadow", *prototypes)
    assert code == 2
    assert "16384 prototypes of tree need about" in err


def test_a_detail_that_no_ground_can_have_is_refused(run: Run) -> None:
    code, _, err = run("count", "meadow", "--detail", "1e-9")
    assert code == 2
    assert "240000 tiles" in err and "raise --detail" in err


def test_a_budget_of_parts_that_memory_cannot_hold_is_refused(run: Run) -> None:
    budget = "1000000000"
    code, _, err = run("count", "crowd", "--visibility", "clear", "--max-parts", budget)
    assert code == 2
    assert err.startswith(f"lodbench: error: --max-parts: {budget}: so many parts need about")
    assert "try --max-parts" in err


THRONG = """
[troupes.walker]
model = "figure"
count = 2
side = 1000
[actors.oak]
model = "tree"
position = [0, 9]
"""
OVER = {
    "actors": ("-D", "troupes.walker.count=100000"),
    "trees": ("-D", "troupes.walker.model=tree", "-D", "troupes.walker.count=1000"),
    "prototypes": ("-D", "actors.oak.prototype=256"),
    "frames": ("-D", "acting.frames=1000000", "-D", "troupes.walker.count=20"),
}
ACTING = {
    "act": ("-o", "out"),
    "ask": ("walker_1 heading",),
    "count": (),
    "render": ("-o", "out/a.####.exr"),
}


KEEP_FRAMES = ("act", "render")
"""Commands that hold all the frames that are acted, not one after the other."""


@pytest.mark.parametrize(
    ("command", "much"),
    [("act", "frames"), ("ask", "actors"), ("count", "trees"), ("render", "prototypes")],
)
def test_actors_are_estimated_before_they_act(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str, much: str
) -> None:
    (tmp_path / "throng.toml").write_text(THRONG)
    monkeypatch.setattr(cast, "preset_roles", began)
    code, out, err = run(command, "throng.toml", *ACTING[command], *OVER[much])
    assert (code, out) == (2, "")
    assert err.startswith("lodbench: error: --max-memory: ") and len(err.splitlines()) == 1
    assert "80% of what is free" in err and " actors" in err and "need about" in err
    assert "ask for fewer actors" in err and "--max-memory 0" in err
    assert ("acting.frames" in err) == (command in KEEP_FRAMES)
    assert [each.name for each in tmp_path.iterdir()] == ["throng.toml"]


def test_a_repair_estimates_the_actors_of_its_frames(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the process that renders, by the settings on record."""
    from scenes import scene
    from scenes.presets.load import load_preset
    from scenes.render import frame_session
    from scenes.render.exr.header import frame_settings

    (tmp_path / "throng.toml").write_text(THRONG)
    monkeypatch.setattr(scene, "build_world", began)
    monkeypatch.setattr(frame_session, "replayed", began)
    chosen = load_preset("throng.toml", [OVER["frames"][1], OVER["frames"][3]])
    session = frame_session.FrameSession(frame_settings(chosen, "scalar_rgb", "0" * 64))
    with pytest.raises(InputError, match="21 actors in 1,000,001 frames need about"):
        session.preflight([1], tmp_path)
    with pytest.raises(InputError, match="21 actors in 1,000,001 frames need about"):
        session.render(1, tmp_path / "a.0001.exr")


def test_usual_casts_fit(run: Run) -> None:
    preflight(Scene("playground"), (), GB // 5, acted=240)
    preflight(Scene("fly_in"), (), GB // 500, acted=240)
    code, _, err = run("ask", "fly_in", "joe heading", "--max-memory", "0.2MB")
    assert (code, "--max-memory: '0.2 MB': " in err) == (2, True)
    assert run("ask", "fly_in", "joe heading", "--json")[0] == 0


@pytest.mark.parametrize(
    "words",
    [
        ("run", "tracing", "--quick", "-o", "out", "--max-memory", "200MB"),
    ],
    ids=" ".join,
)
def test_experiments_estimate_each_picture(
    run: Run, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    monkeypatch.setenv("LODBENCH_MAX_MEMORY", "")
    monkeypatch.setattr(stages, "describe_frame", began)
    code, _, err = run(*words)
    last = err.splitlines()[-1]
    assert code == 2 and last.startswith("lodbench: error: --max-memory: '200 MB': the picture, ")
    assert "needs about" in last and "--max-memory 0" in last
    assert memory_limit.memory_limit() == memory_limit.MemoryLimit(200 * 10**6, "200 MB")


def test_a_limit_is_told_as_it_was_given_and_none_lifts_it(run: Run) -> None:
    code, _, err = run("count", "crowd", "--max-memory", "1MB")
    assert (code, "--max-memory: '1 MB': " in err) == (2, True)
    assert run("count", "crowd", "--max-memory", "0", "--json")[0] == 0


@pytest.mark.parametrize("name", ["meadow", "crowd", "aerial"])
def test_usual_presets_fit_into_4_gb(run: Run, name: str) -> None:
    from scenes.presets.load import load_preset

    # Woods at one pixel: 42 million parts at 1920x1080; grass: 12 million, in 6 GB. At 640x360
    # `aerial` is estimated to need 4.04 GB, and takes 3.5.
    sizes = {"aerial": "600x338", "meadow": "1120x630"}
    size = sizes.get(name, "1920x1080")
    preset = load_preset(name, [f'render.size="{size}"'])
    preflight(Scene(preset), (1,), 4 * GB, "llvm_ad_rgb")
