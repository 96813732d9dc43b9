"""Cost: what is claimed follows from samples, the tables tell them, and everything is timed."""

import json
from dataclasses import replace

import numpy as np
import pytest

from bench import frame_costs, timing
from bench.children import run_in_child
from bench.experiments.cost import (
    EXPERIMENT,
    SET_UP,
    STAGES,
    beyond_limit,
)
from bench.frame_costs import preset_costs
from bench.records.records import Column, Point, columns, merge_points
from scenes.presets.load import load_preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.exr.layer_file import write_exr
from scenes.render.variants import JIT_VARIANT, choose
from scenes.scene import Scene
from tests.bench.edited import record_of


def frames(**share):
    """Twelve frames of 1 s, of which stages take these shares, and eight processes."""
    chance = np.random.default_rng(0)
    noise = chance.normal(1, 0.02, 12)
    stages = {**dict.fromkeys(STAGES, 0.0), "trace": 1 - sum(share.values()), **share}
    times = {
        stage: [round(1e6 * v * n) + k * (stage == "prune") for k, n in enumerate(noise)]
        for stage, v in stages.items()
    }
    times["metric"] = [round(n / 100) + k for k, n in enumerate(times["prune"])]
    warm = tuple(Column("us", row, {"stage": stage}) for stage, row in times.items())
    cold = {"world": [2_000_000 + k for k in range(8)]}
    named = ({"topic": "cost", "what": each} for each in ("frames", "processes"))
    return tuple(map(Point, named, ((), ()), (warm, columns(cold))))


def size(side, trace, set_up, error=0.004, megabytes=500, kind="meadow"):
    """Both fields of one side of a world, two frames each, with a spread of a hundredth."""
    spread = np.array([0.99, 1.01] * 2 if side == "pruned" else [0.995, 1.005] * 2)
    stages = {**dict.fromkeys(SET_UP, set_up / 4), "trace": trace}
    times = [
        Column("us", np.rint(1e6 * v * spread).astype(int).tolist(), {"stage": k})
        for k, v in stages.items()
    ]
    counted = columns({"peak_bytes": [megabytes * 10**6, megabytes * 10**6 + len(side)]})
    flip = [
        Column(
            "flip_ppm", [round(1e6 * (error + 0.1 / n**0.5)) + k for k in (0, 5)], {"samples": n}
        )
        for n in (16, 64)
    ]
    case = {"topic": "cost", "what": "size", "kind": kind, "objects": 1e4, "side": side}
    return Point(case, samples=(*times, *counted, *(flip if side == "pruned" else ())))


def by_estimand(points):
    return {c.estimand: c for c in EXPERIMENT.judged(tuple(points))}


@pytest.mark.parametrize(
    ("kind", "trace", "error", "refuted"),
    [
        ("crowd", 1.0, 0.004, set()),
        ("meadow", 1.0, 0.004, {"time of a later frame, pruned ÷ unpruned"}),
        (
            "crowd",
            0.5,
            0.02,
            {"time to trace, pruned ÷ unpruned", "FLIP to unpruned without noise"},
        ),
    ],
)
def test_both_sides_of_a_world_are_compared_stage_by_stage(kind, trace, error, refuted):
    """Unpruned, 9 s of set-up and 1 s of tracing; where nothing moves it is set up once."""
    found = by_estimand(
        (
            size("whole", 1.0, 9.0, megabytes=2000, kind=kind),
            size("pruned", trace, 0.2, error, kind=kind),
        )
    )
    assert len(found) == 5
    assert {name for name, c in found.items() if c.verdict == "refuted"} == refuted
    measured = {name: c.measured for name, c in found.items()}
    later = 1.2 if kind == "meadow" else (trace + 0.2) / 10
    assert measured == pytest.approx(
        {
            "time to trace, pruned ÷ unpruned": trace,
            "time of a later frame, pruned ÷ unpruned": later,
            "time to set up a frame, pruned ÷ unpruned": 0.2 / 9,
            "memory of a first frame, pruned ÷ unpruned": 0.25,
            "FLIP to unpruned without noise": error,
        },
        rel=0.01,
    )


