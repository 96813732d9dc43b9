"""Scripts and behaviours drawn at random: they end, in a whole track or in one clear line."""

import itertools
import math
import time

import numpy as np
import pytest

from lod.actors.object_with_parts import Refused, ask, change
from lod.errors import InputError
from scenes.actors.behaviours import BEHAVIOURS
from scenes.actors.performance import from_bytes, to_bytes, track_of
from tests.scenes.actors.scene import performance_of, preset

FRAMES, LONGEST_S = 6, 120.0  # the first one compiles
NAMES = ("ann", "bob", "joe")
ROUTES = (*NAMES, "joe/head", "ann/right arm/hand", "bob/right leg/toot", "nobody", "", "camera")
QUESTIONS = ("course", "where", "heading", "position", "held", "posture", "part_names", "flies")
PLACES = ((1.0, 2.0, 0.0), (math.nan, 0.0, 0.0), (0.0, 0.0, 5.0), (1e300, -1e300, 0.0))
WORDS = (
    "orient y 40deg", "orient y 400deg", "turn z 10deg", "bend 0 5 0", "bend 0 900 0", "go 1.2 30",
    "go -1", "go nan", "place 1 2", "release", "leave", "fly 3", "heading", "orient", "place 1 2 3",
)  # fmt: skip


def asks_in_a_circle(me, rng):
    """Whoever is asked asks the next: ann bob, bob joe, joe ann."""
    other = NAMES[(NAMES.index(me.name) + 1) % len(NAMES)]
    for _ in itertools.count():
        yield ask(other, "course")
        yield change(other, "go", 1.0, 5.0)
        yield


def asks(me, rng):
    yield ask(str(rng.choice(ROUTES)), str(rng.choice(QUESTIONS)))


def moves_another(me, rng):
    yield change(str(rng.choice(NAMES)), "place", PLACES[rng.integers(len(PLACES))])


def goes(me, rng):
    yield change(me.name, "go", float(rng.choice((0.0, 1.3, 39.0, -1.0, np.inf))), 20.0)


def leaves(me, rng):
    yield change(me.name, "leave")


def sends_another_away(me, rng):
    yield change(str(rng.choice(NAMES)), "leave")


def bends(me, rng):
    yield change(str(rng.choice(ROUTES)), "bend", tuple(rng.uniform(-90, 90, 3).tolist()))


def guards(me, rng):
    def looks(message):
        if rng.random() < 0.3:
            raise ValueError("it would not look")
        return message if rng.random() < 0.5 else "not now"

    yield change(me.name, "guard", looks)


def raises(me, rng):
    kinds = (RuntimeError, KeyError, SystemExit, StopIteration, RecursionError, GeneratorExit)
    raise kinds[rng.integers(len(kinds))]("two\nlines")
    yield


def chatters(me, rng):
    while True:
        yield ask(me.name, "course")


def yields_junk(me, rng):
    yield (7, "hello", ask, [])[rng.integers(4)]


def sends_junk(me, rng):
    yield change(me.name, "bend", object())


def ends(me, rng):
    yield change(me.name, "go", 1.0, 0.0)


STEPS = (asks, moves_another, goes, leaves, sends_another_away, bends, guards, raises, chatters,
         yields_junk, sends_junk, ends, asks_in_a_circle)  # fmt: skip


def drawn(seed):
    """A behaviour of random steps, by the actor's own random numbers, that may catch refusals."""

    def acts(me):
        rng = np.random.default_rng((seed, NAMES.index(me.name)))
        if rng.random() < 0.2:
            yield from asks_in_a_circle(me, rng)
        while rng.random() < 0.9:
            try:
                yield from STEPS[rng.integers(len(STEPS))](me, rng)
            except Refused:
                if rng.random() < 0.3:
                    raise
            if rng.random() < 0.6:
                yield

    return acts


def drawn_preset(seed):
    rng = np.random.default_rng((seed, 99))
    actors = {
        name: {"model": "figure", "position": (float(k), float(k % 2)), "behaviour": "tried"}
        for k, name in enumerate(NAMES)
    }
    script = [
        {
            "at": float(rng.uniform(0, FRAMES / 24)),
            "to": str(rng.choice(("joe", "ann head", "bob right arm/hand", "camera", "nobody"))),
            "do": str(rng.choice(WORDS)),
            "over": float(rng.choice((0.0, 0.1))),
        }
        for _ in range(rng.integers(0, 2))
    ]
    acting = {"frames": FRAMES, "threshold": float(rng.choice((0.0, 0.5)))}
    return preset(actors, script, acting, seed=seed)


def outcome(seed, monkeypatch):
    """The bytes of the track, or the line in which it ended."""
    monkeypatch.setitem(BEHAVIOURS, "tried", drawn(seed))
    try:
        return to_bytes(track_of(performance_of(drawn_preset(seed))))
    except InputError as error:
        return str(error)


SEEDS = (*range(12), *(pytest.param(k, marks=pytest.mark.slow) for k in range(12, 80)))


@pytest.mark.parametrize("seed", SEEDS)
def test_it_ends_in_a_whole_track_or_one_line(seed, monkeypatch):
    start = time.monotonic()
    found = outcome(seed, monkeypatch)
    assert time.monotonic() - start < LONGEST_S
    if isinstance(found, str):
        assert found and "\n" not in found and "Traceback" not in found
        assert len(found) < 600
        return
    track = from_bytes(found)
    assert track.places.shape == (FRAMES + 1, len(NAMES), 6)
    gone = np.isnan(track.places).any(axis=2)
    assert not (gone[:-1] & ~gone[1:]).any()  # who has left does not come back
    assert np.isfinite(track.places[~gone]).all()
    assert outcome(seed, monkeypatch) == found


def test_both_ends_are_drawn(monkeypatch):
    assert {type(outcome(seed, monkeypatch)) for seed in range(12)} == {str, bytes}
