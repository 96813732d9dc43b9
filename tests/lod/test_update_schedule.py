"""When a part is drawn again: never off by more than the threshold, whatever frame comes first."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.update_schedule import (
    WINDOW,
    TruePose,
    displacement_px,
    initial_state,
    refresh_due,
    replay,
    replay_frames,
    step,
    threshold_rule,
)

THETA = 1e-3
EYE = np.zeros(3)


def posed(x, refresh_due=(), eye=EYE):
    """One stick a part, 1 m high, at x (n,) m east of a place 10 m ahead."""
    x = np.asarray(x, float)
    low = np.stack((x, np.full(len(x), 10.0), np.zeros(len(x))), axis=1)
    marked = np.isin(np.arange(len(x)), refresh_due)
    return TruePose(low, low + np.array((0, 0, 1.0)), np.arange(len(x)), marked, eye, THETA)


def gone(speeds, frame):
    """Where parts that go so many pixels a frame are, (n,) [m]."""
    return np.array(speeds) * THETA * 10 * frame


def walk(speeds, frame, rule, part=None):
    """Parts that go so many pixels a frame, as frame ``frame`` draws them."""
    number = np.arange(len(speeds)) if part is None else part
    frames = (
        replace(posed(gone(speeds, at)), refresh_due=refresh_due(number, at))
        for at in replay_frames(frame)
    )
    return replay(frames, [rule])[0]


def test_how_far_a_part_is_off_is_the_angle_from_the_eye_in_pixels():
    """At 10 m, one pixel is 1 cm; the ends of a stick count, the farther one alone."""
    before = initial_state(posed([0.0, 0.0]))
    assert displacement_px(before, posed([0.0, 0.5])) == pytest.approx([0, math.atan(0.05) / THETA])
    turned = replace(posed([0.0]), end=np.array([[0.03, 10.0, 0.0]]))
    flat = replace(posed([0.0]), end=np.array([[0.0, 10.0, 0.0]]))
    assert displacement_px(initial_state(flat), turned)[0] == pytest.approx(3, rel=1e-4)


def test_what_goes_toward_the_eye_or_only_the_eye_moves_is_not_off():
    ahead = posed([0.0])
    nearer = replace(ahead, start=ahead.start * 0.9, end=ahead.end * 0.9)
    assert displacement_px(initial_state(ahead), nearer) == pytest.approx([0], abs=1e-9)
    assert displacement_px(initial_state(ahead), posed([0.0], eye=np.array((3.0, 2.0, 1.0)))) == 0


def test_those_past_the_threshold_are_drawn_anew_and_the_rest_are_kept():
    before = initial_state(posed([0.0, 0.0, 0.0]))
    after = step(before, posed([0.002, 0.006, 0.0], refresh_due=[2]), threshold_rule(0.5))
    assert after.updated.tolist() == [False, True, True]
    assert after.start[:, 0].tolist() == [0.0, 0.006, 0.0]
    assert after.error_px == pytest.approx([0.2, 0, 0], rel=1e-3)
    assert after.displacement_px == pytest.approx([0.2, 0.6, 0], rel=1e-3)


@given(
    st.lists(st.floats(-3, 3), min_size=1, max_size=6),
    st.integers(1, 90),
    st.sampled_from((0.25, 0.5, 1.0)),
)
def test_no_part_is_off_by_more_than_the_threshold(speeds, frame, threshold):
    drawn = walk(speeds, frame, threshold_rule(threshold))
    assert drawn.error_px.max() <= threshold
    assert (np.abs(drawn.start[:, 0] / 0.01 - np.array(speeds) * frame) <= threshold * 1.1).all()


@given(st.floats(-1, 1), st.integers(2, 80), st.integers(0, 200))
def test_a_frame_is_the_next_of_the_one_before_it_though_each_is_made_alone(speed, frame, part):
    """Replaying a window of frames gives the state of all frames from the first."""
    rule, number = threshold_rule(0.5), np.array([part])
    state = initial_state(posed(gone([speed], 1)))
    for at in range(2, frame + 1):
        state = step(
            state, replace(posed(gone([speed], at)), refresh_due=refresh_due(number, at)), rule
        )
    alone = walk([speed], frame, rule, number)
    assert np.array_equal(alone.start, state.start)
    assert np.array_equal(alone.updated, state.updated)


def test_a_slow_thing_does_not_stutter():
    """0.05 pixels a frame, ¼ pixel allowed: it goes on by steps of no more than 0.3 pixels."""
    places = [
        walk([0.05], frame, threshold_rule(0.25)).start[0, 0] / 0.01 for frame in range(1, 100)
    ]
    steps = np.diff(places)
    assert steps.min() >= 0
    assert steps.max() <= 0.25 + 0.05 + 1e-3


def test_every_part_has_its_turn_once_in_a_window_and_turns_are_spread():
    turns = np.array([refresh_due(np.arange(640), frame) for frame in range(1, WINDOW + 1)])
    assert (turns.sum(axis=0) == 1).all()
    assert (turns.sum(axis=1) == 640 / WINDOW).all()
