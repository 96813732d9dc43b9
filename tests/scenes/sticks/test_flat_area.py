"""The largest area that flat triangles cover: analytic values, and no direction covers more."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from lod.shapes import Mesh, MeshTable
from scenes.sticks.flat_area import MOST_TRIANGLES, largest_flat_areas


def mesh(corners: np.ndarray) -> Mesh:
    """Make a mesh of triangles (t, 3, 3) that share no corner."""
    n = 3 * len(corners)
    points = np.asarray(corners, np.float64).reshape(n, 3)
    return Mesh(
        points, np.tile((0.0, 0, 1), (n, 1)), np.full((n, 3), 0.5), np.arange(n).reshape(-1, 3)
    )


def test_one_triangle_two_at_a_right_angle_and_none():
    flat = np.array([[(0, 0, 0), (2, 0, 0), (0, 3, 0)]])
    folded = np.concatenate((flat, [[(0, 0, 0), (2, 0, 0), (0, 0, 4)]]))
    found = largest_flat_areas(MeshTable.of([mesh(flat), None, mesh(folded)]))
    assert found == pytest.approx([3.0, 0.0, 5.0])


@given(st.integers(0, 10**6), st.integers(1, 6))
def test_no_direction_covers_more_and_one_covers_as_much(seed, triangles):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(triangles, 3, 3))
    (largest,) = largest_flat_areas(MeshTable.of([mesh(corners)]))
    toward = rng.normal(size=(4000, 3))
    toward /= np.linalg.norm(toward, axis=1)[:, None]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    covered = np.abs(toward @ normals.T).sum(axis=1).max()
    assert covered * (1 - 1e-9) <= largest <= 1.03 * covered


def test_too_many_triangles_are_refused():
    many = mesh(np.random.default_rng(0).normal(size=(MOST_TRIANGLES + 1, 3, 3)))
    with pytest.raises(InputError, match="13 triangles"):
        largest_flat_areas(MeshTable.of([many]))
