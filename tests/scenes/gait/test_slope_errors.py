"""All who walk, on slopes of up to 0.3 in any direction, at any stride: joints, bones and feet."""

from functools import lru_cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from scenes.gait.patrol import MIN_STRIDE_FACTOR
from scenes.gait.slope_errors import SlopeTrial
from scenes.models.animals.catalogue import ANIMALS, animal, animal_tables
from scenes.models.people.people import people_at_rest
from scenes.models.people.walking import walking_people

PEOPLE = {"person": 0.0, "child": 1.0}
WALKERS = [*PEOPLE, *(name for name in ANIMALS if animal_tables(name).gait.legs)]
STANDS_WELL = 0.16
"""Of the ground under a herd of the preset zoo 99 % is no steeper."""


@lru_cache(maxsize=8)
def walker(name):
    return (
        walking_people(people_at_rest(5, 1, PEOPLE[name]), 0)[0] if name in PEOPLE else animal(name)
    )


def plane(steep, way):
    return steep * np.array((np.cos(way), np.sin(way)))


WAYS = st.floats(0, 2 * np.pi)
PACES = st.floats(MIN_STRIDE_FACTOR, 1)


@pytest.mark.parametrize("name", WALKERS)
@settings(max_examples=8)
@given(st.floats(0, 0.3), WAYS, PACES)
def test_no_joint_goes_beyond_its_limits(name, steep, way, stride_factor):
    on = SlopeTrial(walker(name), plane(steep, way), stride_factor)
    assert on.who.rig.limit_excess(on.rotations()).max() < 1e-5


@pytest.mark.parametrize("name", WALKERS)
@settings(max_examples=8)
@given(st.floats(0, 1), WAYS, PACES)
def test_feet_that_stand_are_on_the_ground_and_stay_there(name, share, way, stride_factor):
    """Within 2 cm where it rises by up to 0.16, within 5 cm on any slope that feet follow."""
    who = walker(name)
    for steepest, most in ((STANDS_WELL, 0.02), (0.3, 0.05)):
        steps = SlopeTrial(who, plane(share * steepest, way), stride_factor).steps()
        assert max(steps.sinks, steps.floats, steps.slides) < most


@pytest.mark.parametrize("name", WALKERS)
def test_bones_keep_their_lengths(name):
    on = SlopeTrial(walker(name), np.array((0.2, -0.2)), 0.9)
    for leg in on.who.motion.feet.legs.tolist():
        bones = np.diff(on.riding(on.instances, leg, np.zeros((3, 3))), axis=1)
        length = np.linalg.norm(on.who.rig.offset[leg[1:]], axis=1)
        assert np.allclose(np.linalg.norm(bones, axis=-1), length, rtol=1e-12)
