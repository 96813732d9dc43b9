"""Cost and world: what they claim follows from their samples, and the tables tell them."""

from dataclasses import replace

import numpy as np
import pytest

from bench.experiment import experiments
from bench.experiments.cost import measure as cost_experiment
from bench.experiments.cost.claims import SET_UP, STAGES, judge_sizes, own_frame_us
from bench.experiments.cost.claims import judge as judge_cost
from bench.experiments.cost.measure import Size, measure_size
from bench.experiments.world import measure as world_experiment
from bench.experiments.world.claims import beyond_limit
from bench.experiments.world.claims import judge as judge_world
from bench.frame_costs import preset_costs
from bench.records.provenance import provenance
from bench.records.records import Column, Point, Record, columns
from scenes.render.variants import choose

EXPERIMENTS = experiments()


def frames(**share):
    """Twelve frames of 1 s, of which stages take these shares, and eight processes."""
    chance = np.random.default_rng(0)
    noise = chance.normal(1, 0.02, 12)
    stages = {**dict.fromkeys(STAGES, 0.0), "trace": 1 - sum(share.values()), **share}
    times = {k: [round(1e6 * v * n) for n in noise] for k, v in stages.items()}
    times["metric"] = [round(n / 100) for n in times["prune"]]
    times["haze"] = [0] * 12
    warm = tuple(Column("us", row, {"stage": stage}) for stage, row in times.items())
    cold = {"world": [2_000_000] * 8, "first_trace": [1_500_000] * 8}
    cold |= {f"{k}_bytes": [10**9] * 8 for k in ("world", "shoot", "render")}
    named = ({"what": each} for each in ("frames", "processes"))
    return tuple(map(Point, named, ((), ()), (warm, columns(cold))))


def size(side, trace, set_up, error=0.004, megabytes=500, kind="meadow"):
    """Both fields of one side of a world, two frames each, with a spread of a hundredth."""
    spread = np.array([0.99, 1.01] * 2)
    stages = {**dict.fromkeys(SET_UP, set_up / 4), "trace": trace}
    times = [
        Column("us", np.rint(1e6 * v * spread).astype(int).tolist(), {"stage": k})
        for k, v in stages.items()
    ]
    counted = columns({"peak_bytes": [megabytes * 10**6, megabytes * 10**6 + 1000]})
    flip = [
        Column(
            "flip_ppm", [round(1e6 * (error + 0.1 / n**0.5)) + k for k in (0, 5)], {"samples": n}
        )
        for n in (16, 64)
    ]
    case = {"what": "size", "kind": kind, "objects": 1e4, "side": side}
    return Point(case, samples=(*times, *counted, *(flip if side == "pruned" else ())))


@pytest.mark.parametrize(
    ("kind", "trace", "error", "refuted"),
    [
        ("crowd", 1.0, 0.004, set()),
        ("meadow", 1.0, 0.004, {"frame"}),
        ("crowd", 0.5, 0.02, {"trace", "error"}),
    ],
)
def test_both_sides_of_a_world_are_compared_stage_by_stage(kind, trace, error, refuted):
    """A whole world is set up in 9 s and traced in 1 s; where nothing moves it is set up once."""
    sides = (
        size("whole", 1.0, 9.0, megabytes=2000, kind=kind),
        size("pruned", trace, 0.2, error, kind=kind),
    )
    claims = {c.name.rpartition("/")[2]: c for c in judge_sizes(sides)}
    assert set(claims) == {"trace", "frame", "set_up", "memory", "error"}
    assert {name for name, c in claims.items() if c.verdict == "refuted"} == refuted
    assert claims["memory"].measured == pytest.approx(0.25, rel=1e-3)
    assert claims["set_up"].measured == pytest.approx(0.2 / 9, rel=0.01)
    assert claims["frame"].measured == pytest.approx(
        1.2 if kind == "meadow" else (trace + 0.2) / 10
    )
    assert claims["error"].measured == pytest.approx(error, rel=0.01)


@pytest.mark.slow
def test_a_small_world_is_measured_on_both_sides():
    case = Size("meadow", 20.0, 0, False, "32x18", 4, 1, (4, 16), choose())
    whole, pruned = measure_size(case, 0)
    assert whole.case["side"] == "whole" and pruned.case["side"] == "pruned"
    assert pruned.column("sticks")[0] < whole.column("sticks")[0]
    for point in (whole, pruned):
        assert all(point.column("us", stage=stage)[0] > 0 for stage in ("prune", "build", "trace"))
    assert len(pruned.column("flip_ppm", samples=16, number=1)) == 1


