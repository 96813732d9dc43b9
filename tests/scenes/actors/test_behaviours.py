"""What each shipped behaviour does, seen through the places and limbs of who does it."""

import numpy as np
import pytest
from scipy.spatial.distance import pdist

from lod.actors.object_with_parts import ask, change
from scenes.actors.behaviours import BEHAVIOURS, BODY_M
from scenes.actors.performance import YAW, X, Y
from tests.scenes.actors.scene import ANN, JOE, acting_of, performance_of, preset

RIGHT_HAND = ("right arm", "hand")


def acted(chosen, frames, look):
    """What ``look`` sees of the stage in each frame."""
    acting, seen = acting_of(chosen), []
    for _ in range(frames):
        acting.act()
        seen.append(look(acting.stage))
    return seen


def places_of(actors, frames, **tables):
    """Places (frames, n, 6), in the order of the names."""
    done = performance_of(preset(actors, acting={"frames": frames}, **tables))
    return np.array([done.frame(k).places for k in range(1, frames + 1)])


def speeds(places):
    return np.hypot(*np.moveaxis(np.diff(places[..., (X, Y)], axis=0), -1, 0)) * 24


def apart(places, a=0, b=1):
    return np.hypot(*(places[:, a, (X, Y)] - places[:, b, (X, Y)]).T)


@pytest.mark.parametrize("waves", [0.0, 1.0])
def test_who_walks_waves_to_whom_it_meets_and_lets_the_arm_go(waves):
    """The hand is up to the shoulder and above for a second, and swings; nothing is held after."""
    joe = JOE | {"behaviour": "walk", "options": {"side": 4.0, "waves": waves}}

    def look(stage):
        hand, shoulder = (
            stage.receive(ask(("joe", *route), "where")).value
            for route in (RIGHT_HAND, RIGHT_HAND[:1])
        )
        return hand[2] - shoulder[2], len(stage.receive(ask("joe", "posture")).value.held)

    above, held = np.array(acted(preset({"joe": joe, "ann": ANN}), 50, look)).T
    if waves:
        assert above[12:32].min() > 0.0
        assert np.ptp(above[12:32]) > 0.03
        assert held[:44].tolist() == [2] * 44
    assert above[0] < -0.4
    assert held[45:].tolist() == [0] * 5
    assert (held.max(), above.max() > 0.0) == ((2, True) if waves else (0, False))


def test_who_walk_in_a_square_keep_clear_of_each_other():
    """Nobody comes nearer to another than two bodies' radii."""
    options = {"side": 8.0, "centre_x": 0.0, "centre_y": 0.0, "waves": 0.0}
    walkers = {"model": "figure", "count": 8, "side": 8.0, "behaviour": "walk", "options": options}
    places = places_of({}, 24, troupes={"walker": walkers})
    assert min(pdist(each[:, (X, Y)]).min() for each in places) >= 2 * BODY_M
    assert speeds(places).max() > 0.5


def test_who_follows_stays_a_step_behind_and_clear_of_the_leader():
    joe = JOE | {"behaviour": "walk", "options": {"side": 30.0, "waves": 0.0}}
    ann = ANN | {"behaviour": "follow", "options": {"whom": "joe"}}
    places = places_of({"joe": joe, "ann": ann}, 144)
    behind = places[:, 1, (X, Y)] - 0.8 * np.column_stack(
        (np.cos(places[:, 1, YAW]), np.sin(places[:, 1, YAW]))
    )
    off = np.hypot(*(places[:, 0, (X, Y)] - behind).T)
    assert off[0] > 2.0
    assert np.median(off[72:]) < 0.5
    assert apart(places).min() > 0.4
    assert speeds(places)[72:, 1].mean() > 0.8


def test_who_follows_goes_behind_a_leader_who_stands():
    """He faces south; she comes from before him, round him, to a step north of him."""
    ann = ANN | {"position": (0.3, -3.0), "behaviour": "follow", "options": {"whom": "joe"}}
    places = places_of({"joe": JOE, "ann": ann}, 192)
    assert np.hypot(*(places[-1, 0, (X, Y)] - (0.0, 0.8))) < 0.3
    assert apart(places).min() > 0.4


def rabbit(x, y):
    return {"model": "rabbit", "position": (x, y), "behaviour": "flee"}


def test_a_rabbit_runs_from_others_until_they_are_out_of_sight():
    places = places_of({"joe": JOE, "rabbit": rabbit(1.5, 0.5)}, 96)
    away = apart(places)
    assert np.isclose(speeds(places)[12:36, 1].max(), 3.0, atol=0.2)
    assert away[48:].min() > 5.5
    assert away.max() < 9.0
    assert np.all(np.diff(away[12:30]) > 0)


def test_a_rabbit_hops_about_among_its_own():
    places = places_of({"rabbit_1": rabbit(0, 0), "rabbit_2": rabbit(1.5, 0.5)}, 96)
    assert speeds(places).max() < 0.65
    assert speeds(places).max(axis=0).min() > 0.3


