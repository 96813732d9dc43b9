"""Velocities that keep clear: two who meet, a crowd on a circle, and nobody near."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenes.actors.behaviours import orca_velocity

KEPT = 0.5
speeds = st.floats(-2, 2)


def test_whom_nobody_is_near_goes_as_it_wants():
    assert orca_velocity((0, 0, 1, 0), (0.5, 0.7), np.zeros((0, 5)), 2, 0.1, 2.0) == (0.5, 0.7)
    assert np.allclose(
        orca_velocity((0, 0, 1, 0), (3.0, 4.0), np.zeros((0, 5)), 2, 0.1, 1), (0.6, 0.8)
    )


@given(st.floats(0.6, 6), st.floats(0, 6.28), speeds, speeds, speeds, speeds)
def test_two_who_both_take_half_of_the_change_do_not_meet(away, angle, ax, ay, bx, by):
    """The relative velocity of two who do is outside the other's cone, for as long as they look."""
    other = away * np.array((np.cos(angle), np.sin(angle)))
    a, b, horizon = np.array((ax, ay)), np.array((bx, by)), 2.0
    mine = orca_velocity((0, 0, *a), tuple(a), np.array([[*other, *b, KEPT]]), horizon, 0.1, 9)
    theirs = orca_velocity((*other, *b), tuple(b), np.array([[0, 0, *a, KEPT]]), horizon, 0.1, 9)
    relative = np.array(mine) - theirs
    times = np.linspace(0, horizon, 400)[:, None]
    nearest = np.linalg.norm(other - times * relative, axis=1).min()
    assert nearest > KEPT - 1e-3


def test_twelve_on_a_circle_pass_to_the_other_side():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    goal = -5 * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    place, velocity = -goal + 0.01 * np.arange(24).reshape(12, 2), np.zeros((12, 2))
    nearest = np.inf
    for _ in range(400):
        way = goal - place
        wanted = way / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1.0)
        rows = np.column_stack((place, velocity, np.full(12, KEPT)))
        velocity = np.array([taken(rows, k, wanted[k]) for k in range(12)])
        place = place + 0.05 * velocity
        apart = np.linalg.norm(place[:, None] - place, axis=2) + 9 * np.eye(12)
        nearest = min(nearest, apart.min())
    assert nearest > KEPT - 0.01
    assert np.linalg.norm(place - goal, axis=1).max() < 4.0  # of 10 m, going round each other


def taken(rows, k, wanted):
    return orca_velocity(tuple(rows[k, :4]), tuple(wanted), np.delete(rows, k, 0), 2, 0.05, 1.3)
