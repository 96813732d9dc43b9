"""What is drawn again is counted by every threshold, and judged as is claimed."""

import pytest

from bench.experiments.scheduling import (
    CROWD,
    EXPERIMENT,
    MOVES,
    SPEEDS,
    THRESHOLDS,
    counted,
    off_px,
    redrawn,
)
from bench.records.records import Column, Point
from scenes.presets.load import load_preset
from scenes.scene import Scene
from tests.bench.edited import edited

THIN = (
    *CROWD,
    "render.size=64x36",
    "species.tree.density=0",
    "species.figure.prototypes=1",
    "species.figure.density=0.002",
)


def schedule(move):
    """Three fields of 1000 parts, half of them at 0.25 to 0.5 pixels a frame."""
    found = [Column("parts", [1000] * 3)]
    for low in SPEEDS:
        found.append(Column("parts", [500 * (low in (0.0, 0.25))] * 3, {"speed_from": low}))
    rules = {f"{t:g} px": (round(50 / t), round(990 * t)) for t in THRESHOLDS}
    for rule, (again, off) in rules.items():
        found.append(Column("redrawn", [again - 1, again, again + 1], {"rule": rule}))
        found.append(Column("off_mpx", [off] * 3, {"rule": rule}))
        for low in SPEEDS:
            keys = {"rule": rule, "speed_from": low}
            found.append(Column("redrawn", [again * (low == 0.25)] * 3, keys))
    return Point({"topic": "updates", "what": "schedule", "move": move}, samples=tuple(found))


def timed():
    stages = {"frame": 100, "posing": 1, "deciding": 2}
    times = {("all", stage): us for stage, us in stages.items()} | {("scheduled", "frame"): 140}
    samples = (
        Column("cpu_us", [10_000 * us + k * us**2 for k in range(3)], {"way": way, "stage": stage})
        for (way, stage), us in times.items()
    )
    return Point({"topic": "updates", "what": "time", "move": "rest"}, samples=tuple(samples))


POINTS = (*map(schedule, MOVES), timed())


def test_every_claim_is_judged_from_the_points():
    found = EXPERIMENT.judged(POINTS)
    refuted = [c.estimand for c in found if c.verdict == "refuted"]
    assert refuted == [
        "CPU time of a frame, scheduled ÷ all drawn",
        "CPU time, comparing with what was drawn ÷ posing",
    ]
    assert len(found) == len(THRESHOLDS) + len(MOVES) + 3
    assert {c.verdict for c in found} == {"holds", "refuted"}


def test_a_part_too_far_off_refutes_its_threshold():
    wrong = edited(POINTS[0], "off_mpx", lambda _: [501, 499, 400], rule="0.5 px")
    verdicts = {c.value: c.verdict for c in EXPERIMENT.judged((wrong,)) if c.unit == "exact"}
    assert verdicts == {0.25: "holds", 0.5: "refuted", 1.0: "holds"}
    assert off_px(wrong, "0.5 px") == 0.501


def test_a_real_crowd_is_scheduled_as_each_rule_says():
    found = Point({}, samples=counted(Scene(load_preset("crowd", THIN))))

    def one(quantity, **keys):
        (value,) = found.column(quantity, **keys)
        return value

    parts = one("parts")
    assert parts == sum(one("parts", speed_from=low) for low in SPEEDS) > 80
    counts = [one("redrawn", rule=f"{t:g} px") for t in THRESHOLDS]
    assert parts / 2 > counts[0] > counts[1] > counts[2] > 0
    for t in THRESHOLDS:
        assert 0 < one("off_mpx", rule=f"{t:g} px") <= 1000 * t
    some = (Column("parts", [4, 6]), Column("redrawn", [1, 1], {"rule": "x"}))
    assert redrawn(Point({}, samples=some), "x").value == pytest.approx(0.2)
