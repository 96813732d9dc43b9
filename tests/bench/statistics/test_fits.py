"""Power law or logarithm: what made the rows is found, with honest errors.

Noise is taken away where it falls as 1/√N; bounds are past the truth as often as they say.
"""

import numpy as np
import pytest

from bench.statistics.fits import EVEN, compare_with_log, fit_exponent, noise_free
from lod.errors import InputError

X = np.geomspace(1.0, 1000.0, 24)


def rows(seed, power, noise=0.05):
    rng = np.random.default_rng(seed)
    y = 3 * X**0.5 if power else 2 + 5 * np.log(X)
    return X, y * np.exp(rng.normal(0, noise, len(X)))


@pytest.mark.parametrize("power", [True, False])
def test_what_made_the_rows_wins(power):
    won = [(compare_with_log(*rows(seed, power)).aic_gained > 0) == power for seed in range(40)]
    assert sum(won) >= 39


def test_the_better_line_is_drawn_and_said():
    found = compare_with_log(*rows(1, True, 0.01))
    assert found.power == pytest.approx((3, 0.5), rel=0.05)
    assert found.line(X) == pytest.approx(3 * X**0.5, rel=0.05)
    assert found.words.startswith("a power law describes it better than a + b·log x, by")
    other = compare_with_log(*rows(1, False, 0.01))
    assert other.line(X) == pytest.approx(2 + 5 * np.log(X), rel=0.05)
    assert other.words.startswith("a + b·log x describes it better")


def test_rows_that_tell_nothing_are_even():
    """Nothing grows: neither does better than by the difference that says nothing."""
    even = [
        abs(compare_with_log(X, np.exp(np.random.default_rng(s).normal(0, 0.01, 24))).aic_gained)
        < EVEN
        for s in range(40)
    ]
    assert sum(even) >= 38
    flat = compare_with_log(X, np.exp(np.random.default_rng(0).normal(0, 0.01, 24)))
    assert "equally well" in flat.words


def test_aic_does_not_depend_on_units():
    x, y = rows(3, True)
    assert compare_with_log(x, y).aic_gained == pytest.approx(
        compare_with_log(x, 1e6 * y).aic_gained, abs=1e-6
    )


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
        compare_with_log(X, y)
    with pytest.raises(InputError, match="4 rows"):
        compare_with_log(X[:3], X[:3])


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
