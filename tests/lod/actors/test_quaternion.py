import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from lod.actors.actor import (
    EAST,
    IDENTITY,
    NORTH,
    UP,
    Quaternion,
    angles_of,
    components,
    from_angles,
    pure_quaternion,
    rotate,
    rotation,
    unit,
)
from lod.errors import InputError

numbers = st.floats(-10, 10, allow_subnormal=False)
vectors = st.tuples(numbers, numbers, numbers)
quaternions = st.builds(Quaternion, numbers, numbers, numbers, numbers)
turns = quaternions.filter(lambda q: norm(q) > 1e-3).map(unit)


def close(a, b, tolerance=1e-12):
    return np.allclose(np.array(a), np.array(b), rtol=0, atol=tolerance)


def norm(q):
    return math.hypot(*components(q))


def matrix(q):
    """The rotated axes as columns, (3, 3)."""
    return np.array([rotate(q, axis) for axis in (EAST, NORTH, UP)]).T


def same_rotation(a, b, tolerance=1e-12):
    a, b = np.array(components(a)), np.array(components(b))
    return min(np.abs(a - b).max(), np.abs(a + b).max()) < tolerance


def test_the_formula_of_1843():
    i, j, k = pure_quaternion(EAST), pure_quaternion(NORTH), pure_quaternion(UP)
    for product in (i * i, j * j, k * k, i * j * k):
        assert components(product) == (0, 0, 0, -1)
    assert components(i * j) == components(k)
    assert components(j * i) == components(-k)


def test_they_mix_with_reals_and_divide():
    q = Quaternion(1.0, 2.0, 3.0, 4.0)
    assert components(2 * q + 1) == (2, 4, 6, 9)
    assert components(q / 2) == (0.5, 1, 1.5, 2)
    assert close(components(q / q), IDENTITY)
    assert close(components(1 / q * q), IDENTITY)


def test_a_quarter_turn_about_up_takes_east_to_north():
    assert close(rotate(rotation(UP, 90), EAST), NORTH)
    assert close(rotate(rotation(NORTH, 90), UP), EAST)


@given(turns, vectors)
def test_rotation_preserves_length(q, v):
    # math.hypot keeps its digits where the squares of a tiny vector underflow.
    assert math.hypot(*rotate(q, v)) == pytest.approx(math.hypot(*v), rel=1e-13, abs=1e-300)


@given(turns, turns)
def test_composition_is_the_matrix_product(a, b):
    assert close(matrix(a * b), matrix(a) @ matrix(b))


@given(turns)
def test_matrix_agrees_with_scipy(q):
    assert close(matrix(q), Rotation.from_quat(components(q)).as_matrix())


@given(turns)
def test_angles_and_back(q):
    """As SciPy has them; where the one about y is ±90° the other two are one."""
    assume(abs(q.w * q.y - q.z * q.x) < 0.499)
    angles = angles_of(q)
    assert same_rotation(from_angles(angles), q, 1e-7)
    theirs = Rotation.from_quat(components(q)).as_euler("xyz", degrees=True)
    assert close((np.array(angles) - theirs + 180) % 360, 180, 1e-6)


@given(vectors.filter(lambda v: np.linalg.norm(v) > 1e-3), st.floats(-720, 720))
def test_rotation_agrees_with_scipy(axis, angle):
    rotvec = np.radians(angle) * np.array(axis) / np.linalg.norm(axis)
    assert close(matrix(rotation(axis, angle)), Rotation.from_rotvec(rotvec).as_matrix())


def test_unit_quaternions_stay_unit_and_without_renormalising_they_would_not():
    # A step as little too long as single precision leaves it adds up.
    step, q = rotation((1.0, 2.0, 3.0), 41.3) * (1 + 6e-8), rotation(UP, 7.0)
    for _ in range(1000):
        q = q * step
    assert abs(norm(q) - 1.0) > 1e-5
    for _ in range(1000):
        q = unit(q * step)
        assert abs(norm(q) - 1.0) < 1e-14


@pytest.mark.parametrize(
    ("call", "named"),
    [
        (lambda: rotation((0, 0, 0), 40), "axis"),
        (lambda: pure_quaternion((1, 2)), "three numbers"),
        (lambda: unit(Quaternion(0, 0, 0, 0)), "quaternion"),
    ],
)
def test_what_is_no_rotation_is_refused(call, named):
    with pytest.raises(InputError, match=named):
        call()
