"""Rivals are compared at equal error: cheats never get there, and a copy ties."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bench.arms.registry import arms
from bench.experiments.fidelity.equal_error import EQUAL_ERROR
from bench.experiments.rivals.claims import judge
from bench.experiments.rivals.equal_error import STAGES, at_equal_error, best_rival
from bench.experiments.rivals.measure import measure
from bench.experiments.rivals.plots import plots, point_table, summary
from bench.experiments.rivals.windows import Window
from bench.fields.windows import Picture
from bench.records.points import Column, Point
from scenes.plugins import entry_points

PLUGIN = Path(__file__).parents[2] / "plugin"


def point(arm, setting, excess, seconds, field=0, megabytes=100.0):
    """A point of one arm, with times of its stages that sum to ``seconds``."""
    flip = Column("flip", [round(1e6 * (0.005 + excess))] * 2)
    floor, ssim = Column("flip_floor", [5000] * 2), Column("ssim", [900_000] * 2)
    share = round(1e6 * seconds / len(STAGES))
    times = [Column("us", [share] * 3, {"stage": stage}) for stage in STAGES]
    held = Column("peak_bytes", [round(1e6 * megabytes)])
    case = {"kind": "crowd", "objects": 1e3, "field": field, "arm": arm, "setting": setting}
    return Point(case, samples=(flip, floor, ssim, *times, held, Column("sticks", [7])))


def rows(arm, times, field=0):
    """Settings 1, 2 and 4 with excesses of a half, equal and double error."""
    excess = (EQUAL_ERROR / 2, EQUAL_ERROR, 2 * EQUAL_ERROR)
    settings = (1.0, 2.0, 4.0)
    found = zip(settings, excess, times, strict=True)
    return [point(arm, s, e, t, field) for s, e, t in found]


def test_time_at_equal_error_is_read_between_settings():
    half = [point("blake", 1.0, EQUAL_ERROR / 4, 8.0), point("blake", 2.0, 4 * EQUAL_ERROR, 2.0)]
    assert at_equal_error(half)["blake"][0].seconds == pytest.approx(4.0)
    assert at_equal_error(rows("blake", (8.0, 4.0, 2.0)))["blake"][0].seconds == pytest.approx(4.0)


def test_a_cheat_never_reaches_equal_error():
    cheat = [point("distance", s, 0.2, 0.01) for s in (100.0, 50.0)]
    found = at_equal_error([*rows("blake", (8.0, 4.0, 2.0)), *cheat])
    assert not found["distance"][0].reached and best_rival(found, "seconds") is None
    assert judge((*rows("blake", (8.0, 4.0, 2.0)), *cheat)) == ()


def test_a_copy_ties_and_the_better_of_two_rivals_counts():
    both = [
        each
        for field in (0, 1)
        for times, arm in (((8, 4, 2), "blake"), ((8, 4, 2), "copy"), ((9, 5, 3), "worse"))
        for each in rows(arm, times, field)
    ]
    time, memory = judge(tuple(both))
    assert time.name == "crowd/1000/time" and "copy" in time.quantity
    assert (time.measured, time.low, time.high) == pytest.approx((1.0, 1.0, 1.0))
    assert time.verdict == memory.verdict == "holds"


def test_a_slower_metric_is_refuted():
    both = [
        each
        for field in (0, 1, 2)
        for times, arm in (((8, 4 + field / 10, 2), "blake"), ((4, 2, 1), "discrete"))
        for each in rows(arm, times, field)
    ]
    time, _ = judge(tuple(both))
    assert time.verdict == "refuted" and time.measured == pytest.approx(2.05, abs=0.01)


@pytest.fixture
def plugin(monkeypatch):
    """The example package is installed, here and in processes that are started."""
    monkeypatch.syspath_prepend(str(PLUGIN))
    monkeypatch.setenv("PYTHONPATH", str(PLUGIN))
    entry_points.installed.cache_clear()
    yield
    entry_points.installed.cache_clear()


@pytest.mark.slow
@pytest.mark.usefixtures("plugin")
def test_a_window_is_measured_whole(monkeypatch, record):
    """Every arm at every setting has errors; those next to equal error have times and memory.

    The arm of another package enters, and does not come up to the error.
    """
    some = {name: arms()[name] for name in ("blake", "full", "stochastic", "nearest")}
    few = {name: replace(arm, settings=arm.settings[:2]) for name, arm in some.items()}
    monkeypatch.setattr("bench.experiments.rivals.measure.arms", lambda: few)
    case = Window("crowd", 400.0, 0, Picture("32x18", 4), 1, 1, "scalar_rgb")
    points = measure(case, 0)
    assert {each.case["arm"] for each in points} == set(few)
    for each in points:
        assert each.column("flip") and each.column("sticks")[0] >= 0
    found = at_equal_error(points)
    assert found["full"][0].reached and found["full"][0].megabytes > 50
    whole = next(each for each in points if each.case["arm"] == "full")
    assert not found["nearest"][0].reached
    assert np.abs(whole.values("flip") - whole.values("flip_floor")).max() == 0
    made = replace(record, experiment="rivals", points=tuple(points))
    heads, told = point_table(made)
    assert len(told) == len(points) and {len(row) for row in told} == {len(heads)}
    heads, told = summary(made)
    assert len(told) == len(few) and {len(row) for row in told} == {len(heads)}
    assert math.isfinite(found["blake"][0].megabytes) and len(plots(made)) == 1
