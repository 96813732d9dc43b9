"""All who walk, on slopes of up to 0.3 in any direction, at any stride: joints, bones and feet."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from scenes.animals import KINDS, animal
from scenes.gait_measure import finest
from scenes.gait_people import walkers
from scenes.patrol import SHORTEST
from scenes.rig_cast import Cast
from scenes.rig_figure import rigged_people
from scenes.rig_pose import pose_points
from scenes.rig_stand import bodies_on
from scenes.rig_turns import inverse, product

PEOPLE = {"person": 0.0, "child": 1.0}
WALKERS = [*PEOPLE, *(name for name, kind in KINDS.items() if kind.gait.legs)]
PHASES = (np.arange(32) + 0.37) / 32


@lru_cache(maxsize=8)
def walker(name):
    who = walkers(rigged_people(5, 1, PEOPLE[name]), 0)[0] if name in PEOPLE else animal(name)
    return who, Cast.of((who,))


def on(cast, slope, pace):
    """One walker at all phases, facing x where the plane's height is 0."""
    n = len(PHASES)
    same = np.zeros((n, 2)), np.ones(n), np.zeros(n), np.zeros(n, np.int64)
    return bodies_on(cast, lambda xy: xy @ slope, *same, PHASES, np.full(n, pace))


def riding(cast, bodies, joints, places):
    """Points that ride on joints, of every body, (bodies, m, 3)."""
    rows, items = np.divmod(np.arange(len(bodies) * len(joints)), len(joints))
    at = pose_points(cast, bodies, rows, items, np.asarray(places, np.float64), np.asarray(joints))
    return at.reshape(len(bodies), len(joints), 3)


def facing(cast, bodies, joint):
    """How a joint is turned in the frame, as quaternions."""
    at = riding(cast, bodies, [joint] * 4, np.vstack((np.zeros(3), np.eye(3))))
    axes = np.swapaxes(at[:, 1:] - at[:, :1], 1, 2)
    return Rotation.from_matrix(axes).as_quat()


def soles(who, cast, bodies, ankle, slope):
    """How far the lowest of a foot and its toes is above the ground at every phase [m]."""
    below = {ankle}
    for joint, parent in enumerate(who.rig.parent.tolist()):
        below |= {joint} if parent in below else set()
    ends = [
        (joint, point, radius)
        for t in finest(who)
        for joints, points, radii in (
            (t.start_joint, t.start, t.start_radius),
            (t.end_joint, t.end, t.end_radius),
        )
        for joint, point, radius in zip(joints.tolist(), points, radii, strict=True)
        if joint in below
    ]
    joints, points, radii = zip(*ends, strict=True)
    at = riding(cast, bodies, joints, points)
    return (at[..., 2] - at[..., :2] @ slope - np.array(radii)).min(axis=1)


SLOPES = st.tuples(st.floats(0, 0.3), st.floats(0, 2 * np.pi))
PACES = st.floats(SHORTEST, 1)


@pytest.mark.parametrize("name", WALKERS)
@settings(max_examples=12)
@given(SLOPES, PACES)
def test_no_joint_goes_beyond_its_limits(name, slope, pace):
    (who, cast), (steep, way) = walker(name), slope
    rig = who.rig
    bodies = on(cast, steep * np.array((np.cos(way), np.sin(way))), pace)
    turns = np.tile(rig.rest, (len(PHASES), 1, 1))
    for row in who.motion.feet.legs.ravel().tolist():
        above = facing(cast, bodies, int(rig.parent[row]))
        turns[:, row] = product(inverse(above), facing(cast, bodies, row))
    assert rig.beyond(turns).max() < 1e-5


@pytest.mark.parametrize("name", WALKERS)
@settings(max_examples=12)
@given(SLOPES, PACES)
def test_feet_that_stand_are_on_the_ground(name, slope, pace):
    """Within 2 cm where it rises by up to a tenth, and 6 cm on any slope that feet follow."""
    (who, cast), (steep, way) = walker(name), slope
    slope = steep * np.array((np.cos(way), np.sin(way)))
    bodies, feet = on(cast, slope, pace), who.motion.feet
    for foot, ankle in enumerate(feet.legs[:, 2].tolist()):
        stands = (PHASES - feet.strike[foot]) % 1 <= feet.duty[foot]
        above = soles(who, cast, bodies, ankle, slope)[stands]
        assert np.abs(above).max() < (0.02 if steep <= 0.1 else 0.06)


@pytest.mark.parametrize("name", WALKERS)
def test_bones_keep_their_lengths(name):
    who, cast = walker(name)
    bodies = on(cast, np.array((0.2, -0.2)), 0.9)
    for leg in who.motion.feet.legs.tolist():
        bones = np.diff(riding(cast, bodies, leg, np.zeros((3, 3))), axis=1)
        length = np.linalg.norm(who.rig.offset[leg[1:]], axis=1)
        assert np.allclose(np.linalg.norm(bones, axis=-1), length, rtol=1e-12)
