"""Limit distances by hand, how they scale, and how they are clamped and kept."""

import gc
import weakref
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.hierarchy import Hierarchy
from lod.metric import METRICS, limit_distances, seen_by_contrast, within_reach
from lod.viewing import BlurWidths, ViewingConditions

SIZES = st.floats(1e-3, 1e3)


BY_HAND = {
    "blake": 300.0,
    "bounded": 201.0,
    "solid_angle": 200.0,
    "depth": 300.0,
    "contrast_weighted": 300.0,
    "full": np.inf,
}
"""Limit distances [m] of P = 2 m, R = 1 m at m = 0.01 rad."""


@pytest.mark.parametrize(("name", "limit"), [(name, BY_HAND[name]) for name in METRICS])
def test_limit_distance_by_hand(name, limit):
    D = METRICS[name].limit(np.array([2.0]), np.array([1.0]), 0.01)
    assert D == pytest.approx([limit])


@given(P=SIZES, R=SIZES, m=st.floats(1e-5, 0.5), scale=st.floats(0.1, 10))
def test_limits_scale_with_the_object(P, R, m, scale):
    for metric in METRICS.values():
        once = metric.limit(np.array([P]), np.array([R]), m)
        assert metric.limit(np.array([scale * P]), np.array([scale * R]), m) == pytest.approx(
            scale * once
        )


@given(P=SIZES, R=SIZES, m=st.floats(1e-5, 0.99))
def test_blake_keeps_most_and_solid_angle_least(P, R, m):
    P, R = np.array([P]), np.array([R])
    near, middle, far = (METRICS[k].limit(P, R, m) for k in ("solid_angle", "bounded", "blake"))
    assert near <= middle <= far


def chain_of_two():
    """A part that is larger than its whole."""
    return Hierarchy(
        parent=np.array([-1, 0]),
        level=np.array([0, 1]),
        position=np.array([[0.0, 0, 0], [3, 0, 0]]),
        P=np.array([1.0, 5.0]),
        R=np.array([1.0, 1.0]),
        B=np.array([9.0, 6.0]),
        separation=np.array([0.0, 3.0]),
    )


def test_by_contrast_a_limit_by_hand():
    """C = 1/4 of D = 300 m in clear air; at β = 1/(75 m) x·exp(x) = 1: Lambert's Ω = 0.5671."""
    assert seen_by_contrast(np.array([300.0]), 0.25, 0.0) == pytest.approx([75.0])
    assert seen_by_contrast(np.array([300.0]), 0.25, 1 / 75) == pytest.approx([75 * 0.56714329])


@given(
    D=st.lists(SIZES, min_size=1, max_size=9).map(np.array),
    contrast=st.floats(0.1, 1),
    beta=st.floats(1e-6, 10),
)
def test_by_contrast_the_limit_is_the_one_root_and_only_takes(D, contrast, beta):
    d = seen_by_contrast(D, contrast, beta)
    assert (0 < d).all() and (d <= contrast * D).all()
    assert contrast * np.exp(-beta * d) * D == pytest.approx(d)
    thicker, larger = (
        seen_by_contrast(D, contrast, 2 * beta),
        seen_by_contrast(2 * D, contrast, beta),
    )
    assert (thicker <= d).all() and (d < larger).all()


@pytest.mark.parametrize(("reach", "limits"), [(10.0, [10.0, 7.0]), (1e9, [20.0, 17.0])])
def test_nothing_is_displayed_beyond_a_reach_and_the_clamp_is_kept(reach, limits):
    metric = within_reach(METRICS["blake"], reach)
    assert limit_distances(chain_of_two(), metric, 0.1).tolist() == pytest.approx(limits)
    assert metric is within_reach(METRICS["blake"], reach)  # or limits would be kept for nothing


def test_by_contrast_air_is_that_of_the_view_and_the_clamp_is_kept():
    """A part of C = 1/2 in haze: its own limit is W(β·C·D)/β, and 3 m less than its whole's."""
    tree = replace(chain_of_two(), contrast_to_whole=np.array([1.0, 0.5]))
    metric = METRICS["contrast_weighted"]
    assert limit_distances(tree, metric, 0.1).tolist() == pytest.approx([20.0, 17.0])
    small = replace(tree, P=np.array([1.0, 0.5]))
    assert limit_distances(small, metric, 0.1).tolist() == pytest.approx([20.0, 7.5])
    hazy = ViewingConditions(BlurWidths(0.1), 0.1, acuity=False)
    own = seen_by_contrast(np.array([20.0, 15.0]), np.array([1.0, 0.5]), 0.1)
    found = limit_distances(small, metric, 0.1, hazy)
    assert found.tolist() == pytest.approx([own[0], min(own[1], own[0] - 3)])


def test_a_part_larger_than_its_whole_is_clamped_to_it():
    tree = chain_of_two()
    D = limit_distances(tree, METRICS["blake"], 0.1)
    assert D.tolist() == pytest.approx([20.0, 17.0])
    assert limit_distances(tree, METRICS["blake"], 1.0)[1] == 0.0


def test_limits_are_kept_for_as_long_as_their_hierarchy_lives():
    tree = chain_of_two()
    assert limit_distances(tree, METRICS["blake"], 0.1) is limit_distances(
        tree, METRICS["blake"], 0.1
    )
    gone = weakref.ref(tree)
    del tree
    gc.collect()
    assert gone() is None
