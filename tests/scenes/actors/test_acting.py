"""Scenes that act: every change by a message, scripts, behaviours, and what goes wrong in them."""

import signal

import numpy as np
import pytest

from lod.actors.object_with_parts import ObjectWithParts, Refusal, Refused, ask, change
from lod.errors import InputError
from scenes.actors.behaviours import BEHAVIOURS
from scenes.actors.performance import EIGHTHS, YAW, X, Y, from_bytes, to_bytes, track_of
from scenes.actors.performance import performance_of as replay
from scenes.processes.streams import Stopped, raise_when_stopped, restore
from tests.scenes.actors.scene import ANN, JOE, acting_of, performance_of, preset

WALKERS = {"joe": JOE | {"behaviour": "walk"}, "ann": ANN | {"behaviour": "walk"}}


def told(chosen, frames=1):
    """The stage of a preset after some frames."""
    acting = acting_of(chosen)
    for _ in range(frames):
        acting.act()
    return acting.stage


def value(stage, message):
    return stage.receive(message).value


def test_a_scene_is_a_whole_that_answers_where_its_parts_are():
    stage = told(preset())
    where = np.array(value(stage, ask("joe/right arm/hand", "where")))
    assert np.hypot(*where[:2]) < 0.6
    assert 0.5 < where[2] < 1.2
    assert value(stage, ask("camera", "where")) == (0.0, -12.0, 1.7)
    assert value(stage, ask("", "near", "joe", 5.0)) == ("ann",)
    assert value(stage, ask("", "near", "joe", 3.0)) == ()
    refused = stage.receive(ask("jo", "heading"))
    assert refused == Refusal("scene", "has no part 'jo'; the nearest known route is 'joe'")


def test_a_refused_change_leaves_nobody_behind_the_time():
    """A change brings joe up to date first; refused, it takes that back: the next does it again."""
    stage = told(preset(script=({"to": "joe", "do": "go 1m/s"},)), 12)
    eye, before = value(stage, ask("camera", "eye")), value(stage, ask("joe", "course"))
    stage.receive(change("", "begin", 1.5, eye)).value  # noqa: B018
    assert isinstance(stage.receive(change("joe/head", "bend", (0, 170, 0))), Refusal)
    after = value(stage, ask("joe", "course"))
    assert np.isclose(np.hypot(after.x - before.x, after.y - before.y), 1.5 - 11 / 24)


def test_a_script_turns_a_part_in_its_time():
    """Half way through a smooth turn of 30° it is at 15°; it begins and ends at rest."""
    line = {"at": 0.25, "to": "joe head", "do": "orient z 30deg", "over": 0.5}
    acting, angles = acting_of(preset(script=(line,))), []
    for _ in range(24):
        acting.act()
        turn = value(acting.stage, ask("joe/head", "orientation"))
        angles.append(2 * np.degrees(np.arctan2(turn.z, turn.w)))
    assert np.allclose(angles[:7], angles[0], atol=1e-9)
    assert np.isclose(angles[12] - angles[0], 15.0, atol=1e-6)
    assert np.allclose(np.array(angles[18:]) - angles[0], 30.0, atol=1e-6)


@pytest.mark.parametrize(
    ("to", "do", "says"),
    [
        (
            "joe right leg/lower leg/foot",
            "orient y 140deg",
            "scene/joe/torso/right leg",
        ),
        (
            "joe right leg/toot",
            "orient y 4deg",
            "nearest known route is 'torso/right leg",
        ),
        ("jim", "go 1m/s", "has no part 'jim'; the nearest known route is 'joe'"),
        ("joe", "turn x 10deg", "stands upright"),
    ],
)
def test_a_refusal_is_one_line(to, do, says):
    with pytest.raises(InputError) as refused:
        told(preset(script=({"to": to, "do": do},)))
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_without_messages_nobody_moves(monkeypatch):
    before = performance_of(preset(WALKERS)).frame(24).places
    assert np.hypot(*(before[:, (X, Y)] - [(0, 0), (3, 1)]).T).min() > 0.3
    real = ObjectWithParts.receive

    def deaf(self, message):
        if message.action.changes and message.action.name != "begin":
            return Refusal(str(self), "nothing gets through")
        return real(self, message)

    monkeypatch.setattr(ObjectWithParts, "receive", deaf)
    with pytest.raises(InputError, match="nothing gets through"):
        performance_of(preset(WALKERS)).frame(24)


def with_behaviour(monkeypatch, behaviour, frames=3, **acting):
    monkeypatch.setitem(BEHAVIOURS, "tried", behaviour)
    chosen = preset({"joe": JOE | {"behaviour": "tried"}, "ann": ANN}, acting=acting)
    return told(chosen, frames)


def test_a_behaviour_sees_answers_and_refusals(monkeypatch):
    seen = []

    def looks(me):
        seen.append((yield ask("ann", "heading")))
        try:
            yield change("ann/head", "bend", (0, 170, 0))
        except Refused as refused:
            seen.append(refused.who)
        seen.append((yield))
        seen.append((yield))

    with_behaviour(monkeypatch, looks)
    assert seen[0] == 0.0
    assert seen[1].startswith("scene/ann/torso")
    assert seen[2:] == [1 / 24, 2 / 24]


