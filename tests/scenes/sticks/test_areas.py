"""Projected areas: analytic values, then properties, then unions against Monte Carlo.

The largest area that flat triangles cover: analytic values, and no direction covers more.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from lod.errors import InputError
from lod.shapes import Mesh, MeshTable, StickTable
from scenes.ground.stand import full_detail_sticks
from scenes.models.catalogue import model_prototypes
from scenes.sticks.areas import (
    MOST_TRIANGLES,
    areas_of_parts,
    directions,
    largest_area,
    largest_flat_areas,
    largest_outline_areas,
    mean_area,
    mean_outline_areas,
    outline_area,
)

Z = np.array((0.0, 0.0, 1.0))
X = np.array((1.0, 0.0, 0.0))

radius = st.floats(0.02, 2.0)
coordinate = st.floats(-3.0, 3.0)
points = st.tuples(coordinate, coordinate, coordinate)
sticks = st.lists(st.tuples(points, points, radius, radius), min_size=1, max_size=8)
plump = st.floats(0.2, 2.0)
plump_sticks = st.lists(st.tuples(points, points, plump, plump), min_size=1, max_size=8)


def table(rows, parts=1, owner=None):
    start, end, r0, r1 = (np.array(column, float) for column in zip(*rows, strict=True))
    owner = np.zeros(len(rows), np.int64) if owner is None else owner
    return StickTable.of(parts, owner, start, end, r0, r1, np.zeros(len(rows), np.int64))


def one(r0, r1, length):
    return table([((0, 0, 0), (0, 0, length), r0, r1)])


def outline_areas_along(t, direction):
    """Area of each stick's outline along a unit vector."""
    apart = np.linalg.norm(np.cross(t.end - t.start, direction), axis=1)
    return outline_area(t.start_radius, t.end_radius, apart)


def inside(t, across, up, uv):
    """Which points of the picture plane lie in an outline: the nearest disc on the axis holds them.

    With x along and y off the axis, |p − c(s)| − r(s) is convex in s and least at
    s = x + k·|y|/√(1 − k²), k = (r₁ − r₀)/l; beyond the ends, at an end.
    """
    hit = np.zeros(len(uv), bool)
    plane = np.stack((across, up), axis=1)
    for a, b, r0, r1 in zip(t.start, t.end, t.start_radius, t.end_radius, strict=True):
        offset, axis = uv - a @ plane, (b - a) @ plane
        length = max(np.linalg.norm(axis), 1e-12)
        x = offset @ axis / length
        y = np.sqrt(np.maximum((offset**2).sum(axis=1) - x * x, 0))
        k = (r1 - r0) / length
        best = x + k * y / np.sqrt(1 - k * k) if abs(k) < 1 else np.full(len(x), np.inf * k)
        s = np.clip(best, 0, length)
        hit |= np.hypot(x - s, y) <= r0 + k * s
    return hit


def monte_carlo_area(t, direction, rng, n=60_000):
    turn = np.linalg.qr(np.column_stack((direction, rng.normal(size=(3, 2)))))[0]
    across, up = turn[:, 1], turn[:, 2]
    plane = np.stack((across, up), axis=1)
    ends = np.concatenate((t.start @ plane, t.end @ plane))
    r = np.concatenate((t.start_radius, t.end_radius))[:, None]
    low, high = (ends - r).min(axis=0), (ends + r).max(axis=0)
    # One point in each cell of a fine grid: stratified, so the error is a tenth of plain sampling.
    side = int(np.sqrt(n))
    cell = np.stack(np.meshgrid(np.arange(side), np.arange(side)), axis=-1).reshape(-1, 2)
    uv = low + (cell + rng.random(cell.shape)) / side * (high - low)
    return inside(t, across, up, uv).mean() * np.prod(high - low)


class TestAnalyticValues:
    def test_sphere(self):
        t = one(0.5, 0.5, 0.0)
        assert largest_area(t)[0] == pytest.approx(np.pi / 4)
        assert mean_area(t)[0] == pytest.approx(np.pi / 4)

    def test_cone_to_a_point(self):
        """Discs of radius 1 and almost 0, 2 apart: two thirds of a disc, two triangles of 1·√3."""
        area = 4 * np.pi / 3 / 2 + np.sqrt(3)
        assert outline_area(*map(np.atleast_1d, (1.0, 1e-9, 2.0)))[0] == pytest.approx(area)

    def test_part_without_sticks(self):
        t = table([((0, 0, 0), (1, 0, 0), 0.1, 0.1)], parts=3, owner=np.array([1]))
        assert largest_area(t)[[0, 2]].tolist() == [0, 0]
        assert mean_area(t)[1] > 0


