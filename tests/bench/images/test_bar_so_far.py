"""The bar goes place by place, and can be judged from the places that every preset is done for."""

from functools import partial

import pytest

from bench.images import as_shipped
from bench.images.as_shipped import Place
from bench.records.records import Point, columns
from bench.runs import journal, measured_case
from tests.tools.bar_so_far import ASKED, EXPERIMENT, of_places, place_of, whole_places


def look(place, seed):
    case = {"topic": "stills", "preset": place.preset, "sun": place.sun}
    return Point(case, samples=columns({"place": [place.number], "world_seed": [seed]}))


SEEN = ("meadow", "10°"), ("meadow", "40°"), ("zoo", "in turn")
CASES = [partial(look, Place(*each[:1], k, each[1], ())) for k in range(3) for each in SEEN]


def stopping_after(count):
    def executor(function, cases):
        for number, case in enumerate(cases):
            if number == count:
                raise KeyboardInterrupt
            yield function(*case)

    return executor


def test_first_places_come_first():
    cases = as_shipped.cases({"meadow": 3, "zoo": 3}, "64x36", False, (1, 2), 1, 10**9)
    seen = [(place_of(each).preset, place_of(each).number) for each in cases]
    assert seen == [(name, k) for k in range(3) for name in (*["meadow"] * 3, "zoo")]


@pytest.mark.parametrize(("done", "places"), [(0, 0), (2, 0), (3, 1), (5, 1), (6, 2)])
def test_places_count_where_every_preset_is_done(tmp_path, done, places):
    kept = journal(tmp_path)
    with pytest.raises(KeyboardInterrupt):
        list(kept.memoised(ASKED, stopping_after(done))(measured_case, [(c, 0) for c in CASES]))
    assert whole_places(CASES, journal(tmp_path)) == places


def test_the_places_that_are_done_are_judged_alone_and_it_is_said_so():
    reduced = of_places(EXPERIMENT, CASES, 2)
    assert reduced.topics["stills"].cases() == CASES[:6]
    assert reduced.notes and reduced.notes(()) == {"places": "the first 2 of 3"}
