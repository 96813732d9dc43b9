"""Gaits and patrols: feet stay where they stand, joints keep their limits, nobody dawdles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from scenes.field.species_field import MIN_STRIDE_FACTOR, PatrolOrbit, stride_factors
from scenes.figures.animal_file import animal, people_at_rest, walking_gait, walking_people
from scenes.figures.gait import heel_and_ball, make_motion
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import PoseTables, pose_points
from scenes.rig.rig import to_euler
from tests.scenes.figures.contact_errors import sample_cycle
from tests.scenes.figures.motion_phase import motion_at


def someone(child=False):
    return people_at_rest(5, 1, 1.0 if child else 0.0)[0]


def test_knees_bend_backwards_and_elbows_forwards():
    who = walking_people((someone(),), 0)[0]
    seen, row = sample_cycle(who), who.rig.row
    for side in ("left", "right"):
        hip, knee, ankle = (seen.origin[:, row(f"{side} {j}")] for j in ("hip", "knee", "ankle"))
        middle = hip + (ankle - hip) * 0.5
        assert np.all((knee - middle)[:, 0] > 0)
        flexed = to_euler(seen.rotations[:, row(f"{side} knee")])[:, 1]
        assert 50 < flexed.max() < 75  # in the swing (Perry & Burnfield)
        assert np.all(to_euler(seen.rotations[:, row(f"{side} elbow")])[:, 1] < 0)


def test_arms_swing_against_legs_and_the_head_stays():
    who = walking_people((someone(),), 0)[0]
    seen, row = sample_cycle(who), who.rig.row
    hand, foot = (seen.origin[:, row(f"left {j}"), 0] for j in ("wrist", "ankle"))
    assert np.corrcoef(hand, foot)[0, 1] < -0.8
    turn = to_euler(seen.facing[:, row("head")])
    assert np.abs(turn[:, 2]).max() < 3
    assert np.ptp(seen.origin[:, row("head"), 2]) < 0.06


def test_the_cycle_closes_smoothly():
    who = walking_people((someone(),), 0)[0]
    step = 1 / 160
    phases = np.arange(-3, 164) * step
    poses = zip(*[motion_at(who.motion, float(p)) for p in phases], strict=True)
    origins = who.rig.frames(*map(np.array, poses))[0]
    assert np.allclose(origins[0], origins[160], atol=1e-12)
    speed = np.diff(origins, axis=0) / step / who.motion.stride
    jump = np.abs(np.diff(speed, axis=0)).max(axis=(1, 2))
    assert jump[:6].max() <= jump[6:-6].max()  # nothing special happens where it closes
    assert np.abs(speed).max() < 4.0


def test_people_walk_as_fast_as_people_do():
    """The mean over adults and their strides is within what 41 studies found (Bohannon & Andrews
    2011: means of 1.24 to 1.43 m/s by sex and decade, up to 69 years); nobody dawdles or runs.
    """
    adults = walking_people(people_at_rest(0, 8, 0.0), 0)
    stride, period = stride_factors(np.linspace(0, 1, 33))
    speeds = np.array([who.motion.speed for who in adults])[:, None] * (stride / period)
    assert 1.24 < speeds.mean() < 1.43
    assert 0.8 < speeds.min() < speeds.max() < 1.9


def test_a_stride_too_long_is_refused():
    with pytest.raises(InputError, match="reach"):
        make_motion(someone(), walking_gait(froude=3.0))


def riding(cast, instances, joint, place=(0.0, 0.0, 0.0)):
    """A point that rides on a joint, of every body."""
    rows = np.arange(len(instances.phase))
    return pose_points(cast, instances, rows, 0 * rows, np.array([place]), np.array([joint]))


@given(st.floats(0, 2 * np.pi), st.booleans(), st.floats(0, 1), st.floats(-1e7, 1e7))
def test_a_patrol_is_a_circle_about_home_at_an_even_speed(heading, clockwise, phase, time):
    ways = (
        np.array([heading]),
        np.array([clockwise]),
        np.array([phase]),
        np.array([1.3]),
        np.array([1.0]),
    )
    here, next_, soon = (PatrolOrbit(10.0, *ways).at(t) for t in (time, time + 1e-3, time + 1.0))
    assert np.linalg.norm(here.offset) == pytest.approx(10.0)
    moved = (next_.offset - here.offset)[0]
    assert np.linalg.norm(moved) == pytest.approx(1.3e-3, rel=1e-3)
    assert moved @ (here.cos[0], here.sin[0]) == pytest.approx(1.3e-3, rel=1e-3)
    assert (soon.phase - here.phase)[0] % 1 == pytest.approx(0, abs=1e-6) or (
        soon.phase - here.phase
    )[0] % 1 == pytest.approx(1, abs=1e-6)


def foot_slip(stance, ahead, aside, radius):
    """How far a foot slips on its print while the body goes ``stance`` m along a circle [m].

    ahead, aside: where the print is, as the body is half-way through, from the body [m].
    """
    gone = np.linspace(-stance / 2, stance / 2, 65)
    angle, x = gone / radius, ahead - gone
    east = radius * np.sin(angle) + x * np.cos(angle) - aside * np.sin(angle)
    north = radius * (1 - np.cos(angle)) + x * np.sin(angle) + aside * np.cos(angle)
    return np.hypot(np.subtract.outer(east, east), np.subtract.outer(north, north)).max()


def test_a_walker_on_its_circle_skates_by_less_than_two_centimetres():
    who = walking_people((someone(),), 0)[0]
    motion, gait = who.motion, walking_gait()
    radius = stance = gait.duty * motion.stride
    while max(foot_slip(stance, -0.08, aside, radius) for aside in (0.1, -0.1)) > 0.015:
        radius *= 1.05
    times = np.linspace(0.09, 0.60, 40) * motion.period
    ball = heel_and_ball(who, who.rig.row("left ankle")).ball
    feet = []
    for t in times:
        one = (np.zeros(1), np.array([False]), np.zeros(1))
        orbit = PatrolOrbit(radius, *one, np.array([motion.stride]), np.array([motion.period]))
        w = orbit.at(float(t))
        cast, here = PoseTables.of((who,)), (w.cos, w.sin, np.zeros(1, np.int64), w.phase)
        instances = place_on_ground(
            cast, lambda xy: np.zeros(len(xy)), Placements(w.offset, *here, np.ones(1))
        )
        ankle = who.rig.row("left ankle")
        feet.append(riding(cast, instances, ankle, (ball[0], 0.0, ball[1]))[0, :2])
    feet = np.array(feet)
    assert np.linalg.norm(feet[:, None] - feet[None], axis=-1).max() < 0.02


@pytest.mark.parametrize("name", ["person", "child", "rabbit", "giraffe", "ostrich", "insect"])
def test_no_ground_and_no_stride_exceed_R_or_B(name):
    """On ground rougher than any: every height drawn by itself."""
    who = (
        walking_people((someone(name == "child"),), 0)[0]
        if name in ("person", "child")
        else animal(name)
    )
    cast, rng, count, h = PoseTables.of((who,)), np.random.default_rng(4), 60, who.hierarchy
    here = np.zeros((count, 2)), np.ones(count), np.zeros(count), np.zeros(count, np.int64)
    drawn = rng.random(count), rng.uniform(MIN_STRIDE_FACTOR, 1, count)
    instances = place_on_ground(
        cast, lambda xy: rng.normal(0, 50, len(xy)), Placements(*here, *drawn)
    )

    def everywhere(points, joints):
        rows, items = np.divmod(np.arange(count * len(points)), len(points))
        at = pose_points(cast, instances, rows, items, points, joints)
        return at.reshape(count, len(points), 3)

    origin = everywhere(np.zeros((len(h), 3)), who.joint)
    apart = np.linalg.norm(origin[:, 1:] - origin[:, h.parent[1:]], axis=-1)
    assert np.all(apart <= h.separation[1:] + 1e-9)
    for table in (who.inner, who.leaf):
        for joint, point, radius in (
            (table.start_joint, table.start, table.start_radius),
            (table.end_joint, table.end, table.end_radius),
        ):
            at, part, steps = everywhere(point, joint), table.owner, 0
            while len(part):
                far = (np.linalg.norm(at - origin[:, part], axis=-1) + radius).max(axis=0)
                assert np.all(far <= (h.R if steps < 2 else h.B)[part] + 1e-9)
                keep = h.parent[part] >= 0
                at, radius, part = at[:, keep], radius[keep], h.parent[part[keep]]
                steps += 1