def test_shares_of_a_frame_are_judged():
    held = {c.name: c for c in judge_cost(frames(prune=0.05, build=0.3))}
    assert {c.verdict for c in held.values()} == {"holds"}
    assert held["prune_share"].measured == pytest.approx(0.05, abs=1e-3)
    assert held["setup_share"].measured == pytest.approx(2 / 240, rel=0.02)
    dear = {c.name: c for c in judge_cost(frames(prune=0.5))}
    assert dear["prune_share"].verdict == "refuted"


def test_without_enough_processes_nothing_is_said_of_setting_up():
    warm, cold = frames(prune=0.05)
    few = replace(cold, samples=tuple(replace(c, values=c.values[:2]) for c in cold.samples))
    assert "setup_share" not in {c.name for c in judge_cost((warm, few))}


def world(metric, objects, parts, seconds, scene="a", side=None):
    chance = np.random.default_rng(int(objects))
    times = [round(1e6 * seconds * n) for n in chance.normal(1, 0.01, 12)]
    case = {"metric": metric, "objects": objects, "scene": scene, "limit_m": 100.0}
    case["side_m"] = side or objects**0.5
    return Point(
        case, samples=columns({"objects": [1], "parts": [parts], "bytes": [9], "cpu_us": times})
    )


def worlds(growth=0.0, scenes="aaaa", unpruned=1.0):
    pruned = [
        world("blake", 10.0**k, 1000, 0.1 * 10 ** (growth * (k - 6)), scenes[(k - 6) // 3])
        for k in (6, 9, 12, 15)
    ]
    full = [
        world("full", float(n), 80 * n, 0.05 + 1e-6 * (80 * n) ** unpruned)
        for n in (100, 1000, 3000, 10_000)
    ]
    return (world("blake", 1e3, 100, 0.02, "small"), *pruned, *full)


def test_worlds_beyond_the_limit_are_judged():
    points = worlds()
    assert len(beyond_limit(points)) == 4
    assert {c.name: c.verdict for c in judge_world(points)} == {
        "world/same_scene": "holds",
        "world/seconds/slope": "holds",
        "full/seconds/slope": "holds",
        "full/over_pruned": "holds",
    }


@pytest.mark.parametrize(
    "change, name",
    [
        ({"growth": 0.05}, "world/seconds/slope"),
        ({"scenes": "aaab"}, "world/same_scene"),
        ({"unpruned": 0.8}, "full/seconds/slope"),
    ],
)
def test_a_planted_falsehood_is_refuted(change, name):
    claims = {c.name: c.verdict for c in judge_world(worlds(**change))}
    assert claims[name] == "refuted"


@pytest.mark.parametrize(
    "name, points",
    [
        ("cost", (*frames(prune=0.05), size("whole", 1.0, 9.0), size("pruned", 1.0, 0.2))),
        ("world", worlds()),
    ],
)
def test_figures_and_table_tell_the_record(name, points):
    here = provenance("ab" * 32, 0)
    record = Record(name, 1, True, "2026-01-01T00:00:00Z", here, points, (), {})
    experiment = EXPERIMENTS[name]
    heads, rows = experiment.point_table(record)
    assert rows and {len(row) for row in rows} == {len(heads)}
    assert all(len(plot.alt) > 80 and plot.drawn for plot in experiment.plots(record))


def test_every_stage_of_a_real_frame_is_timed():
    found = preset_costs(["render.size=32x18", "render.spp=1", "view.detail=8"], choose(), 1)
    (row,) = found["warm"]
    assert {*STAGES, "metric", "tests", "haze"} <= set(row)
    assert all(row[stage] > 0 for stage in STAGES) and row["tests"] > 10
    cold = found["cold"]
    assert 0 < cold["world_bytes"] <= cold["shoot_bytes"] <= cold["render_bytes"]
    warm, processes = cost_experiment.process_points(found)
    assert own_frame_us(warm)[0] == sum(row[stage] for stage in STAGES)
    assert processes.column("world")[0] > 0 and processes.column("drawn", what="sticks")[0] > 0


def test_a_world_is_named_for_its_objects():
    extent, metric, seed = world_experiment.settings("full", 1e4, 3)
    assert metric == "view.metric=full" and seed == "seed=3"
    assert float(extent.partition("=")[2]) > 100