@pytest.mark.parametrize("sight", [15.0, 0.1])
def test_ostriches_gather_where_they_see_each_other(sight):
    herd = {"model": "ostrich", "count": 6, "side": 20.0, "behaviour": "herd"}
    places = places_of({}, 96, troupes={"ostrich": herd | {"options": {"sight": sight}}})
    xy = places[..., (X, Y)]
    spread = np.hypot(*np.moveaxis(xy - xy.mean(axis=1, keepdims=True), -1, 0)).mean(axis=1)
    assert bool(spread[-1] < 0.8 * spread[0]) is (sight > 1)
    assert bool(spread[-1] > spread[0]) is (sight < 1)


@pytest.mark.parametrize("kind", ["ostrich_2", "emu"])
def test_an_ostrich_goes_as_its_own_kind_goes(kind):
    other = {"model": "ostrich", "position": (5.0, 0.0), "heading": 90.0}
    both = {"ostrich_1": other | {"position": (0.0, 0.0), "behaviour": "herd"}, kind: other}
    script = ({"to": kind, "do": "go 1m/s"},)
    places = places_of(both, 144, script=script)[:, sorted(both).index("ostrich_1"), (X, Y)]
    east, north = (places[-1] - places[-25]).tolist()
    assert (east > 0.8 and abs(north) < 0.6) is (kind == "ostrich_2")


def test_a_windmill_turns_into_the_wind_no_faster_than_its_rate():
    mill = {"model": "windmill", "position": (0.0, 0.0), "heading": 0.0, "behaviour": "face_wind"}
    places = places_of({"mill": mill}, 192, wind={"direction": 300.0})
    heading = 90 - np.degrees(np.unwrap(places[:, 0, YAW]))
    assert np.isclose(heading[-1], 120.0, atol=1.0)
    assert np.isclose(np.abs(np.diff(heading)).max() * 24, 20.0, atol=1e-6)


@pytest.mark.parametrize("kind", ["watch", "chase"])
def test_a_camera_looks_at_whom_it_is_told_to(kind):
    """A camera that watches keeps its place; one that chases stays 4 m behind whoever walks."""
    whom = "joe right arm/hand" if kind == "watch" else "joe"
    options = {"whom": whom} | ({"distance": 4.0, "height": 3.0} if kind == "chase" else {})
    joe = JOE | {"behaviour": "walk", "options": {"side": 20.0, "waves": 0.0}}
    camera = {"position": (0.0, -12.0), "height": 1.7, "behaviour": kind, "options": options}
    target = ("joe", *RIGHT_HAND) if kind == "watch" else ("joe",)

    def look(stage):
        eye = stage.receive(ask("camera", "eye")).value
        return eye, stage.receive(ask(target, "where")).value

    seen = acted(preset({"joe": joe}, camera=camera), 72, look)
    for eye, there in seen:
        east, north = there[0] - eye.x, there[1] - eye.y
        ahead = np.radians(eye.heading)
        assert np.allclose(
            (np.sin(ahead), np.cos(ahead)), np.array((east, north)) / np.hypot(east, north)
        )
        aim = there[2] + (1.0 if kind == "chase" else 0.0) - eye.height
        assert np.isclose(eye.pitch, np.degrees(np.arctan2(aim, np.hypot(east, north))))
        if kind == "chase":
            assert np.isclose(np.hypot(east, north), 4.0)
            assert eye.height == 3.0
        else:
            assert (eye.x, eye.y, eye.height) == (0.0, -12.0, 1.7)
    assert np.hypot(*np.subtract(seen[-1][1], seen[0][1])[:2]) > 1.5


def test_who_coasts_and_is_asked_acts_before_it_answers(monkeypatch):
    """Nobody is due but once a second; in frame 10 the camera asks joe, and in frame 16 ann."""
    acts, told = {"joe": [], "ann": []}, []

    def notes(me):
        now = 0.0
        while True:
            acts[me.name].append(round(24 * now) + 1)
            yield change(me.name, "place", (0.0, now, 0.0))
            now = yield None

    def asks(me):
        for frame in range(1, 25):
            if frame in (10, 16):
                told.append((yield ask("joe" if frame == 10 else "ann", "position")))
            yield None

    monkeypatch.setitem(BEHAVIOURS, "tried", notes)
    monkeypatch.setitem(BEHAVIOURS, "asks", asks)
    both = {name: each | {"behaviour": "tried"} for name, each in (("joe", JOE), ("ann", ANN))}
    camera = {"position": (0.0, -2000.0), "height": 1.7, "behaviour": "asks"}
    done = performance_of(preset(both, acting={"threshold": 64.0}, camera=camera))
    updated = [done.frame(k).updated.tolist() for k in range(1, 25)]
    assert acts == {"joe": [1, 10], "ann": [1, 16]}
    assert told == [(0.0, 9 / 24, 0.0), (0.0, 15 / 24, 0.0)]
    assert [k for k, each in enumerate(updated, 1) if any(each)] == [1, 10, 16]
