"""The full benchmark: the detail of equal error, the largest world, and what it tells of growth."""

import json
from contextlib import ExitStack
from dataclasses import asdict, replace

import numpy as np
import psutil
import pytest
from click.testing import CliRunner

from bench.experiments.fidelity.scene import SPECIES
from bench.fields.windows import Picture
from bench.records.points import Point, columns, point_from_json, where
from bench.statistics.estimates import two_sided_factor
from bench.statistics.excess_flip import one_sided_excess
from bench.studies.full import study as full_study
from bench.studies.full.equal_error_detail import detail_at_equal_error, search_detail
from bench.studies.full.report import growth, plots, ratios, results_table, summary_text
from bench.studies.full.study import command, write_results
from bench.studies.full.timed_frames import (
    FILLED,
    FrameProcess,
    TooLarge,
    largest_world,
    start_process,
)
from bench.studies.full.worlds import KINDS, QUICK, limit_distance, world_preset
from lod.errors import InputError

PAIRS = 8
SMALL = Picture("16x9", 1)
FEW = ("species.figure.prototypes=1", "species.figure.sizes=[1.0]")
"""People that are made in no time."""


def planted(at_px, power=1.5):
    """Excess FLIP of 0.01·(τ/at_px)^power over a floor of 0.005, and a little noise."""

    def at(detail):
        noise = np.random.default_rng(round(1e6 * detail)).normal(0, 20, PAIRS)
        flip = 5000 + 1e4 * (detail / at_px) ** power + noise
        samples = {"flip": flip.round().astype(int).tolist(), "flip_floor": [5000] * PAIRS}
        case = {"metric": "blake", "detail": detail, "pruned": SPECIES}
        return Point(case, samples=columns({**samples, "parts": [round(1e6 / detail**2)]}))

    return at


@pytest.mark.parametrize("at_px", [0.3, 1.9, 2.1, 11.0])
def test_the_detail_of_equal_error_is_found(at_px):
    points = search_detail(planted(at_px), 2.0, 2)
    found = detail_at_equal_error(points)
    assert found.low <= found.value <= found.high
    assert found.value == pytest.approx(at_px, rel=0.01)
    nearest = sorted(abs(np.log(p.case["detail"] / at_px)) for p in points)
    assert nearest[1] < np.log(2) / 2


@pytest.mark.parametrize("at_px", [0.01, 100.0])
def test_an_error_that_is_never_there_is_said_in_one_line(at_px):
    with pytest.raises(InputError, match=r"0\.01 from 0\.0625 to 32 px"):
        search_detail(planted(at_px), 2.0, 0)


def runner(peak):
    return FrameProcess({"peak_rss_bytes": peak}, lambda frame: {})


def test_the_largest_world_fills_the_memory_that_there_is():
    objects, found = largest_world((100, 200), (30, 40), 100, lambda n: runner(20 + 0.1 * n))
    assert objects == pytest.approx(750) and found.peak_bytes == pytest.approx(100 * FILLED, abs=1)


def test_a_world_that_takes_more_than_foretold_is_made_smaller_until_it_fits():
    tried = []

    def start(objects):
        tried.append(objects)
        peak = 20 + 0.1 * objects + (objects / 800) ** 2 * 30
        if peak > 100:
            raise TooLarge
        return runner(peak)

    objects, found = largest_world((100, 200), (30, 40), 100, start)
    assert len(tried) > 1 and objects == tried[-1] < tried[0] and found.peak_bytes <= 100


def test_a_process_that_holds_too_much_is_ended(tmp_path):
    preset = world_preset(KINDS["crowd"], 30.0, SMALL, None)
    with ExitStack() as stack, pytest.raises(TooLarge):
        start_process(stack, tmp_path, preset, 1)
    assert not psutil.Process().children()


def test_worlds_hold_as_many_objects_as_they_say_and_the_ground_ends_with_them():
    kind = KINDS["meadow"]
    whole, pruned = (world_preset(kind, 3e3, SMALL, each) for each in (None, 1.7))
    density = sum(each.density for each in whole.species.values())
    assert whole.world.extent**2 * density == pytest.approx(3e3)
    assert whole.terrain.reach == pytest.approx(whole.world.extent / 2**0.5)
    assert (whole.view.metric, pruned.view.metric, pruned.view.detail) == ("full", "blake", 1.7)
    assert whole.model_copy(update={"view": pruned.view}) == pruned
    crowd = world_preset(KINDS["crowd"], 1e12, SMALL, 1.0)
    assert crowd.terrain.reach == 40_000 and crowd.species["tree"].density == 0
    assert all(each.patrol for each in crowd.species.values() if each.density)


def test_the_limit_grows_as_the_detail_becomes_finer():
    few = replace(KINDS["crowd"], settings=(*KINDS["crowd"].settings, *FEW))
    coarse, fine = (limit_distance(few, SMALL, each) for each in (4.0, 2.0))
    assert fine == pytest.approx(2 * coarse, rel=0.05)


def world(metric, objects, seconds, megabytes, sticks):
    turn = np.array([0.98, 1.0, 1.02])
    micros = (1e6 * seconds * turn).round().astype(int).tolist()
    case = {"metric": metric, "objects": objects, "side_m": objects**0.5, "limit_m": 40.0}
    times = dict.fromkeys(("wall_us", "cpu_us", "trace_us"), micros)
    samples = {**times, "peak_bytes": [round(1e6 * megabytes)]}
    return Point(case, samples=columns({**samples, "sticks": [sticks]}))


