"""The bar goes place by place, and is judged from the places that every preset is done for."""

from functools import partial

import pytest

from bench.images.as_shipped import Place
from bench.records.records import Point, columns
from bench.runs import journal, serial_executor
from tests.tools.bar_by_place import (
    EXPERIMENT,
    by_place,
    measured,
    of_places,
    place_of,
    whole_places,
)


def look(place, seed):
    case = {"topic": "stills", "preset": place.preset, "sun": place.sun}
    return Point(case, samples=columns({"place": [place.number], "world_seed": [seed]}))


CASES = [
    partial(look, Place(preset, number, sun, ()))
    for preset, suns in (("meadow", ("10°", "40°")), ("zoo", ("in turn",)))
    for number in range(3)
    for sun in suns
]


def stopping_after(count):
    def executor(function, cases):
        for number, case in enumerate(cases):
            if number == count:
                raise KeyboardInterrupt
            yield function(*case)

    return executor


@pytest.mark.parametrize(("done", "places"), [(0, 0), (2, 0), (3, 1), (5, 1), (6, 2)])
def test_places_count_where_every_preset_is_done(tmp_path, done, places):
    with pytest.raises(KeyboardInterrupt):
        list(measured(CASES, journal(tmp_path), stopping_after(done)))
    assert whole_places(CASES, journal(tmp_path)) == places


def test_each_case_is_measured_once_and_those_of_a_place_together(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        list(measured(CASES, journal(tmp_path), stopping_after(4)))
    left = []

    def rest(function, cases):
        left.extend(case for case, _ in cases)
        return serial_executor(function, cases)

    assert len(list(measured(CASES, journal(tmp_path), rest))) == len(CASES)
    assert left == by_place(CASES)[4:]
    assert [place_of(case).number for case in by_place(CASES)] == [0] * 3 + [1] * 3 + [2] * 3


def test_the_places_that_are_done_are_judged_alone_and_it_is_said_so():
    reduced = of_places(EXPERIMENT, CASES, 2)
    chosen = reduced.topics["stills"].cases()
    assert chosen == [case for case in CASES if place_of(case).number < 2]
    assert reduced.notes and reduced.notes(()) == {"places": "the first 2 of 3"}
