"""Fading: what parts no longer cover, their wholes do; nothing appears or vanishes at once.

A thinned stick covers its share of itself; leaf appearances stand for what is hidden.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import (
    Cut,
    Parts,
    blend_weights,
    cut_from_parts,
    fade_factors,
    leaf_area_share,
    radius_factor,
)
from lod.shapes import Sticks, StickTable
from lod.view import View
from scenes.sticks.areas import mean_outline_areas

CAMERA = camera_from_heading(Corner(0, 0), np.zeros(3), 0.0, 0.0, 60.0, (64, 36))


def view(fade: float) -> View:
    return View(CAMERA, METRICS["blake"], fade=fade)


def cut(whole, share, distance, limit=100.0, ahead=1.0) -> Cut:
    """Parts straight ahead at these distances."""
    n, whole, share = len(whole), np.array(whole), np.array(share)
    position = np.outer(np.broadcast_to(distance, n), (0.0, ahead, 0.0))
    limit = np.broadcast_to(limit, n)
    row = np.arange(n)
    parts = Parts(position, position, np.zeros(n), limit, limit / 4, row, row, row, whole, share)
    return cut_from_parts(parts, n, n)


def random_cut(seed: int) -> Cut:
    """Trees of up to 40 parts, some of whose parts are not displayed."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(1, 40))
    whole = np.array([-1 if i == 0 else int(rng.integers(-1, i)) for i in range(n)])
    siblings = np.bincount(whole[whole >= 0], minlength=n)
    hidden = rng.integers(0, 2, n)
    parts = np.maximum(siblings + hidden, 1)
    share = np.where(whole < 0, 1.0, 1.0 / parts[whole])
    return cut(whole, share, rng.uniform(0, 99.9, n))


# Without fading


@given(seed=st.integers(0, 2**32))
def test_without_fading_areas_add_up(seed):
    some = random_cut(seed)
    seen, whole = blend_weights(some, view(0.0)), some.parts.parent
    covered = np.bincount(whole[whole >= 0], some.parts.share[whole >= 0], len(whole))
    assert seen.leaf + covered == pytest.approx(np.ones(len(whole)), abs=1e-8)
    assert np.array_equal(seen.inner > 0, np.isin(np.arange(len(whole)), whole))


# The band


def test_of_what_fades_with_its_whole_as_much_is_hidden_as_by_itself():
    seen = blend_weights(cut([-1, 0], [1.0, 0.5], [90.0, 1.0]), view(0.2))
    assert seen.hidden_area == pytest.approx([0.5, 1])
    assert seen.leaf == pytest.approx([0.25, 0.5])
    taken = seen.take(np.array([1]))
    assert len(taken) == 1
    assert (taken.inner, taken.leaf, taken.hidden_area) == (seen.inner[1], seen.leaf[1], 1)


@pytest.mark.parametrize(("d", "share"), [(0, 1), (79.9, 1), (80, 1), (90, 0.5), (99.9, 0.005)])
def test_a_part_shrinks_over_the_band_before_its_limit(d, share):
    assert fade_factors(cut([-1], [1.0], d), view(0.2)) == pytest.approx([share])


def test_out_of_view_the_band_is_before_the_coarser_limit():
    behind = cut([-1], [1.0], 22.5, ahead=-1.0)
    assert fade_factors(behind, view(0.2)) == pytest.approx([0.5])


def beside(turn, ahead=30.0, bound=1.0, limit=100.0, rise=0.0):
    """One part, its sphere at an angle from the axis, to the right and up [rad]."""
    at = ahead * np.array([(np.sin(turn), np.cos(turn), rise)])
    row, one = np.zeros(1, int), np.ones(1)
    limits = limit * one, limit * one / 4
    parts = Parts(at, at, bound * one, *limits, row, row, row, row - 1, one)
    return cut_from_parts(parts, 1, 1)


def shown(turn, **where):
    return float(fade_factors(beside(turn, **where), view(0.2))[0])


EDGE, ASIDE = np.radians(30.0), np.arcsin(1 / 30)  # a sphere of 1 m at 30 m touches it so far off


def test_what_comes_into_view_grows_till_a_quarter_of_its_sphere_is():
    assert shown(EDGE) == 1.0
    quarter = np.arcsin(0.75 / 30)  # a sphere of 1 m whose centre is 0.75 m out of view
    assert shown(EDGE + quarter) == pytest.approx(0.5)
    assert shown(EDGE + 0.9999 * ASIDE) == pytest.approx(0.0, abs=1e-3)
    assert shown(0.0, rise=1.1 * CAMERA.tan_half[1]) < 1 == shown(0.0, rise=CAMERA.tan_half[1])
    turns = np.linspace(0, 2 * EDGE, 4000)
    shares = np.array([shown(turn) for turn in turns])
    assert np.abs(np.diff(shares)).max() < 4.04 * (turns[1] - turns[0]) / (2 * ASIDE)


def test_what_is_displayed_out_of_view_too_does_not_shrink_at_its_edge():
    turns = np.linspace(0, np.pi, 500)
    assert all(shown(turn, ahead=19.9) == 1.0 for turn in turns)
    assert min(shown(turn, ahead=22.5) for turn in turns) == pytest.approx(0.5, abs=0.02)


def test_what_hangs_on_a_fading_part_fades_with_it():
    seen = blend_weights(cut([-1, 0, 1], [1.0, 1.0, 1.0], [90.0, 85.0, 90.0]), view(0.2))
    assert seen.inner == pytest.approx([0.5, 0.5 * 0.75, 0])
    assert seen.leaf == pytest.approx([0.5 * 0.25, 0.5 * 0.75 * 0.5, 0.5 * 0.75 * 0.5])


@given(seed=st.integers(0, 2**32), fade=st.floats(0.01, 0.99))
def test_looks_never_jump(seed, fade):
    """A step of a millimetre changes no look by more than its share of the band."""
    some = random_cut(seed)
    parts = some.parts
    moved = cut(parts.parent, parts.share, parts.position[:, 1] + 1e-3)
    a, b = blend_weights(some, view(fade)), blend_weights(moved, view(fade))
    deepest = 40
    step = deepest * 5 * 1e-3 / (fade * 100)
    assert np.abs(a.inner - b.inner).max() <= step
    assert np.abs(a.leaf - b.leaf).max() <= step
    for shares in (a.inner, a.leaf):
        assert shares.min() >= 0 and shares.max() <= 1


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


# What a leaf appearance shows for the parts that are hidden

OVERLAPS = st.floats(-3, 0.95)


@given(hidden=st.floats(0, 1), overlap=OVERLAPS)
def test_with_what_is_displayed_it_covers_as_much_as_either_alone(hidden, overlap):
    """Less what of them lies in one another."""
    share, others = leaf_area_share(hidden, overlap), 1 - hidden
    assert share + others - overlap * share * others == pytest.approx(1)


@given(hidden=st.floats(0, 1), more=st.floats(0, 1), overlap=OVERLAPS)
def test_the_more_is_hidden_the_more_it_shows(hidden, more, overlap):
    assert leaf_area_share(hidden, overlap) <= leaf_area_share(max(hidden, more), overlap) + 1e-12
