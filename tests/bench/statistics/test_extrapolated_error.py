"""Noise is taken away where it falls as 1/√N; bounds are past the truth as often as they say."""

import numpy as np
import pytest

from bench.statistics.fits import noise_free, one_sided_mean
from lod.errors import InputError

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


@pytest.mark.parametrize("n", [3, 6])
def test_one_bound_is_past_the_mean_of_places_in_1_of_20_experiments(n):
    """As many places as presets have, whose errors scatter as the normal law says."""
    rng = np.random.Generator(np.random.Philox(n))
    tries = 4000
    made = [one_sided_mean(0.01 + 0.004 * rng.standard_normal(n)) for _ in range(tries)]
    scatter = 4 * (0.05 * 0.95 / tries) ** 0.5
    assert np.mean([each.high < 0.01 for each in made]) == pytest.approx(0.05, abs=scatter)
    assert np.mean([each.low > 0.01 for each in made]) == pytest.approx(0.05, abs=scatter)


def test_a_mean_of_one_value_has_no_bounds():
    with pytest.raises(InputError, match="two or more"):
        one_sided_mean(np.array([0.01]))
