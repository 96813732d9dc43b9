"""What motion hides: never more than the least that anything of an object moves.

The window of visibility: cut-off frequency times speed is the limit in time.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.motion import (
    EASE_PER_FRAME,
    LIMIT_HZ,
    ShutterInterval,
    critical_hz,
    integration_time_s,
    motion_coarsening,
    motion_steps,
)

HERE = Corner(0, 0)
THETA = 1e-3
degrees = st.floats(-180, 180)
metres = st.floats(-3, 3)


def camera(eye, heading, pitch, corner=HERE):
    return camera_from_heading(corner, np.array(eye), heading, pitch, 60.0, (320, 180))


def exposure(*cameras):
    return ShutterInterval(*cameras, 0.0, 1 / 48)


def length_of(motion_step):
    """L over θ from the scale: the other way round."""
    x = motion_coarsening(motion_step) ** 2
    return math.sqrt(max(4 * x**4 / (x + 1) - (x + 1), 0))


def one(exposed, start, end, bound=0.0, own=0.0):
    rows = (np.array([start], float), np.array([end], float))
    return float(motion_steps(exposed, HERE, THETA, *rows, np.array([bound]), np.array([own]))[0])


def of_length(length):
    """The scale at L = ``length``·θ."""
    chord = 2 * math.sin(math.radians(1))
    theta = chord / length if length else 1.0
    closes = camera((0, 0, 0), 2 if length else 0, 0)
    exposed = exposure(camera((0, 0, 0), 0, 0), closes)
    place = np.array([[0.0, 50.0, 0.0]])
    return float(motion_steps(exposed, HERE, theta, place, place, np.zeros(1), np.zeros(1))[0])


def in_camera(each, point):
    axes = np.stack((each.right, each.forward, each.up))
    direction = axes @ (point - each.eye)
    return direction / np.linalg.norm(direction)


def test_a_pan_smears_what_is_at_the_horizon_by_its_whole_angle():
    motion_step = one(
        exposure(camera((0, 0, 0), 0, 0), camera((0, 0, 0), 2, 0)), (0, 50, 0), (0, 50, 0)
    )
    chord = 2 * math.sin(math.radians(1)) / THETA
    assert length_of(motion_step) == pytest.approx(chord, rel=1e-9)


@pytest.mark.parametrize("length", [0.0, 0.3, 2.0, 18.75, 400.0])
def test_what_is_left_out_is_never_more_energy_than_at_rest(length):
    """Mass² over the blurred area, of an even part of the size of m: what it is at L = 0 (½)."""
    g = motion_coarsening(of_length(length))
    assert g**4 / math.sqrt((g**2 + 1) * (g**2 + 1 + length**2)) == pytest.approx(0.5, rel=1e-9)


def test_what_the_camera_follows_is_sharp():
    """Object and eye go the same way: their relative motion counts."""
    exposed = exposure(camera((0, 0, 0), 0, 0), camera((1.5, 0, 0), 0, 0))
    assert one(exposed, (0, 30, 0), (1.5, 30, 0), bound=1.0) == 0
    assert one(exposed, (0, 30, 0), (0, 30, 0), bound=1.0) > 0


def test_at_rest_nothing_is_hidden_to_the_last_bit():
    chance = np.random.default_rng(3)
    still = camera((1.3, 2.7, 1.1), 37.3, -4.1)
    place, bound = chance.normal(0, 40, (500, 3)), chance.uniform(0, 5, 500)
    none = motion_steps(exposure(still, still), HERE, THETA, place, place, bound, np.zeros(500))
    assert not none.any()


def test_the_eye_is_the_same_from_every_corner():
    near = exposure(camera((20, 3, 0), 0, 0), camera((20, 3, 0), 3, 0))
    cameras = [camera((4, 3, 0), h, 0, Corner(1, 0)) for h in (0, 3)]
    place = ((30.0, 60.0, 1.0),) * 2
    assert one(near, *place, 2.0) == one(exposure(*cameras), *place, 2.0)


@given(
    st.tuples(degrees, st.floats(-60, 60), st.floats(-8, 8), st.floats(-8, 8)),
    st.tuples(metres, metres, metres),
    st.tuples(metres, metres, metres),
    st.floats(0.01, 8),
    st.floats(0, 0.5),
    st.integers(0, 2**32 - 1),
)
def test_nothing_in_an_object_moves_less_than_is_said(turn, goes, walks, bound, own, seed):
    heading, pitch, about, nod = turn
    chance = np.random.default_rng(seed)
    opens = camera((0, 0, 0), heading, pitch)
    closes = camera(goes, heading + about, pitch + nod)
    start = chance.normal(0, 25, 3)
    assume(np.linalg.norm(start) > 1)
    end = start + np.array(walks)
    least = length_of(one(exposure(opens, closes), start, end, bound, own)) * THETA
    for _ in range(200):
        off, on = chance.normal(0, 1, (2, 3))
        off *= bound * chance.uniform() ** 0.2 / np.linalg.norm(off)
        on *= own * chance.uniform() / np.linalg.norm(on)
        after = in_camera(closes, end + off + on)
        moved = np.linalg.norm(after - in_camera(opens, start + off))
        assert moved >= least * (1 - 1e-9) - 1e-9


def turning(frame):
    """A camera that turns by 4° a frame until frame 10, and stops there."""
    return [camera((0, 0, 0), 4 * min(frame + half, 10.0), 0) for half in (-0.25, 0.25)]


def at(frame):
    return ShutterInterval(*turning(frame), (frame - 0.25) / 24, (frame + 0.25) / 24)


def in_frame(frame, eased=True):
    """What is hidden of what stands and of what walks."""
    near = (lambda later: at(frame + later)) if eased else None
    place = np.array([[20.0, 50.0, 1.0], [0.0, 40.0, 1.0], [0.0, 30.0, 0.0]])
    walked = place + np.array([[0, 0, 0], [0.02, 0, 0], [0, 0, 0]])
    bound, own = np.array([1.0, 1.0, 5.0]), np.array([0.0, 0.01, 0.0])
    return motion_steps(replace(at(frame), neighbour=near), HERE, THETA, place, walked, bound, own)


def test_what_is_hidden_eases_before_a_camera_stops():
    """The largest that goes by EASE at most and is never more than the frame's own."""
    frames = range(-20, 14)
    own = np.array([in_frame(frame, False) for frame in frames])
    eased = np.array([in_frame(frame) for frame in frames])
    far = abs(np.subtract.outer(frames, frames))
    expected = (own[None] + EASE_PER_FRAME * far[..., None]).min(axis=1)
    assert np.abs(np.diff(own, axis=0)).max() > 5 * EASE_PER_FRAME
    assert np.abs(np.diff(eased, axis=0)).max() <= EASE_PER_FRAME * (1 + 1e-6)
    assert np.allclose(eased[:, ::2], expected[:, ::2], atol=1e-9)
    assert np.allclose(eased, expected, atol=0.05)  # one walks on as it does in each frame
    assert not eased[-1][::2].any()
    assert np.array_equal(eased[0], own[0])


@given(st.floats(0.1, 500), st.floats(0.01, 60), st.floats(5, 80))
def test_what_flickers_faster_than_the_limit_is_smaller_than_its_smear(speed, frequency, limit):
    """A grating is out of the window where speed × frequency exceeds ω_l."""
    half_period = 1 / (2 * frequency)
    smear = speed * integration_time_s(0.0, limit)
    if abs(speed * frequency - limit) > 1e-9 * limit:
        assert (half_period < smear) == (speed * frequency > limit)


def test_the_rate_that_looks_smooth_is_the_published_one():
    """At rest the limit of flicker, and u_l more for each degree a second."""
    assert critical_hz(np.array((0.0, 2.0)), 10.0).tolist() == [LIMIT_HZ, LIMIT_HZ + 20]
