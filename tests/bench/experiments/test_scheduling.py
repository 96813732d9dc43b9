"""What is drawn again is counted by every rule, and actors wait, act and walk as is claimed."""

import numpy as np
import pytest

from bench.acting import (
    acted_on_a_copy,
    measure_clearance,
    measure_waiting,
    off_px,
    sticks_off_px,
    troupe_of,
    walkers,
)
from bench.experiments.scheduling import (
    CROWD,
    EXPERIMENT,
    MOVES,
    SPEEDS,
    THRESHOLDS,
    counted,
    redrawn,
)
from bench.experiments.scheduling import (
    off_px as farthest_px,
)
from bench.records.records import Column, Point, columns
from lod.pruner import prune
from scenes.actors.acting import Rules
from scenes.presets.load import load_preset
from scenes.scene import Scene
from scenes.world.cast import make_cast
from scenes.world.world import make_terrain
from tests.bench.edited import edited, record_of

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
    assert farthest_px(wrong, "0.5 px") == 0.501


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


# Actors


def test_those_who_wait_are_off_by_less_than_the_threshold():
    found = measure_waiting(8, 16, 0, threshold=8.0)
    assert 0.1 < found.column("updated")[0] / found.column("acted")[0] < 0.9
    for error in ("at once", "in time"):
        worst, most = (
            found.column("off_mpx", error=error, statistic=name)[0] for name in ("p99.9", "most")
        )
        assert 0 < worst <= most < 8000
    assert len(EXPERIMENT.judged((found,))) == 3


def test_a_copy_acts_and_leaves_the_scene_as_it_was():
    """The copy does what the scene then does with everyone updated, and is told apart from it."""
    preset = walkers(6, 20.0, 8, 64.0, 0)
    once, again = troupe_of(preset), troupe_of(preset)
    for _ in range(3):
        once.acting.act(), again.acting.act()
    copied = acted_on_a_copy(once.acting, 4)
    once.acting.rules = Rules()
    meant = [once.acting.act() for _ in range(4)]
    assert all(np.array_equal(a.places, b.places) for a, b in zip(copied, meant, strict=True))
    waited = [again.acting.act() for _ in range(4)]
    assert not np.array_equal(waited[-1].places, copied[-1].places)
    view = Scene(preset).view(3)
    assert off_px(troupe_of(preset).cast, copied[-1], view, 3).max() > 0.5


def test_sticks_are_held_against_the_same_sticks():
    """Of the same cast nothing is off; of one in which a head has turned, its parts alone."""
    plain = walkers(4, 20.0, 4, 0.0, 0)
    said = {"to": "walker_1 head", "do": "turn z 20deg"}
    turned = plain.model_validate(plain.model_dump() | {"script": (said,)})
    shown, other = (make_cast(each, make_terrain(each)) for each in (plain, turned))
    view = Scene(plain).view(2)
    assert sticks_off_px(shown, shown, view).max() == 0.0
    off = sticks_off_px(shown, other, view)
    parts = prune(shown, view).parts
    assert set(parts.object[off > 1e-6].tolist()) == {0}
    assert 0 < np.count_nonzero(off) < 20


def test_people_keep_clear_of_each_other():
    found = measure_clearance(None, 8, 8.0, 1.0, 0)
    assert min(found.column("nearest_mm")) > 400 and len(found.column("nearest_mm")) == 24
    (claimed,) = EXPERIMENT.judged((found,))
    assert claimed.verdict == "holds"
    bumped = edited(found, "nearest_mm", lambda apart: [*apart[:-1], 399])
    assert EXPERIMENT.judged((bumped,))[0].verdict == "refuted"


def test_a_crowd_is_held_against_the_aim():
    def crowd(times, in_time):
        (case,) = ({"topic": "acting", "what": "waiting", "actors": 9, "density": 0.1},)
        case |= {"threshold": 0.5, "waving": False}
        off = [
            Column("off_mpx", [mpx], {"error": error, "statistic": "p99.9"})
            for error, mpx in (("at once", 100), ("in time", in_time))
        ]
        spent = {"all": [1000 * times, 1001 * times], "scheduled": [1000, 1000]}
        ways = (each for way, us in spent.items() for each in columns({"cpu_us": us}, way=way))
        return Point(case, samples=(*off, *ways))

    assert [c.verdict for c in EXPERIMENT.judged((crowd(4, 400),))] == ["holds"] * 3
    assert [c.verdict for c in EXPERIMENT.judged((crowd(2, 900),))] == [
        "refuted",
        "holds",
        "refuted",
    ]


@pytest.mark.slow
def test_actors_of_a_preset_keep_clear_of_each_other():
    found = measure_clearance("playground", 0, 0.0, 2 / 24, 0)
    assert found.case["scene"] == "playground" and min(found.column("nearest_mm")) > 400
    assert EXPERIMENT.judged((found,))[0].verdict == "holds"


@pytest.mark.slow
def test_a_small_run_of_actors_is_measured_judged_and_shown():
    topic = EXPERIMENT.topics["acting"]
    sizes = topic.sizes("quick") | {"frames": 4, "crowd": 12, "people": 6}
    points = [case(0) for case in topic.cases(**sizes)]
    assert record_of(EXPERIMENT, points).claims
    assert {p.case["what"] for p in points} == {"waiting", "clearance"}
