"""Points stand in the order of their cases, whoever measures them first; nothing is lost."""

from dataclasses import dataclass

from hypothesis import given
from hypothesis import strategies as st

from bench.records.points import Point, columns, merge_points
from bench.runner.dask_cases import serial_executor
from bench.runner.experiment import Effort, Experiment
from bench.runner.run_experiment import case_label, run_cases, run_experiment


@dataclass(frozen=True)
class Several:
    number: int
    copies: int


def measure(case, seed):
    if isinstance(case, Several):
        cases = [{"n": case.number, "copy": k} for k in range(case.copies)]
        return [Point(each, samples=columns({"twice": [2 * case.number + seed]})) for each in cases]
    return Point({"n": case}, samples=columns({"once": [case + seed]}))


def last_first(function, cases):
    return iter([function(*case) for case in cases[::-1]][::-1])


CASES = st.lists(st.builds(Several, st.integers(0, 9), st.integers(0, 3)) | st.integers(0, 9))


@given(CASES, st.integers(0, 9))
def test_points_stand_in_the_order_of_cases(cases, seed):
    told = []

    def progress(done, total, what):
        told.append((done, total, what))

    points = list(run_cases(measure, cases, seed, last_first, progress))
    assert points == list(run_cases(measure, cases, seed, serial_executor, progress))
    found = [measure(case, seed) for case in cases]
    assert points == [p for each in found for p in (each if isinstance(each, list) else [each])]
    total = len(cases)
    assert told[: total + 1] == [
        *((k, total, case_label(case)) for k, case in enumerate(cases)),
        (total, total, "judged"),
    ]


def test_a_case_is_named_by_its_values_or_its_label():
    assert case_label(Several(3, 2)) == "3, 2" and case_label(0.5) == "0.5"


@given(st.lists(st.tuples(st.integers(0, 3), st.integers(), st.integers(0, 1))))
def test_merged_points_hold_every_sample_in_order(rows):
    points = merge_points(
        Point({"n": n}, samples=columns({"v": [value]}, key=key)) for n, value, key in rows
    )
    assert [point.case["n"] for point in points] == list(dict.fromkeys(n for n, _, _ in rows))
    for point in points:
        mine = [(key, value) for n, value, key in rows if n == point.case["n"]]
        for key in dict.fromkeys(key for key, _ in mine):
            wanted = [value for other, value in mine if other == key]
            assert point.column("v", key=key) == wanted


def test_merging_leaves_what_it_was_given_as_it_was():
    points = [Point({"n": 1}, samples=columns({"v": [k]})) for k in range(3)]
    merge_points(points)
    assert [point.column("v") for point in points] == [[0], [1], [2]]


def test_a_record_says_what_was_run_and_how_long_it_took():
    experiment = Experiment(
        name="tiny",
        version=7,
        about="",
        question="",
        full={"cases": 3},
        quick={"cases": 2},
        expected_seconds={"full": 1.0, "quick": 1.0},
        cases=lambda effort: range(effort["cases"]),
        measure=measure,
        judge=lambda points: (),
        plots=lambda record: (),
        point_table=lambda record: ((), []),
        scene_hash=lambda points: "ab" * 32,
    )
    made = run_experiment(experiment, experiment.effort("quick"), seed=3)
    assert (made.experiment, made.version, made.quick) == ("tiny", 7, True)
    assert [point.column("once") for point in made.points] == [[3], [4]]
    assert made.provenance.seed == 3 and made.provenance.scene == "ab" * 32
    assert made.notes["cases"] == 2 and made.notes["seconds"] >= 0
    full = run_experiment(experiment, Effort("full", {"cases": 1}))
    assert not full.quick and len(full.points) == 1