class TestClosedForms:
    @given(radius, radius, st.floats(0.0, 5.0))
    def test_outline_is_the_convex_hull_of_two_discs(self, r0, r1, apart):
        turn = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
        circle = np.stack((np.cos(turn), np.sin(turn)), axis=1)
        hull = ConvexHull(np.concatenate((r0 * circle, r1 * circle + (apart, 0)))).volume
        assert outline_area(*map(np.atleast_1d, (r0, r1, apart)))[0] == pytest.approx(
            hull, rel=1e-5
        )

    @given(radius, radius, st.floats(0.0, 5.0))
    def test_mean_is_the_average_over_directions(self, r0, r1, length):
        t, spread = one(r0, r1, length), directions(400)
        average = np.mean([outline_areas_along(t, d)[0] for d in spread])
        assert mean_outline_areas(t)[0] == pytest.approx(average, rel=1e-3)

    @given(points, points, radius, radius)
    def test_largest_is_never_exceeded_and_is_reached(self, a, b, r0, r1):
        t = table([(a, b, r0, r1)])
        areas = [outline_areas_along(t, d)[0] for d in directions(200)]
        assert max(areas) <= largest_outline_areas(t)[0] * (1 + 1e-12)
        axis = np.subtract(b, a)
        across = np.cross(axis, X if abs(axis[0]) < abs(axis[2]) else Z)
        if np.linalg.norm(across) > 1e-6:
            seen = outline_areas_along(t, across / np.linalg.norm(across))[0]
            assert seen == pytest.approx(largest_outline_areas(t)[0], rel=1e-9)


class TestUnions:
    @given(points, points, radius, radius)
    def test_one_stick_agrees_with_the_closed_form(self, a, b, r0, r1):
        t, spread = table([(a, b, r0, r1)]), directions(32)
        raster = areas_of_parts(t, spread)[0]
        exact = np.array([outline_areas_along(t, d)[0] for d in spread])
        assert raster == pytest.approx(exact, rel=0.025)  # a rod almost along the rows is the worst
        assert raster.mean() == pytest.approx(exact.mean(), rel=0.005)

    @given(plump_sticks, st.integers(0, 63), st.integers(0, 2**32 - 1))
    def test_union_agrees_with_monte_carlo(self, rows, number, seed):
        """In one direction, where the raster is within 2.5 % (see above) and chance adds to it."""
        t, d = table(rows), directions()[number]
        area = areas_of_parts(t, d[None])[0, 0]
        assert area == pytest.approx(monte_carlo_area(t, d, np.random.default_rng(seed)), rel=0.025)

    @given(sticks, st.floats(0.01, 100.0))
    def test_areas_grow_as_the_square_of_the_scale(self, rows, factor):
        t = table(rows)
        for area in (largest_area, mean_area):
            assert area(t.scaled(factor)) == pytest.approx(area(t) * factor**2, rel=0.005)


def test_directions_are_spread_over_the_half_sphere():
    spread = directions()
    assert np.linalg.norm(spread, axis=1) == pytest.approx(1)
    # An even half sphere has moments ⟨d dᵀ⟩ = 1/3.
    assert spread.T @ spread / len(spread) == pytest.approx(np.eye(3) / 3, abs=0.01)
    anywhere = np.random.default_rng(0).normal(size=(5000, 3))
    anywhere /= np.linalg.norm(anywhere, axis=1, keepdims=True)
    nearest = np.degrees(np.arccos(np.abs(anywhere @ spread.T).max(axis=1)))
    assert nearest.max() < 16
    assert nearest.mean() < 8


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


def test_outlines_of_mirrored_limbs_are_finite():
    """Rows meet both ears of a rabbit at once, and at one size only just."""
    outlines = []
    for rabbit, top in zip(
        model_prototypes("rabbit", 1, (1.0, 1.2), True), (0.3572, 0.42864), strict=True
    ):
        table = full_detail_sticks(rabbit)[0]
        middle = (table.start[:, 2] + table.end[:, 2]) / 2
        below = [table.take(middle < top * (k / 6) ** 2) for k in range(1, 7)]
        outlines.append([areas_of_parts(each, np.eye(3)[:2])[0].mean() for each in below])
    assert np.allclose(outlines[1], 1.44 * np.array(outlines[0]), rtol=0.2, atol=2e-3)
