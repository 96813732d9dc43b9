"""What is drawn again is counted by every rule, and judged from the counts alone."""

import re

import pytest

from bench.experiment import experiments
from bench.experiments.updates import measure as updates_experiment
from bench.experiments.updates import plots as updates_plots
from bench.experiments.updates.claims import judge, off_px, redrawn
from bench.experiments.updates.measure import BUDGET, CROWD, MOVES, SPEEDS, THRESHOLDS
from bench.records.records import Column, Point
from bench.runs import run_experiment
from lod.update_schedule import WINDOW
from scenes.presets.load import load_preset
from scenes.world.world import build_world
from tests.bench.edited import edited

EXPERIMENTS = experiments()


THIN = (
    *CROWD,
    "render.size=64x36",
    "species.tree.density=0",
    "species.figure.prototypes=1",
    "species.figure.density=0.005",
)


def fake(world, preset):
    """A field of 1000 parts, half of them at 0.25 to 0.5 pixels a frame."""
    found = [Column("parts", [1000])]
    for low in SPEEDS:
        found.append(Column("parts", [500 if low in (0.0, 0.25) else 0], {"speed_from": low}))
    rules = {f"{t:g} px": (round(50 / t), round(990 * t)) for t in THRESHOLDS}
    for rule, (anew, off) in (rules | {"budget": (100, 700)}).items():
        found.append(Column("redrawn", [anew], {"rule": rule}))
        found.append(Column("off_mpx", [off], {"rule": rule}))
        for low in SPEEDS:
            keys = {"rule": rule, "speed_from": low}
            found.append(Column("redrawn", [anew if low == 0.25 else 0], keys))
    return tuple(found)


def fake_time(rounds, variant, seed):
    stages = {"frame": 100, "before rendering": 5, "posing": 1, "deciding": 2}
    times = {("all", stage): us for stage, us in stages.items()} | {("scheduled", "frame"): 140}
    samples = (
        Column("cpu_us", [us] * rounds, {"way": way, "stage": stage})
        for (way, stage), us in times.items()
    )
    return Point({"what": "time", "move": "rest"}, samples=tuple(samples))


@pytest.fixture
def record(monkeypatch):
    monkeypatch.setattr(updates_experiment, "build_world", lambda preset: None)
    monkeypatch.setattr(updates_experiment, "counted", fake)
    monkeypatch.setattr(updates_experiment, "timed", fake_time)
    experiment = EXPERIMENTS["updates"]
    return run_experiment(experiment, experiment.effort("quick"))


def test_every_claim_is_judged_from_the_points(record):
    verdicts = {claim.name: claim.verdict for claim in record.claims}
    held = [f"off/{t:g}_px" for t in THRESHOLDS] + [f"{move}/redrawn" for move in MOVES]
    refuted = dict.fromkeys(["time/whole", "time/deciding"], "refuted")
    assert verdicts == dict.fromkeys([*held, "time/posing"], "holds") | refuted
    assert judge(record.points) == record.claims


def test_a_part_too_far_off_refutes_its_threshold(record):
    point = record.points[0]
    wrong = edited(point, "off_mpx", lambda _: [501, 499, 400], rule="0.5 px")
    (claim,) = (c for c in judge((wrong,)) if c.name == "off/0.5_px")
    assert claim.verdict == "refuted"
    assert off_px(wrong, "0.5 px") == 0.501


def test_it_has_a_row_for_every_rule_and_a_figure_without_gaps(record):
    assert len(updates_plots.point_table(record)[1]) == len(MOVES) * (len(THRESHOLDS) + 1) + 1
    (plot,) = updates_plots.plots(record)
    assert not re.search(r"\bnan\b", plot.svg)
    assert "Watson" in plot.caption


def test_a_real_crowd_is_scheduled_as_each_rule_says():
    preset = load_preset("crowd", THIN)
    found = Point({}, samples=updates_experiment.counted(build_world(preset), preset))

    def one(quantity, **keys):
        (value,) = found.column(quantity, **keys)
        return value

    parts = one("parts")
    assert parts == sum(one("parts", speed_from=low) for low in SPEEDS) > 200
    counts = [one("redrawn", rule=f"{t:g} px") for t in THRESHOLDS]
    assert parts / 2 > counts[0] > counts[1] > counts[2] > 0
    for t in THRESHOLDS:
        assert 0 < one("off_mpx", rule=f"{t:g} px") <= 1000 * t
    assert one("redrawn", rule="budget") <= parts * (BUDGET + 2 / WINDOW)
    some = (Column("parts", [4, 6]), Column("redrawn", [1, 1], {"rule": "x"}))
    assert redrawn(Point({}, samples=some), "x").value == pytest.approx(0.2)
