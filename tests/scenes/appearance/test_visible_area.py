"""What is seen of each stick: whole areas where nothing hides it, and who stands before whom."""

import numpy as np
import pytest

from lod.shapes import StickTable
from scenes.appearance.visible_area import visible_areas
from scenes.sticks.areas import areas_of_parts, directions, outline_area

X = np.array([1.0, 0.0, 0.0])


def table(rows):
    """Rows are (start, end, start radius, end radius)."""
    start, end, r0, r1 = (np.array(c, float) for c in zip(*rows, strict=True))
    first = np.array([0, len(rows)])
    return StickTable(first, start, end, r0, r1, np.zeros(len(rows), np.int64))


def test_alone_it_shows_its_whole_outline_whatever_its_taper():
    for r0, r1 in ((0.5, 0.5), (0.7, 0.1), (0.1, 0.7), (1.5, 0.2)):
        one = table([((0.1, 0.2, 0.3), (0.4, 1.1, 1.0), r0, r1)])
        for direction in directions(7):
            area = visible_areas(one, direction[None], 0.01)[0, 0]
            apart = np.linalg.norm(np.cross(one.end - one.start, direction), axis=1)
            exact = outline_area(one.start_radius, one.end_radius, apart)[0]
            assert area == pytest.approx(exact, rel=2e-3)


def test_the_nearer_hides_the_farther():
    far, near = ((0, 0, 0), (0, 0.1, 0), 1.0, 1.0), ((3, 0, 0), (3, 0.1, 0), 0.5, 0.5)
    for rows in ((far, near), (near, far)):
        big = rows.index(far)
        toward, away = visible_areas(table(rows), np.stack((X, -X)), 0.01)
        assert away[1 - big] == 0.0
        assert toward[1 - big] == pytest.approx(np.pi / 4 + 0.1, rel=2e-3)
        assert toward.sum() == pytest.approx(away[big], rel=2e-3)


def test_all_that_is_seen_is_the_union():
    rng = np.random.default_rng(3)
    rows = []
    for _ in range(60):
        start = rng.normal(size=3)
        rows.append((start, start + 0.5 * rng.normal(size=3), *rng.uniform(0.05, 0.3, 2)))
    many, spread = table(rows), directions(9)
    seen = visible_areas(many, spread, 0.01).sum(axis=1)
    assert seen == pytest.approx(areas_of_parts(many, spread, 100.0)[0], rel=5e-3)
