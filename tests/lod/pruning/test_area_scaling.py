"""A thinned stick covers its share of itself; leaf appearances stand for what is hidden."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.pruning.area_scaling import leaf_area_share, radius_factor
from lod.pruning.shapes import Sticks
from lod.stick_table import StickTable
from scenes.sticks.outline_area import mean_outline_areas


def stick(r0: float, r1: float, length: float) -> Sticks:
    start, end = np.zeros((1, 3)), np.array([[0.6 * length, 0.0, 0.8 * length]])
    zero = np.zeros(1)
    return Sticks(start, end, zero + r0, zero + r1, zero, np.full((1, 3), 0.5), zero)


def thinned(s: Sticks, share: float) -> Sticks:
    length = float(np.linalg.norm(s.end - s.start))
    factor = radius_factor(s.start_radius[0], s.end_radius[0], length, share)
    radii = s.start_radius * factor, s.end_radius * factor
    return Sticks(s.start, s.end, *radii, s.tint, s.tints, s.owner)


def mean_outline(s: Sticks) -> float:
    columns = s.start, s.end, s.start_radius, s.end_radius, s.tint
    return float(mean_outline_areas(StickTable(np.array((0, len(s))), *columns))[0])


@given(r=st.floats(1e-3, 10), length=st.floats(0, 100), share=st.floats(1e-3, 1))
def test_an_even_stick_keeps_exactly_its_share_of_the_mean_outline(r, length, share):
    whole = stick(r, r, length)
    assert mean_outline(thinned(whole, share)) == pytest.approx(
        share * mean_outline(whole), rel=1e-9
    )


@pytest.mark.parametrize("taper", [0.5, 0.8])
@pytest.mark.parametrize("length", [2.5, 5.0, 30.0])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_a_tapering_stick_nearly_so(taper, length, share):
    whole = stick(1.0, taper, length)
    assert mean_outline(thinned(whole, share)) == pytest.approx(
        share * mean_outline(whole), rel=0.03
    )


def test_long_sticks_thin_by_the_share_and_blobs_by_its_root():
    thin = thinned(stick(1.0, 0.9, 1e6), 0.25)
    assert thin.start_radius[0] == pytest.approx(0.25, rel=1e-4)
    assert thin.end_radius[0] == pytest.approx(0.9 * 0.25, rel=1e-4)
    assert thinned(stick(1.0, 1.0, 0.0), 0.25).start_radius[0] == pytest.approx(0.5)


# What a leaf appearance shows for the parts that are hidden

OVERLAPS = st.floats(-3, 0.95)


@given(overlap=OVERLAPS)
def test_it_stands_for_all_and_for_none_whole(overlap):
    assert leaf_area_share(0.0, overlap) == 0
    assert leaf_area_share(1.0, overlap) == 1


@given(hidden=st.floats(0, 1), overlap=OVERLAPS)
def test_with_what_is_displayed_it_covers_as_much_as_either_alone(hidden, overlap):
    """Less what of them lies in one another."""
    share, others = leaf_area_share(hidden, overlap), 1 - hidden
    assert share + others - overlap * share * others == pytest.approx(1)


@given(hidden=st.floats(0, 1), more=st.floats(0, 1), overlap=OVERLAPS)
def test_the_more_is_hidden_the_more_it_shows(hidden, more, overlap):
    assert leaf_area_share(hidden, overlap) <= leaf_area_share(max(hidden, more), overlap) + 1e-12


def test_without_overlap_areas_add_up():
    assert [leaf_area_share(h, 0.0) for h in (0.2, 0.5, 0.9)] == [0.2, 0.5, 0.9]
