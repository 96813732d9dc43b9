"""The study of grass: what it says where the answer is known."""

import importlib.util
import json
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bench.records.study_record import StudyRecord, write_study_record
from bench.studies.grass import frames, study
from bench.studies.grass.counts import DENSITIES, grass_alone, measure, measure_apart
from bench.studies.grass.edge import EDGES_M, Outlook, edge_figures
from bench.studies.grass.frames import WARM, WITH, WITHOUT, frame_figures, turns_of_frames
from scenes.processes.memory_limit import VARIABLE
from scenes.render.variants import choose

SMALL = ("render.size=64x36",)


def frame(cpu: float, peak: float) -> dict[str, float]:
    return {
        "cpu_s": cpu,
        "wall_s": cpu / 2,
        "frame_s": cpu / 2 - 1,
        "peak_gb": peak,
        "sticks": 10,
        "triangles": 20,
    }


def test_sides_take_turns_and_a_ratio_is_of_one_turn(monkeypatch: pytest.MonkeyPatch) -> None:
    """The machine slows down from turn to turn: ratios do not show it."""
    asked: list[tuple[str, str]] = []

    def render(side: str, size: str, spp: int, variant: str) -> dict[str, float]:
        asked.append((side, size))
        slow = 10 ** ((len(asked) - 1) // 2)
        return frame(slow * (3.0 if side == WITH else 2.0), 1.8 if side == WITH else 0.9)

    monkeypatch.setattr(frames, "render", render)
    found = turns_of_frames("1280x720", 64, 3, "llvm_ad_rgb")
    assert [side for side, _ in asked] == 2 * [WITHOUT, WITH] + [WITH, WITHOUT, WITHOUT, WITH]
    assert [size for _, size in asked] == 2 * [WARM[0]] + 6 * ["1280x720"]
    for name, ratio in (("cpu_s", 1.5), ("peak_gb", 2.0)):
        row = frame_figures(found)["ratio"][name]
        assert row == pytest.approx(dict.fromkeys(("median", "least", "greatest"), ratio))


def test_grass_alone_is_as_dense_and_in_the_metric_that_is_asked() -> None:
    (grass,) = grass_alone(0.5, "solid_angle").species.values()
    assert (grass.model, grass.density, grass.metric) == ("sward", 0.5, "solid_angle")
    assert grass_alone(0.5, None).species["sward"].metric == "bounded", "as in the preset"


@pytest.mark.parametrize("density", DENSITIES)
def test_every_density_of_the_study_is_one_that_a_preset_may_have(density: float) -> None:
    assert grass_alone(density, "blake").species["sward"].density == density


def test_ten_times_the_tufts_are_ten_times_the_parts_and_blake_keeps_most() -> None:
    few, many = (measure(each, "blake", SMALL, choose()) for each in (0.2, 2.0))
    assert many["parts"] == pytest.approx(10 * few["parts"], rel=0.2)
    assert many["prune_s"] > 0 and many["pose_s"] > 0 and many["peak_bytes"] > 1e8
    bounded, angle = (measure(2.0, each, SMALL, choose()) for each in ("bounded", "solid_angle"))
    assert many["parts"] > 5 * bounded["parts"] > 5 * angle["parts"] > 0


def test_what_does_not_fit_is_not_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a process of its own, which has a limit; and what can be counted may not be posed."""
    words = {"density": 0.5, "metric": "blake", "variant": choose()}
    words |= {"settings": ("render.size=320x180", "render.spp=16")}
    monkeypatch.setenv(VARIABLE, "100000000")
    found = measure_apart(words)
    assert set(found) == {"refused", "frame_bytes"} and "needs about" in found["refused"]
    monkeypatch.setenv(VARIABLE, f"{found['frame_bytes'] - 1}")
    found = measure_apart(words)
    assert found["parts"] > 1000 and found["pose_s"] is None


def test_a_count_that_is_killed_is_a_row(monkeypatch: pytest.MonkeyPatch) -> None:
    killed = subprocess.CompletedProcess([], -signal.SIGKILL, "")
    monkeypatch.setattr(subprocess, "run", lambda *words, **more: killed)
    assert "killed" in measure_apart({})["refused"]


def test_luminance_is_compared_ray_by_ray_and_empty_bands_have_none() -> None:
    """Two fields of two bands: half as many rays, each 10 % brighter; nothing in the second."""
    fine = np.array([[[20.0, 5.0], [10.0, 5.0]], [[60.0, 5.0], [20.0, 5.0]]])
    tested = np.array([[[11.0, 0.0], [5.0, 0.0]], [[33.0, 5.0], [10.0, 5.0]]])
    near, far = edge_figures(tested, fine)
    assert near["luminance"] == pytest.approx(1.1) == near["low"] and near["rays"] == 0.5
    assert set(far.values()) == {None}
    (alone, _) = edge_figures(tested[:1], fine[:1])
    assert alone["luminance"] == pytest.approx(1.1) and alone["low"] is None


FIGURES = {
    "frames": frame_figures({WITHOUT: [frame(8.0, 0.5)], WITH: [frame(20.0, 1.5)]}),
    "counts": [
        {"density": 12.5, "metric": "bounded", "parts": 800_000, "objects": 100_000}
        | {"peak_bytes": 4e8, "prune_s": 0.25, "pose_s": 0.5, "frame_bytes": 9e8},
        {"density": 12.5, "metric": "blake", "parts": 24_000_000, "objects": 1_000_000}
        | {"peak_bytes": 4e9, "prune_s": 2.5, "pose_s": None, "frame_bytes": 9e10},
        {"density": 125.0, "metric": "blake", "refused": "too much", "frame_bytes": 9e11},
    ],
    "edge": {
        "before it": [{"luminance": 1.25, "low": 1.2, "high": 1.3, "rays": 0.75}]
        + [dict.fromkeys(("luminance", "low", "high", "rays"))] * (len(EDGES_M) - 2)
    },
}


def test_the_page_has_tables_of_the_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = Path(__file__).parents[3] / "docs" / "write_figures.py"
    spec = importlib.util.spec_from_file_location("write_figures", path)
    assert spec and spec.loader
    writer = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(writer)
    settings = {"preset": "meadow", "size": "1280x720", "spp": 64, "turns": 3, "fields": 4}
    settings |= {"width": 640, "count_size": "640x360"}
    made_by = {"cores": 2, "cpu": "a processor", "commit": 40 * "a"}
    record = StudyRecord("grass", settings, FIGURES, made_by)
    write_study_record(tmp_path / "grass.json", record)
    monkeypatch.setattr(writer, "STUDIES", tmp_path)
    text = writer.filled("<!-- figures: grass -->\n<!-- end of figures -->\n")
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert any("2.50 (2.50 to 2.50)" in row and "3.00" in row for row in rows), "ratios"
    assert any("24,000,000" in row and "| - |" in row for row in rows)
    assert "| 125 | blake | does not fit | - | - | - |" in rows
    assert any("1.250 (1.200 to 1.300)" in row and "0.75" in row for row in rows)


@pytest.mark.slow
def test_a_quick_run_leaves_a_record(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "HEADINGS_DEG", {"before it": 250.0})
    path = tmp_path / "grass.json"
    done = CliRunner().invoke(study.command, ["--quick", "--record", str(path)])
    assert done.exit_code == 0, done.output
    found = json.loads(path.read_text(encoding="utf-8"))["figures"]
    assert found["frames"][WITH]["peak_gb"]["median"] > 0.2
    assert len(found["counts"]) == 6 and found["counts"][3]["parts"] > 1000
    assert len(found["edge"]["before it"]) == len(EDGES_M) - 1


@pytest.mark.slow
def test_across_its_limit_grass_is_about_as_bright_as_at_finer_detail() -> None:
    """Within 20 %, where 5 % is asked: docs/presets.md has the figures. Sun behind and before."""
    variant = choose()
    for heading in (70.0, 250.0):
        look = Outlook(160, heading, 1)
        tested, fine = (look.sums(each, variant)[None] for each in (1.0, 0.25))
        bands = edge_figures(tested, fine)
        assert max(abs(each["luminance"] - 1) for each in bands) < 0.2, "without far cover 0.9"
        other = edge_figures(look.sums(0.25, variant, 100)[None], fine)
        assert max(abs(each["luminance"] - 1) for each in other) < 0.05, "other samples"
