"""Exponents are found with honest errors. Noise is taken away where it falls as 1/√N."""

import numpy as np
import pytest

from bench.statistics.estimates import fit_exponent, noise_free
from lod.errors import InputError

X = np.geomspace(1.0, 1000.0, 24)


def test_exponents_are_covered_though_the_scatter_grows():
    """Scatter ten times as large at one end: 93 to 98 of 100 intervals hold the truth."""
    rng, hits = np.random.default_rng(5), 0
    for _ in range(600):
        y = X**-0.7 * np.exp(rng.normal(0, np.geomspace(0.02, 0.2, len(X))))
        found = fit_exponent(X, y)
        hits += found.low <= -0.7 <= found.high
    assert 0.93 <= hits / 600 <= 0.985


@pytest.mark.parametrize("y", [np.zeros(24), np.full(24, np.nan)])
def test_what_has_no_logarithm_is_refused(y):
    with pytest.raises(InputError):
        fit_exponent(X, y)


COUNTS = np.array([16.0, 64.0, 256.0])


def test_a_is_recovered_from_errors_that_follow_the_fit():
    a, b = np.array([0.0, 0.003, 0.08]), np.array([0.2, 0.05, 0.0])
    errors = a + b / np.sqrt(COUNTS)[:, None]
    assert noise_free(COUNTS, errors) == pytest.approx(a, abs=1e-12)


def test_a_is_unbiased_where_errors_are_measured_with_scatter():
    rng = np.random.Generator(np.random.Philox(1))
    truth = 0.01 + 0.1 / np.sqrt(COUNTS)[:, None]
    found = noise_free(COUNTS, truth + 0.002 * rng.standard_normal((3, 20_000)))
    assert found.mean() == pytest.approx(0.01, abs=4 * found.std() / 20_000**0.5)
    assert found.std() > 0.001, "one column says less than many"


@pytest.mark.parametrize("counts", [[64.0], [64.0, 64.0], [0.0, 16.0]])
def test_too_few_counts_are_refused(counts):
    with pytest.raises(InputError, match="samples"):
        noise_free(np.array(counts), np.zeros((len(counts), 1)))
