"""Killed at any five moments and begun again, a run makes the records of an unbroken one."""

from dataclasses import replace

import pytest

from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.studies.resume import KILLS, aside, killed_and_whole, spans_between


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


def test_notes_count_but_for_their_times():
    before = a_record("figure", {"parts": [3]}, 1.0)
    noted = {"seconds": 2.0, "processor_seconds": 3.0, "composing_times": [4], "poses": 5}
    assert aside(replace(before, notes=noted)) == aside(replace(before, notes={"poses": 5}))
    assert aside(replace(before, notes=noted)) != aside(replace(before, notes={"poses": 6}))
    assert aside(before) != aside(replace(before, quick=False))


def test_kills_fall_within_a_run():
    spans = spans_between(100.0, 3)
    assert len(spans) == KILLS and min(spans) > 0 and 20 < sum(spans) < 67
    assert spans != spans_between(100.0, 4)


@pytest.mark.slow
def test_killed_five_times_it_makes_the_same_records():
    """What is counted and what is rendered."""
    found = killed_and_whole(["figure", "spectrum"], 1)
    assert len(found["killed_after_s"]) == KILLS
    assert found["same"] == {"figure": True, "spectrum": True}
