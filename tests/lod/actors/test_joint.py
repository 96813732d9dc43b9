import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.actors.joint import IDENTITY_JOINT, JointLimits, RevoluteJoint
from lod.actors.quaternion import (
    NORTH,
    UP,
    Quaternion,
    components,
    from_rotation_vector,
    rotate,
    rotation,
    unit,
)
from lod.errors import InputError

numbers = st.floats(-10, 10, allow_subnormal=False)
quaternions = st.builds(Quaternion, numbers, numbers, numbers, numbers)
turns = quaternions.filter(lambda q: np.linalg.norm(components(q)) > 1e-3).map(unit)
places = st.tuples(numbers, numbers, numbers)
shares = st.tuples(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))


@given(places, turns, places)
def test_first_turned_then_moved(position, turn, point):
    joint = RevoluteJoint(position, turn)
    assert np.allclose(joint.to_whole(point), np.add(rotate(turn, point), position), atol=1e-12)


@given(places, turns, places, turns, places)
def test_joints_carry_one_another(here, turn, there, again, point):
    whole, part = RevoluteJoint(here, turn), RevoluteJoint(there, again)
    assert np.allclose(
        whole.compose(part).to_whole(point), whole.to_whole(part.to_whole(point)), atol=1e-12
    )


@given(places, turns)
def test_nothing_is_carried_nowhere(position, turn):
    joint = RevoluteJoint(position, turn)
    assert IDENTITY_JOINT.compose(joint) == joint


@given(turns)
def test_the_orientation_is_of_length_1_and_moving_keeps_its_bits(turn):
    joint = RevoluteJoint(turn=3 * turn)
    assert abs(math.hypot(*joint.turn) - 1) < 1e-15
    assert joint.with_position((1, 2, 3)).turn == joint.turn


@given(turns, shares)
def test_every_turn_within_the_box_is_admitted(rest, share):
    low, high = np.array((-200.0, -30.0, 5.0)), np.array((10.0, 80.0, 60.0))
    limits = JointLimits(low, high, rest)
    angles = low + np.array(share) * (high - low)
    joint = RevoluteJoint((0, 0, 0), limits.orientation(angles), limits)
    assert joint.with_angles(angles).turn == joint.turn


@given(st.floats(-179, 179))
def test_a_hinge_turns_about_its_axis_within_its_range_only(angle):
    rest = rotation(UP, 20)
    limits = JointLimits((0, -10, 0), (0, 120, 0), rest)
    assert limits.contains(unit(rest * rotation(NORTH, angle))) == (-10 <= angle <= 120)
    assert not limits.contains(unit(rest * rotation((0.01, 1, 0), 60)))


def test_angles_are_read_back_as_they_were_bent():
    joint = RevoluteJoint(
        limits=JointLimits((-90, 0, 0), (90, 120, 0), rotation(UP, 45)), turn=rotation(UP, 45)
    )
    assert np.allclose(joint.with_angles((10, 70, 0)).angles_deg, (10, 70, 0))
    assert components(IDENTITY_JOINT.with_angles((0, 30, 0)).orientation) == components(
        from_rotation_vector((0, 30, 0))
    )


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: RevoluteJoint((0, np.nan, 0)), "position"),
        (lambda: RevoluteJoint((0, 0)), "position"),
        (lambda: RevoluteJoint(turn=(0, 0, 0, 0)), "orientation"),
        (lambda: RevoluteJoint(turn=(0, 0, 1)), "orientation"),
        (lambda: RevoluteJoint(limits=JointLimits((1, 0, 0), (2, 0, 0))), "orientation"),
        (
            lambda: RevoluteJoint(limits=JointLimits((0, 0, 0), (0, 9, 0))).with_angles((0, 10, 0)),
            "orientation",
        ),
        (lambda: JointLimits((0, 1, 0), (0, 0, 0)), "limits.low"),
        (lambda: JointLimits((0, 1, 0), (0, np.inf, 0)), "limits.high"),
    ],
)
def test_what_no_joint_can_be_is_refused(call, named):
    with pytest.raises(InputError, match=named):
        call()
