import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import GRID_M, Corner, camera_from_heading, split_position

CELLS = st.integers(-(2**40), 2**40)


def camera(width=640, fov=60.0, **where):
    where = {"heading_deg": 0.0, "pitch_deg": 0.0} | where
    return camera_from_heading(Corner(0, 0), np.zeros(3), fov_x_deg=fov, size=(width, 360), **where)


def test_the_angle_of_a_pixel():
    assert camera().pixel_angle == pytest.approx(2 * math.tan(math.radians(30)) / 640, rel=1e-15)


@pytest.mark.parametrize(
    ("heading", "forward"), [(0, (0, 1, 0)), (90, (1, 0, 0)), (180, (0, -1, 0)), (270, (-1, 0, 0))]
)
def test_headings_are_compass_headings(heading, forward):
    assert camera(heading_deg=heading).forward == pytest.approx(forward, abs=1e-15)


@given(heading=st.floats(-720, 720), pitch=st.floats(-90, 90))
def test_axes_are_orthonormal(heading, pitch):
    made = camera(heading_deg=heading, pitch_deg=pitch)
    axes = np.stack((made.right, made.forward, made.up))
    assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-12)
    assert np.linalg.det(axes) == pytest.approx(1.0)


@given(x=CELLS, y=CELLS, exponent=st.integers(-3, 30))
def test_lattices_are_exact(x, y, exponent):
    ix, iy, rest_x, rest_y = Corner(x, y).lattice(2.0**exponent)
    side = Fraction(2) ** exponent
    assert ix * side + Fraction(rest_x) == x * Fraction(GRID_M)
    assert iy * side + Fraction(rest_y) == y * Fraction(GRID_M)
    assert 0 <= rest_x < side
    assert 0 <= rest_y < side


@given(x=st.floats(-1e6, 1e6), cell=CELLS)
def test_a_point_keeps_its_place_when_split(x, cell):
    corner, offset, _ = split_position(x, 0.0, cell, 0)
    assert 0 <= offset < GRID_M or offset == pytest.approx(GRID_M)
    moved = (corner.x - cell) * Fraction(GRID_M) + Fraction(offset)
    assert abs(moved - Fraction(x)) < Fraction(1, 10**9)
