"""Points stand in the order of their cases, whoever measures them first; nothing is lost."""

from hypothesis import given
from hypothesis import strategies as st

from bench.records.provenance import provenance
from bench.records.records import Point
from bench.runner.dask_cases import serial_executor
from bench.runner.run_cases import make_record, merge_points, run_cases


def double(number, copies):
    return [Point({"n": number, "copy": k}, {}, {"twice": [2 * number]}) for k in range(copies)]


def single(number):
    return Point({"n": number}, {}, {"once": [number]})


def last_first(function, cases):
    return iter([function(*case) for case in cases[::-1]][::-1])


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 3))), st.lists(st.integers(0, 9)))
def test_points_stand_in_the_order_of_cases(pairs, numbers):
    several = [(f"{n}", (n, k)) for n, k in pairs]
    ones = [(f"{n}", (n,)) for n in numbers]
    told = []

    def progress(done, total, what):
        told.append((done, total, what))

    points = run_cases(progress, last_first, (double, several), (single, ones))
    assert points == run_cases(progress, serial_executor, (double, several), (single, ones))
    expected = [point for n, k in pairs for point in double(n, k)] + [single(n) for n in numbers]
    assert list(points) == expected
    total = len(pairs) + len(numbers)
    assert told[: total + 1] == [
        *((k, total, name) for k, (name, _) in enumerate([*several, *ones])),
        (total, total, "judged"),
    ]


@given(st.lists(st.tuples(st.integers(0, 3), st.integers())))
def test_joined_points_hold_every_sample_in_order(pairs):
    points = merge_points([Point({"n": n}, {"p": 1.0}, {"v": [value]}) for n, value in pairs])
    assert [point.case["n"] for point in points] == list(dict.fromkeys(n for n, _ in pairs))
    for point in points:
        assert point.samples["v"] == [value for n, value in pairs if n == point.case["n"]]
        assert point.predicted == {"p": 1.0}


def test_joining_leaves_what_it_was_given_as_it_was():
    points = [Point({"n": 1}, {}, {"v": [k]}) for k in range(3)]
    merge_points(points)
    assert [point.samples["v"] for point in points] == [[0], [1], [2]]


def test_a_record_says_how_long_it_took():
    made = make_record(
        "scaling",
        1,
        quick=True,
        provenance=provenance("scene", 3),
        points=(),
        claims=(),
        notes={"fields": 2},
        start=0.0,
    )
    assert made.notes["fields"] == 2 and made.notes["seconds"] > 0 and made.quick
