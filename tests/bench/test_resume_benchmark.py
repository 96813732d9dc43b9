"""Killed at any five moments and begun again, a run makes the records of an unbroken one."""

from dataclasses import replace

import pytest

from bench.provenance import provenance
from bench.records import Point, Record
from bench.resume_benchmark import KILLS, aside, killed_and_whole


def a_record(name, samples, seconds=1.0):
    points = (Point({"n": 1}, {"parts": 2.0}, samples),)
    return Record(name, 1, True, "", provenance("", 0), points, (), {"seconds": seconds})


def test_times_are_aside_and_nothing_else():
    before = a_record("fidelity", {"parts": [3], "build_us": [5]})
    assert aside(before) == aside(a_record("fidelity", {"parts": [3], "build_us": [9]}, 2.0))
    assert aside(before) != aside(a_record("fidelity", {"parts": [4], "build_us": [5]}))
    assert aside(before) != aside(a_record("fidelity", {"parts": [3]}))
    assert aside(before) != aside(replace(before, points=()))
    assert aside(a_record("cost", {"prune": [3]})) == aside(a_record("cost", {"prune": [4]}))
    assert aside(a_record("cost", {"prune": [3]})) != aside(a_record("cost", {"trace": [3]}))


@pytest.mark.slow
def test_killed_five_times_it_makes_the_same_records():
    """What is counted and what is rendered."""
    found = killed_and_whole(["figure", "spectrum"], 1)
    assert len(found["killed_after_s"]) == KILLS
    assert found["same"] == {"figure": True, "spectrum": True}