def test_shares_of_a_frame_are_judged():
    held = by_estimand(frames(prune=0.05, build=0.3))
    prune = "time of finding and pruning ÷ time of a frame"
    setup = "time to set up the hierarchies ÷ time of 240 frames"
    assert {c.verdict for c in held.values()} == {"holds"} and held[prune].headline
    assert held[prune].measured == pytest.approx(0.05, abs=1e-3)
    assert held[setup].measured == pytest.approx(2 / 240, rel=0.02)
    assert by_estimand(frames(prune=0.5))[prune].verdict == "refuted"
    warm, cold = frames(prune=0.05)
    few = replace(cold, samples=tuple(replace(c, values=c.values[:2]) for c in cold.samples))
    assert setup not in by_estimand((warm, few))


def world(metric, objects, parts, seconds, scene="a", side=None):
    chance = np.random.default_rng(int(objects))
    times = [round(1e6 * seconds * n) for n in chance.normal(1, 0.01, 12)]
    case = {"topic": "world", "metric": metric, "objects": objects, "scene": scene}
    case |= {"limit_m": 100.0, "side_m": side or objects**0.5}
    return Point(case, samples=columns({"parts": [parts], "cpu_us": times}))


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


@pytest.mark.parametrize(
    ("change", "refuted"),
    [
        ({}, None),
        ({"growth": 0.05}, "exponent of time against objects"),
        ({"scenes": "aaab"}, "different frames"),
        ({"unpruned": 0.8}, "exponent of added time against added parts"),
    ],
)
def test_worlds_beyond_the_limit_are_judged(change, refuted):
    points = worlds(**change)
    assert len(beyond_limit(points)) == 4
    found = by_estimand(points)
    saved = found["time of a frame, unpruned ÷ pruned"]
    assert len(found) == 4 and saved.relation == "≥" and saved.headline
    if refuted:
        assert found[refuted].verdict == "refuted"
    else:
        assert {c.verdict for c in found.values()} == {"holds"}
        assert saved.measured == pytest.approx(8.5, rel=0.02)


def test_scalar_code_is_held_against_the_jit_variant_turn_by_turn():
    def frame(variant, times):
        case = {"topic": "variants", "command": "render", "kept": "warm", "variant": variant}
        us = {"imports_us": [1] * 8, "command_us": [1] * 8, "trace_us": times}
        return Point(case, samples=columns(us))

    times = list(range(100, 180, 10))
    for factor, verdict in ((7, "holds"), (9, "refuted")):
        slow = frame("scalar_rgb", [factor * each for each in times])
        (found,) = EXPERIMENT.judged((slow, frame("llvm_ad_rgb", times)))
        assert (found.verdict, found.measured) == (verdict, pytest.approx(factor))


@pytest.mark.slow
def test_every_stage_of_a_real_frame_is_timed():
    found = preset_costs(["render.size=32x18", "render.spp=1", "view.detail=8"], choose(), 1)
    (row,) = found["warm"]
    assert all(row[stage] > 0 for stage in (*STAGES, "metric")) and found["world"] > 0


@pytest.mark.slow
@pytest.mark.parametrize("topic", ["cost", "world", "variants"])
def test_a_small_run_is_measured_judged_and_shown(topic, monkeypatch):
    monkeypatch.setattr(frame_costs, "WORLDS", (1e3, 1e6, 1e12))
    monkeypatch.setattr(frame_costs, "UNPRUNED", (1e2, 3e2, 1e3))
    sizes = EXPERIMENT.topics[topic].sizes("quick")
    small = {"processes": 1, "worlds": {"meadow": [20.0]}, "fields": 2, "size": "32x18", "spp": 4}
    small |= {"samples": [4, 16], "repeats": 8, "warm": 1}
    sizes |= {name: value for name, value in small.items() if name in sizes}
    points = [p for case in EXPERIMENT.topics[topic].cases(**sizes) for p in case(0)]
    assert {p.case["topic"] for p in points} == {topic}
    if topic in ("cost", "variants"):
        mine = replace(EXPERIMENT.topics[topic], claims=lambda points: ())
        judged = replace(EXPERIMENT, topics={topic: mine})
        assert judged.tables(record_of(judged, merge_points(points)))
    else:
        assert len(EXPERIMENT.judged(tuple(points))) == 4


