import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.actors.actor import (
    NORTH,
    JointLimits,
    Quaternion,
    RevoluteJoint,
    components,
    from_angles,
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


@given(turns)
def test_the_orientation_is_of_length_1_and_moving_keeps_its_bits(turn):
    joint = RevoluteJoint(turn=3 * turn)
    assert abs(math.hypot(*joint.turn) - 1) < 1e-15
    assert joint.with_position((1, 2, 3)).turn == joint.turn


@given(shares)
def test_every_turn_within_the_box_is_admitted(share):
    low, high = np.array((-200.0, -30.0, 5.0)), np.array((10.0, 80.0, 60.0))
    angles = low + np.array(share) * (high - low)
    RevoluteJoint((0, 0, 0), from_angles(angles), JointLimits(low, high))


@given(st.floats(-179, 179))
def test_a_hinge_turns_about_its_axis_within_its_range_only(angle):
    free = RevoluteJoint(limits=JointLimits((0, -10, 0), (0, 120, 0)))
    turn = rotation(NORTH, angle)
    if -10 <= angle <= 120:
        assert free.with_orientation(turn).orientation.w == turn.w
    else:
        with pytest.raises(InputError, match=r"turned from \(0.0, -10.0, 0.0\)"):
            free.with_orientation(turn)
    with pytest.raises(InputError):
        free.with_orientation(rotation((0.01, 1, 0), 60))


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: RevoluteJoint((0, np.nan, 0)), "position"),
        (lambda: RevoluteJoint(turn=(0, 0, 0, 0)), "orientation"),
        (lambda: RevoluteJoint(limits=JointLimits((1, 0, 0), (2, 0, 0))), "orientation"),
        (lambda: JointLimits((0, 1, 0), (0, 0, 0)), "limits.low"),
    ],
)
def test_what_no_joint_can_be_is_refused(call, named):
    with pytest.raises(InputError, match=named):
        call()
