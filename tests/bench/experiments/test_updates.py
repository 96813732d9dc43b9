"""What is drawn again is counted by every rule, and judged from the counts alone."""

import re
from dataclasses import replace

import pytest

from bench.experiments.registry import EXPERIMENTS
from bench.experiments.updates import measure as updates_experiment
from bench.experiments.updates import plots as updates_plots
from bench.experiments.updates.claims import judge, off_px, redrawn
from bench.experiments.updates.measure import BUDGET, CROWD, MOVES, SPEEDS, THRESHOLDS
from lod.pruning.update_schedule import WINDOW
from scenes.preset.load import load_preset
from scenes.world.world import build_world

THIN = (
    *CROWD,
    "render.size=64x36",
    "species.tree.density=0",
    "species.figure.prototypes=1",
    "species.figure.density=0.005",
)


def fake(world, preset):
    """A field of 1000 parts, half of them at 0.25 to 0.5 pixels a frame."""
    found = {"parts": 1000, "redrawn budget": 100, "off budget": 700}
    for low in SPEEDS:
        found[f"parts from {low:g}"] = 500 if low in (0.0, 0.25) else 0
    for t in THRESHOLDS:
        found[f"redrawn {t:g} px"], found[f"off {t:g} px"] = round(50 / t), round(990 * t)
        for low in SPEEDS:
            found[f"redrawn {t:g} px from {low:g}"] = round(50 / t) if low == 0.25 else 0
    return found


def fake_time(rounds, variant, seed):
    columns = {"all": 100, "scheduled": 140, "all, before rendering": 5, "all, posing": 1}
    columns["all, deciding"] = 2
    samples = {name: [value] * rounds for name, value in columns.items()}
    return updates_experiment.Point({"what": "time", "move": "rest"}, {}, samples)


@pytest.fixture
def record(monkeypatch):
    monkeypatch.setattr(updates_experiment, "build_world", lambda preset: None)
    monkeypatch.setattr(updates_experiment, "counted", fake)
    monkeypatch.setattr(updates_experiment, "timed", fake_time)
    return EXPERIMENTS["updates"].run(quick=True)


def test_every_claim_is_judged_from_the_points(record):
    verdicts = {claim.name: claim.verdict for claim in record.claims}
    held = [f"off/{t:g}_px" for t in THRESHOLDS] + [f"{move}/redrawn" for move in MOVES]
    refuted = dict.fromkeys(["time/whole", "time/deciding"], "refuted")
    assert verdicts == dict.fromkeys([*held, "time/posing"], "holds") | refuted
    assert judge(record.points) == record.claims


def test_a_part_too_far_off_refutes_its_threshold(record):
    point = record.points[0]
    wrong = replace(point, samples={**point.samples, "off 0.5 px": [501, 499, 400]})
    (claim,) = (c for c in judge((wrong,)) if c.name == "off/0.5_px")
    assert claim.verdict == "refuted"
    assert off_px(wrong, "0.5 px") == 0.501


def test_it_has_a_row_for_every_rule_and_a_figure_without_gaps(record):
    assert len(updates_plots.table(record)[1]) == len(MOVES) * (len(THRESHOLDS) + 1) + 1
    (plot,) = updates_plots.plots(record)
    assert not re.search(r"\bnan\b", plot.svg)
    assert "Watson" in plot.caption


def test_a_real_crowd_is_scheduled_as_each_rule_says():
    preset = load_preset("crowd", THIN)
    found = updates_experiment.counted(build_world(preset), preset)
    parts = found["parts"]
    assert parts == sum(found[f"parts from {low:g}"] for low in SPEEDS) > 200
    counts = [found[f"redrawn {t:g} px"] for t in THRESHOLDS]
    assert parts / 2 > counts[0] > counts[1] > counts[2] > 0
    for t in THRESHOLDS:
        assert 0 < found[f"off {t:g} px"] <= 1000 * t
    assert found["redrawn budget"] <= parts * (BUDGET + 2 / WINDOW)
    assert redrawn(updates_experiment.Point({}, {}, {"parts": [4, 6], "redrawn x": [1, 1]}), "x")