def loaded(function):
    """Whether the process of a function has loaded statistics that need much memory."""
    import sys

    return "statsmodels" in sys.modules, function.__name__


def test_processes_whose_memory_is_measured_load_no_statistics():
    assert run_in_child(loaded, preset_costs).result == (False, "preset_costs")


def peaks(folder, frames):
    """Render and write small frames; the most memory that the process has held after each."""
    settings = "render.size=16x9", "render.spp=1", "view.detail=8"
    scene, found = Scene(load_preset("meadow", settings)), []
    for frame in range(1, frames + 1):
        write_exr(folder / f"{frame}.exr", scene.render(frame, choose()), {})
        found.append(peak_rss_bytes())
    return found


@pytest.mark.slow
def test_frame_after_frame_takes_no_more_memory(tmp_path):
    held = run_in_child(peaks, tmp_path, 30).result
    assert held[-1] <= 1.05 * held[2]


@pytest.fixture
def asked(monkeypatch):
    """The processes that were asked for; imports take half a second and commands two."""
    asked: list[tuple[str, str]] = []

    def note(words, environment):
        assert environment["HOME"] == environment["LODBENCH_CACHE"]  # where Dr.Jit keeps kernels
        asked.append((words[1], environment["LODBENCH_CACHE"]))
        said = json.dumps({"seconds": {"trace": 1.5, "write": 9.0}}) + '\n{"done": 1}'
        return said.encode(), 2.0 if words[1] == "-m" else 0.5, 0.5

    monkeypatch.setattr(timing, "run_timed", note)
    return asked


def test_cold_commands_find_nothing_kept_and_warm_ones_the_same(asked):
    cold, warm = timing.measure_command(("count", "meadow"), 8, 2, (), 0)
    assert (cold.case["kept"], warm.case["kept"]) == ("cold", "warm")
    assert [word for word, _ in asked] == ["-c", "-m"] * 2 + ["-c", "-m"] * 8
    first, *kept = [cache for word, cache in asked if word == "-m"]
    assert first not in kept and kept == kept[:1] * 9
    assert warm.column("imports_us") == [500_000] * 8 and not any(warm.column("trace_us"))
    (first,) = timing.measure_command(("render", "meadow"), 0, 1, (JIT_VARIANT,), 0)
    assert first.column("trace_us") == [1_500_000]
    scalar, jit = timing.measure_command(("render",), 2, 0, ("scalar_rgb", JIT_VARIANT), 0)
    assert (scalar.case["variant"], jit.case["variant"]) == ("scalar_rgb", JIT_VARIANT)
    used = [cache for word, cache in asked[-12:] if word == "-m"]  # in turns, once to keep
    assert used[:2] * 3 == used and used[0] != used[1]


def test_warm_commands_are_judged_by_their_imports_and_cold_frames_by_the_clock():
    def turns(command, kept, imports, trace, total):
        case = {"topic": "start", "command": command, "variant": "", "kept": kept}
        seconds = zip(timing.TIMES, (imports, trace, total, total), strict=True)
        samples = {name: [round(s * (10**6 + k)) for k in range(8)] for name, s in seconds}
        return Point(case, samples=columns(samples))

    points = (
        *(turns("count", "warm", 0.5, 0, total) for total in (0.9, 1.1)),
        *(turns("render", "warm", 1, 8, total) for total in (13, 14)),
        *(turns("render", "cold", 1, 8, total) for total in (59, 61)),
        turns("count", "cold", 1, 0, 100),
    )
    found = [each.verdict for each in EXPERIMENT.topics["start"].claims(points)]
    assert found == ["holds", "refuted"] * 3