def told(power=0.0):
    """Whole frames of 1 s + 1 ms an object, pruned ones of 2 s beyond the limit, times N^power."""
    sizes = (1e3, 1e4, 1e5, 1e6)
    full = [world("full", n, 1 + n / 1e3, 300 + n / 1e2, round(100 * n)) for n in sizes]
    cut = [world("blake", n, 2 * (n / 1e4) ** power, 400, 5000) for n in (*sizes, 1e9)]
    tau = asdict(detail_at_equal_error(search_detail(planted(3.0), 2.0, 1)))
    again = {"objects": 1e4, **asdict(one_sided_excess(np.full(8, 0.02), np.full(8, 0.01)))}
    return {
        "kind": "crowd",
        "effort": {"picture": {"size": "320x180", "spp": 64}},
        "tau_px": tau["value"],
        "search": {"detail": tau, "objects": 1e3, "spp": 64, "tried": {}, "confirmed": again},
        "points": [asdict(each) for each in (*full, *cut)],
    }


def test_growth_is_told_beyond_the_limit_and_of_what_is_added():
    found = growth(told())
    time, cpu, memory, added, added_cpu, added_bytes, ratio, ratio_cpu, ratio_bytes = found.values()
    assert (cpu, added_cpu, ratio_cpu) == (time, added, ratio)
    assert "3 worlds beyond" in next(iter(found))
    assert abs(time.value) < 0.01 and time.low <= 0 <= time.high
    assert memory.value == pytest.approx(0, abs=1e-9)
    assert added.value == pytest.approx(1.0, abs=0.02)
    assert added_bytes.value == pytest.approx(1.0, abs=1e-6)
    assert 0.5 < ratio.value < 1 and 0 < ratio_bytes.value < ratio.value
    assert next(iter(growth(told(0.1)).values())).low > 0.05


def test_ratios_are_of_the_same_turn_and_the_table_says_where_pruning_costs_more():
    data = told()
    assert ratios(data)[1e3] == pytest.approx([1.0] * 3)
    assert two_sided_factor(ratios(data)[1e6]).value == pytest.approx(1001 / 2, rel=1e-5)
    rows = results_table(data).splitlines()
    assert len(rows) == 6 and " – " in rows[-1] and "0.78" in rows[1]
    assert "excess FLIP 0.01" in summary_text(data) and "0.0100" in summary_text(data)


def test_few_worlds_tell_no_growth():
    data = told()
    data["points"] = [p for p in data["points"] if p["case"]["objects"] in (1e3, 1e4)]
    assert set(growth(data).values()) == {None}
    assert "too few worlds" in summary_text(data)


def test_numbers_and_figures_are_kept_whole(tmp_path):
    write_results(tmp_path, told())
    names = {path.name for path in tmp_path.iterdir()}
    assert names == {"crowd.json", *(f"crowd-{k}.svg" for k in ("time", "memory", "ratio"))}
    assert json.loads((tmp_path / "crowd.json").read_text())["tau_px"] == told()["tau_px"]
    assert all(len(each.alt) > 80 and each.drawn for each in plots(told()))


def planted_start(folder):
    def start(stack, _, preset, most_bytes):
        whole = preset.view.metric == "full"
        held = round(1e8 + preset.world.extent**2 * 1000 * whole)
        seconds = {"trace": 0.01, "prune": 0.001}
        drawn = {"sticks": held}
        record = {
            "wall": 0.02,
            "cpu": 0.03,
            "seconds": seconds,
            "peak_rss_bytes": held,
            "statistics": drawn,
        }
        if held > most_bytes:
            raise TooLarge
        return FrameProcess(record, lambda frame: record)

    return start


def test_the_command_measures_prints_and_keeps(monkeypatch, tmp_path):
    monkeypatch.setattr(full_study, "start_process", planted_start(tmp_path))
    monkeypatch.setattr(full_study, "limit_distance", lambda kind, picture, detail: 100.0)
    words = ["crowd", "--detail", "3", "--turns", "3", "-o", str(tmp_path)]
    said = CliRunner().invoke(command, words)
    assert said.exit_code == 0, said.output
    found = json.loads((tmp_path / "crowd.json").read_text())
    kind = KINDS["crowd"]
    points = [point_from_json(each) for each in found["points"]]
    full, cut = where(points, metric="full"), where(points, metric="blake")
    assert len(full) == len(kind.worlds) + 1 and len(cut) == len(full) + len(kind.beyond)
    assert 0.8 * 8e9 < full[-1].column("peak_bytes")[0] <= 8e9
    assert all(len(each.column("wall_us")) == 3 for each in (*full, *cut))


@pytest.mark.parametrize(
    "words, said",
    [
        (["--max-memory", "8"], "above 0, in MB"),
        (["village"], "village"),
        (["--turns", "1"], "turns"),
        (["crowd", "--detail", "-2"], "detail"),
        (["crowd", "--detail", "2", "--size", "big"], "render.size"),
    ],
)
def test_bad_input_is_one_line_and_two(words, said):
    found = CliRunner().invoke(command, words)
    assert found.exit_code == 2 and said in found.output
    assert "Traceback" not in found.output


@pytest.mark.slow
def test_the_quick_run_renders_real_frames(tmp_path):
    said = CliRunner().invoke(command, ["crowd", "--quick", "-o", str(tmp_path)])
    assert said.exit_code == 0, said.output
    found = json.loads((tmp_path / "crowd.json").read_text())
    assert found["tau_px"] > 0 and len(found["points"]) == 2 * len(QUICK["crowd"].worlds)
    for point in found["points"]:
        samples = {each["quantity"]: each["values"] for each in point["samples"]}
        assert min(samples["trace_us"]) > 0 and min(samples["build_us"]) > 0
        assert samples["peak_bytes"][0] > 1e8