def raises(me):
    yield
    raise RuntimeError("it breaks")


def interrupts(me):
    yield
    raise KeyboardInterrupt


class Odd(BaseException):
    pass


def raises_something_odd(me):
    yield
    raise Odd("two\nlines")


def chatters(me):
    while True:
        yield ask("ann", "heading")


def plain_function(me):
    return None


@pytest.mark.parametrize(
    ("behaviour", "says"),
    [
        (raises, "RuntimeError"),
        (raises_something_odd, "Odd"),
        (chatters, "at most 2000 messages"),
        (plain_function, "use yield in it"),
    ],
)
def test_what_a_behaviour_may_not_do_is_one_line(monkeypatch, behaviour, says):
    with pytest.raises(InputError, match=r"actors\.joe\.behaviour") as error:
        with_behaviour(monkeypatch, behaviour)
    assert says in str(error.value)
    assert "\n" not in str(error.value)


def test_a_signal_that_arrives_in_a_behaviour_ends_the_program(monkeypatch):
    def stopped(me):
        yield
        raise Stopped(signal.SIGINT)

    with pytest.raises(Stopped):
        with_behaviour(monkeypatch, stopped)
    before = raise_when_stopped()
    try:
        # Python's own handler of Ctrl-C, as in a notebook; a job in the background starts without
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with pytest.raises(KeyboardInterrupt):
            with_behaviour(monkeypatch, interrupts)
        raise_when_stopped()
        with pytest.raises(InputError, match="KeyboardInterrupt"):  # in a command it is no signal
            with_behaviour(monkeypatch, interrupts)
    finally:
        restore(before)


def test_who_leaves_is_gone_from_then_on(monkeypatch):
    def leaves(me):
        yield
        yield change(me.name, "leave")

    monkeypatch.setitem(BEHAVIOURS, "tried", leaves)
    done = performance_of(preset({"joe": JOE | {"behaviour": "tried"}, "ann": ANN}))
    assert np.isfinite(done.frame(1).places).all()
    ann, joe = done.frame(2).places  # in the order of their names
    assert np.isnan(joe).all() and np.isfinite(ann).all()


# The track


def test_a_track_replays_every_bit_and_the_same_seed_gives_the_same():
    chosen = preset(WALKERS, script=({"to": "ann head", "do": "orient z 20deg", "over": 0.4},))
    first, again = (track_of(performance_of(chosen)) for _ in range(2))
    assert first.digest == again.digest
    assert to_bytes(first) == to_bytes(again)
    other = track_of(performance_of(chosen.model_copy(update={"seed": 1})))
    assert other.digest != first.digest
    live, played = performance_of(chosen), replay(from_bytes(to_bytes(first)))
    for at in (1, 7, 12.5, 24, 0.75):
        a, b = live.between(at), played.between(at)
        assert np.array_equal(a.places, b.places)
        assert a.held == b.held


def test_a_damaged_track_is_none():
    data = to_bytes(track_of(performance_of(preset(WALKERS))))
    for at in (len(data) // 4, len(data) // 2):
        spoilt = bytearray(data)
        spoilt[at] ^= 1
        with pytest.raises(ValueError):
            from_bytes(bytes(spoilt))
    with pytest.raises(ValueError):
        from_bytes(data[: len(data) // 2])


# Who may wait


def test_between_frames_it_turns_the_shorter_way():
    half = {"position": (0.0, 0.0), "heading": -90.0, "model": "windmill"}
    line = {"to": "mill", "do": "go 0 24"}
    done = performance_of(preset({"mill": half}, (line,)))
    yaw = [done.between(at).places[0, YAW] for at in (2.0, 2.5, 3.0)]
    assert np.allclose(np.diff(yaw), np.radians(0.5), atol=1e-12)
    assert done.frame(1).places[0, EIGHTHS] == 8


def test_who_coasts_is_off_by_less_than_the_bound_and_the_threshold():
    """Against the same scene, in which everyone is updated in every frame."""
    far = {"camera": {"position": (0.0, -240.0), "height": 1.7}}
    every = performance_of(preset(WALKERS, **far))
    some = performance_of(preset(WALKERS, acting={"threshold": 0.5}, **far))
    updated = np.array([some.frame(k).updated for k in range(1, 25)])
    assert 0.1 < updated.mean() < 0.7
    bounds = np.array([some.frame(k).bound_px for k in range(1, 25)])
    assert bounds.max() <= 0.5
    off = every.frame(6).places[:, (X, Y)] - some.frame(6).places[:, (X, Y)]
    assert np.hypot(*off.T).max() < 0.3


def test_a_budget_updates_the_most_urgent():
    crowd = {"walker": {"model": "figure", "count": 6, "behaviour": "walk"}}
    done = performance_of(preset({}, acting={"budget": 2, "threshold": 0.001}, troupes=crowd))
    assert all(done.frame(k).updated.sum() <= 6 for k in range(1, 10))
    assert all(done.frame(k).updated.sum() >= 2 for k in range(1, 10))
    assert np.any([done.frame(k).updated.sum() < 6 for k in range(1, 10)])
