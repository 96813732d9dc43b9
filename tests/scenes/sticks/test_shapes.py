"""Triangles beside sticks: what rays meet first, which side they see, and what is seen of each."""

import numpy as np
import pytest

from lod.shapes import Mesh, MeshTable, StickTable
from scenes.appearance.ray_grid import NOTHING, intersect_ray, make_grids, normal_at
from scenes.appearance.visible_area import visible_areas
from scenes.sticks.areas import directions
from scenes.sticks.prototype import Shapes

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


def stick(*rows):
    start, end, radius = (np.array(c, float) for c in zip(*rows, strict=True))
    none = np.zeros(len(rows), np.int64)
    return StickTable(np.array([0, len(rows)]), start, end, radius, radius, none)


def shapes(table, corners):
    corners = np.asarray(corners, float)
    return Shapes(table, corners, np.full((len(corners), 3), 0.5))


def met_by_solving(corners, origin, way):
    """Distance along a ray to each triangle, from its plane and barycentric coordinates."""
    found = []
    for a, b, c in corners:
        u, v, t = np.linalg.solve(np.column_stack((b - a, c - a, -way)), origin - a)
        found.append(t if u >= 0 and v >= 0 and u + v <= 1 and t > 0 else NOTHING)
    return np.array(found)


def test_rays_meet_the_nearest_triangle_and_see_the_side_that_they_come_from():
    rng = np.random.default_rng(8)
    corners = rng.normal(size=(60, 1, 3)) + 0.6 * rng.normal(size=(60, 3, 3))
    one = shapes(stick(((9, 9, 9), (9, 9, 9.1), 0.01)), corners)
    grids, hits = make_grids([one]), 0
    for _ in range(200):
        way = rng.normal(size=3)
        way /= np.linalg.norm(way)
        origin = rng.normal(size=3) - 4 * way
        expected = met_by_solving(corners, origin, way)
        t, row = intersect_ray(grids, 0, tuple(origin), tuple(way), NOTHING)
        assert t == pytest.approx(expected.min())
        if row >= 0:
            hits += 1
            assert row - 1 == expected.argmin()
            normal = normal_at(grids.shapes[row], origin + t * way, tuple(way))
            a, b, c = corners[row - 1]
            assert normal @ way < 0 and np.linalg.norm(normal) == pytest.approx(1)
            assert abs(normal @ (b - a)) < 1e-9 and abs(normal @ (c - a)) < 1e-9
    assert 50 < hits < 200


def test_a_triangle_shows_its_projected_area_from_either_side():
    corners = np.array([[(0.1, 0.2, 0.3), (1.4, 0.1, 0.8), (0.3, 1.2, 0.5)]])
    one = shapes(stick(((0, 0, -5), (0, 0, -4.9), 1e-3)), corners)
    full = np.cross(corners[0, 1] - corners[0, 0], corners[0, 2] - corners[0, 0]) / 2
    for direction in directions(7):
        for view in (direction, -direction):
            found = visible_areas(one, view[None], 0.004)[0, 1]
            assert found == pytest.approx(abs(full @ view), rel=0.01)


def test_a_board_before_a_ball_hides_it_and_one_behind_does_not():
    board = np.array([[(2, -3, -3), (2, 3, -3), (2, 0, 6)]])
    one = shapes(stick(((0, 0, 0), (0, 0.001, 0), 0.5)), board)
    toward, away = visible_areas(one, np.stack((X, -X)), 0.01)
    assert toward[0] == 0 and away[0] == pytest.approx(np.pi / 4, rel=0.01)
    assert toward[1] == pytest.approx(27, rel=0.01)
    assert away[1] == pytest.approx(27 - np.pi / 4, rel=0.01)


def two_boards():
    corners = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], float)
    up, faces = np.tile(Z, (3, 1)), np.array([[0, 1, 2]])
    colours = np.array([(0.1, 0.2, 0.3), (0.4, 0.5, 0.6), (0.7, 0.2, 0.3)])
    return MeshTable.of(
        [None, Mesh(corners, up, colours, faces), Mesh(corners + 5, up, colours, faces)]
    )


def test_meshes_of_some_parts_are_theirs_alone():
    every = two_boards()
    some = every.only(np.array([True, False, True]))
    assert some.count.tolist() == [0, 0, 1]
    assert np.array_equal(some.vertices, every.vertices[3:]) and some.faces.tolist() == [[0, 1, 2]]
    np.testing.assert_allclose(some.face_colours, [(0.4, 0.3, 0.4)])


def test_a_share_of_a_mesh_is_that_share_of_its_area_about_its_middle():
    whole, part = two_boards(), two_boards().with_area_share(0.25)
    for k in (0, 3):
        ours, own = part.vertices[k : k + 3], whole.vertices[k : k + 3]
        np.testing.assert_allclose(ours.mean(axis=0), own.mean(axis=0))
        np.testing.assert_allclose(ours - ours.mean(axis=0), 0.5 * (own - own.mean(axis=0)))
