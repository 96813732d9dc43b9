"""Lines through an endless stand meet what stands there, and as often as chance has it."""

import numpy as np
import pytest

from lod.shapes import StickTable
from scenes.appearance.ray_grid import NOTHING, intersect_ray, make_grids, normal_at
from scenes.ground.stand import intersect_layers, intersect_stand, stand_field
from scenes.noise import lattice_bits, unit_float

SEED = np.uint64(0x57A4D)


def ball(z=3.0, r=1.0):
    centre, radius = np.array(((0.0, 0.0, z),)), np.array((r,))
    beside = centre + np.array((1e-3, 0.0, 0.0))
    return StickTable(np.array((0, 1)), centre, beside, radius, radius, np.zeros(1, np.int64))


def tangle(seed, n=40):
    """Sticks about an axis."""
    rng = np.random.default_rng(seed)
    start = np.column_stack((rng.normal(size=(n, 2)), 2 + rng.random(n) * 3))
    end = start + rng.normal(size=(n, 3)) * 0.5
    radii = rng.uniform(0.02, 0.3, (2, n))
    return StickTable(np.array((0, n)), start, end, *radii, np.zeros(n, np.int64))


def lines(stand, numbers, origin, v):
    n = len(numbers)
    far, row, normal = np.empty(n), np.empty(n, np.int64), np.empty((n, 3))
    for i in range(n):
        far[i], row[i], normal[i] = intersect_stand(stand, numbers[i], origin[i], v[i])
    return far, row, normal


def objects_near(stand, number, centre, reach=5):
    """(prototype, x, y, turn) of all that stands in the cells around a point, drawn anew."""
    found = []
    middle = np.floor(np.array(centre) / stand.cell).astype(int)
    key = np.uint64(lattice_bits(SEED, number, 0))
    for x in range(middle[0] - reach, middle[0] + reach + 1):
        for y in range(middle[1] - reach, middle[1] + reach + 1):
            bits = np.uint64(lattice_bits(key, x, y))
            u, n, term = unit_float(bits), 0, np.exp(-stand.mean)
            below = term
            while u >= below:
                n += 1
                term *= stand.mean / n
                below += term
            for k in range(n):
                ux, uy, which, turn = (
                    unit_float(np.uint64(lattice_bits(bits, k, j))) for j in range(4)
                )
                at = (x + ux) * stand.cell, (y + uy) * stand.cell
                found.append((int((stand.chance <= which).sum()), *at, 2 * np.pi * turn))
    return found


def first_of_one(grids, which, origin, way):
    """Distance to the first stick of one object along a ray, its row, and the normal there."""
    t, stick = intersect_ray(grids, which, tuple(origin), tuple(way), NOTHING)
    at = origin + t * way if stick >= 0 else origin
    return t, stick, normal_at(grids.shapes[stick], at, tuple(way)) if stick >= 0 else 0 * way


def test_every_line_meets_what_is_nearest_of_all_that_stands_around():
    """Of all objects, one by one, in frames of their own."""
    tables = [tangle(1), tangle(2), ball()]
    stand = stand_field(tables, np.array((0.02, 0.03, 0.02)))
    sizes = np.cumsum([0] + [len(t) for t in tables])
    rng = np.random.default_rng(3)
    n = 120
    v = np.column_stack((rng.normal(size=(n, 2)), -0.5 - rng.random(n)))
    v /= np.linalg.norm(v, axis=1)[:, None]
    origin = np.column_stack((rng.normal(size=(n, 2)) * 50, np.full(n, 7.0)))
    numbers = rng.integers(0, 1000, n)
    far, row, normal = lines(stand, numbers, origin, v)
    grids = make_grids(tables)
    for i in range(n):
        best, which, outward = NOTHING, -1, np.zeros(3)
        for k, x, y, turn in objects_near(stand, numbers[i], origin[i, :2] + 4 * v[i, :2]):
            spin = np.array(
                ((np.cos(turn), np.sin(turn), 0), (-np.sin(turn), np.cos(turn), 0), (0, 0, 1))
            )
            own = spin @ (origin[i] - (x, y, 0))
            t, stick, up = first_of_one(grids, k, own, spin @ v[i])
            if t < best:
                best, which, outward = t, stick, spin.T @ up
        assert far[i] == pytest.approx(best) and row[i] == which
        assert normal[i] == pytest.approx(outward, abs=1e-9)
    assert 0.2 < (row >= 0).mean() < 1
    assert set(np.searchsorted(sizes, row[row >= 0], side="right") - 1) == {0, 1, 2}


@pytest.mark.parametrize("elevation", [8.0, 30.0, 90.0])
def test_gaps_between_balls_are_as_frequent_as_poisson_has_them(elevation):
    """exp(−K·A/sin δ): cell by cell, many to a cell or few."""
    e, n = np.radians(elevation), 6000
    v = np.tile((-np.cos(e), 0.0, -np.sin(e)), (n, 1))
    origin = -v * 5.0 / np.sin(e)
    for density, cell in ((0.06, None), (0.06, 13.0), (0.015, 2.0)):
        stand = stand_field([ball()], np.array((density,)), cell)
        _, row, _ = lines(stand, np.arange(n), origin, v)
        gaps = np.exp(-density * np.pi / np.sin(e))
        sd = np.sqrt(gaps * (1 - gaps) / n)
        assert abs((row < 0).mean() - gaps) < 4 * sd


def test_layers_are_met_as_if_they_were_one_stand():
    """Large balls in a layer, small ones in another: gaps are a product, and the nearer is met."""
    n, e = 4000, np.radians(30.0)
    v = np.tile((-np.cos(e), 0.0, -np.sin(e)), (n, 1))
    origin = -v * 5.0 / np.sin(e)
    layers = tuple(stand_field([ball(r=r)], np.array((k,))) for r, k in ((1.0, 0.04), (0.2, 1.0)))
    met = [intersect_layers(layers, i, origin[i], v[i]) for i in range(n)]
    far, row = np.array([each[0] for each in met]), np.array([each[1] for each in met])
    gaps = np.exp(-(0.04 + 1.0 * 0.2**2) * np.pi / np.sin(e))
    assert abs((row < 0).mean() - gaps) < 4 * np.sqrt(gaps * (1 - gaps) / n)
    alone, first, _ = lines(layers[0], np.arange(n), origin, v)
    assert (far <= alone).all() and (far[row == 0] == alone[row == 0]).all()
    assert set(row.tolist()) == {-1, 0, 1} and (first[row == 0] == 0).all()
