"""Limit distances by hand, how they scale, and how they are clamped and kept."""

import gc
import weakref

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.hierarchy import Hierarchy
from lod.metric import METRICS, limit_distances

SIZES = st.floats(1e-3, 1e3)


BY_HAND = {
    "blake": 300.0,
    "bounded": 201.0,
    "solid_angle": 200.0,
    "depth": 300.0,
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
