"""Variance of counts from the pair correlation, against closed forms and brute force."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.pair_correlation import CountSpread, count_spread, mapped, matern, poisson, thomas

DISC = [np.array([math.pi * 50.0**2])]


def test_a_poisson_field_has_the_variance_of_the_law():
    areas = [np.array([100.0, 40.0, 40.0, 0.0]), np.array([7.0])]
    found = count_spread(0.1, areas, poisson)
    assert found.mean == pytest.approx(0.05 * (180 + 7))
    assert found.variance == pytest.approx(0.05 * (100 + 3 * 40 + 5 * 40 + 7), rel=1e-12)


@given(K=st.floats(1e-3, 1.0), parents=st.floats(1e-4, 1e-2), sigma=st.floats(1.0, 4.0))
def test_clusters_that_are_small_beside_the_disc_come_whole(K, parents, sigma):
    """N is compound Poisson: var N = mean·(1 + K/κ), but for clusters on the rim (Thomas 1949)."""
    found = count_spread(K, DISC, lambda r: thomas(r, parents, sigma))
    whole = found.mean * (1 + K / parents)
    rim = 2 * sigma / 50
    assert whole * (1 - 1.5 * rim) - found.mean < found.variance <= whole * (1 + 1e-3)


def test_wide_clusters_follow_the_closed_form_of_the_spectrum():
    """Var − mean = K²/κ ∫ |2πa·J₁(ka)/k|² exp(−k²σ²) k dk/2π, the disc's transform."""
    from scipy.integrate import quad
    from scipy.special import j1

    K, parents, sigma, a = 0.01, 1e-3, 20.0, 50.0
    spectrum = quad(
        lambda k: (2 * np.pi * a * j1(k * a) / k) ** 2 * np.exp(-((k * sigma) ** 2)) * k,
        1e-9,
        0.5,
        limit=400,
    )[0]
    found = count_spread(K, DISC, lambda r: thomas(r, parents, sigma))
    assert found.variance - found.mean == pytest.approx(
        K**2 / parents * spectrum / (2 * np.pi), rel=1e-4
    )


@given(candidates=st.floats(1e-3, 1.0), core=st.floats(0.2, 5.0))
def test_matern_has_no_pairs_within_the_core_and_poisson_pairs_beyond_two(candidates, core):
    g = matern(np.array([0.99, 1.01, 2.0, 3.0]) * core, candidates, core)
    assert g[0] == 0 and g[1] > 1 - 1e-9
    assert g[2:] == pytest.approx([1, 1], rel=1e-6)


def test_a_map_predicts_the_variance_over_its_own_places():
    """Discs about random places of a torus, which brute force counts."""
    rng = np.random.default_rng(3)
    period = (60.0, 40.0)
    middles = rng.random((8, 2)) * period
    xy = np.mod(np.repeat(middles, 6, axis=0) + rng.normal(0, 2, (48, 2)), period)
    g = mapped(xy, period, 60.0, step=0.1)
    found = count_spread(48 / 2400, [np.array([np.pi * 81.0])], g)
    eyes = rng.random((40_000, 2)) * period
    apart = np.abs(eyes[:, None] - xy)
    apart = np.minimum(apart, np.array(period) - apart)
    counts = (np.square(apart).sum(axis=2) < 81.0).sum(axis=1)
    assert found.mean == pytest.approx(counts.mean(), rel=0.02)
    assert found.variance == pytest.approx(counts.var(), rel=0.03)


def test_the_quantile_is_that_of_a_gamma_variable():
    """With shape 1 it is exponential."""
    assert CountSpread(3.0, 9.0).quantile(0.99) == pytest.approx(-3 * math.log(0.01))
