"""Fields are counted as their cases say, and predicted without the pruner (§4.1)."""

from dataclasses import asdict, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

import lod.metric
import lod.view
from bench.counting import (
    COLUMNS,
    EYE_HEIGHT_M,
    Case,
    cleared,
    count_field,
    disc_in_square,
    field_seed,
    pierced,
    predict,
    prototypes_of,
    shown_areas,
)
from lod.law import chained_limits
from lod.metric import METRICS
from lod.shapes import Sticks

SMALL = Case("density", "figure", "blake", density=0.01, detail=20.0)
# The predictions


def test_objects_are_those_of_the_closed_form():
    trees = [each.hierarchy for each in prototypes_of("figure", 2.0)]
    case = replace(SMALL, size=2.0)
    by_hand = [
        np.pi * 0.01 * (((t.P[0] + t.R[0]) / case.m) ** 2 - (EYE_HEIGHT_M - t.position[0, 2]) ** 2)
        for t in trees
    ]
    assert predict(case).objects == pytest.approx(np.mean(by_hand), rel=1e-12)


@pytest.mark.parametrize("extent", [None, 30.0])
def test_the_noise_of_parts_is_that_of_pairs(extent):
    case = replace(SMALL, extent=extent)
    total = 0.0
    for prototype in prototypes_of("figure", 1.0):
        tree = prototype.hierarchy
        h = EYE_HEIGHT_M - tree.position[:, 2]
        areas = shown_areas(chained_limits(tree, METRICS["blake"], case.m), h, extent)
        total += 0.01 / 4 * np.minimum(areas[:, None], areas[None, :]).sum()
    assert predict(case).parts_variance == pytest.approx(total, rel=1e-12)


def test_predictions_owe_nothing_to_the_pruner(monkeypatch):
    def broken(*_):
        raise AssertionError("the pruner's limits were asked for")

    monkeypatch.setattr(lod.metric, "limit_distances", broken)
    monkeypatch.setattr(lod.view, "limit_distances", broken)
    assert predict(SMALL).parts > predict(SMALL).objects > 0


@given(st.floats(0.0, 3.0), st.floats(0.2, 3.0))
def test_disc_in_square(radius, side):
    area = disc_in_square(np.array([radius]), side)[0]
    width = min(radius, side / 2) / 4000
    x = (np.arange(4000) + 0.5) * width  # one quarter, column by column
    height = np.minimum(np.sqrt(np.maximum(radius**2 - x**2, 0.0)), side / 2)
    assert area == pytest.approx(4 * width * height.sum(), rel=1e-4, abs=1e-9)


def test_a_clearing_is_the_integral_of_its_density():
    for radius in (30.0, 100.0, 700.0):
        wanted = quad(lambda r: min(1, r / 100) * 2 * np.pi * r, 0, radius, points=[100.0])[0]
        assert cleared(np.array([np.pi * radius**2]), 100.0)[0] == pytest.approx(wanted, rel=1e-6)


# Counting


def counts(case, fields, seed=1):
    rows = [count_field(case, field_seed(asdict(case), seed, k)) for k in range(fields)]
    return dict(zip(COLUMNS, np.array(rows, np.float64).T, strict=True))


def test_patches_are_clumped_as_the_law_says():
    case = Case("patches", "figure", "blake", 3.6e-3, detail=10.0, gathered="patches", scale=20.0)
    law, even = predict(case), predict(replace(case, gathered="evenly"))
    assert law.objects == even.objects and law.objects_variance > 4 * even.objects_variance
    assert 0.7 < counts(case, 120)["objects"].var(ddof=1) / law.objects_variance < 1.4


# Rays


NORTH = np.array([[0.0, 1.0, 0.0]])


def sticks(*rows):
    """Each a start, an end and two radii."""
    start, end, r0, r1 = (np.array(each, float) for each in zip(*rows, strict=True))
    zero = np.zeros(len(rows), np.int64)
    return Sticks(start, end, r0, r1, zero, np.ones((1, 3)), zero)


@pytest.mark.parametrize(
    ("start", "end", "radii", "wanted"),
    [
        ((-1, 9, 0), (1, 9, 0), (0.1, 0.1), 1),
        ((-1, 9, 0.25), (1, 9, 0.25), (0.2, 0.2), 0),
        ((-1, 9, 0.25), (1, 9, 0.25), (0.2, 0.4), 1),  # 0.3 wide in the middle
        ((0.5, 9, 0), (2, 9, 0), (0.4, 0.6), 0),
        ((0.5, 9, 0), (2, 9, 0), (0.6, 0.4), 1),
        ((0.1, 5, 0), (0.1, 9, 0), (0.2, 0.2), 1),  # along the ray, once
        ((0, 5, 0), (0, 5, 0), (0.2, 0.2), 1),  # a sphere
        ((0, -9, 0), (0, -8, 0), (0.2, 0.2), 0),  # behind
    ],
)
def test_a_stick_is_pierced_where_it_is_wide_enough(start, end, radii, wanted):
    assert pierced(sticks((start, end, *radii)), np.zeros(3), NORTH).tolist() == [wanted]
