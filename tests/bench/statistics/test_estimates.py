"""Intervals are honest: on synthetic data with the field's own noise they cover at their rate."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from bench.statistics.estimates import (
    StoppingRule,
    fields_needed,
    holm,
    one_sided_mean,
    sample,
    standard_error,
    two_sided_ratio,
    two_sided_ratio_of_means,
    two_sided_slope,
)
from lod.errors import InputError


@dataclass(frozen=True)
class Kind:
    """Objects whose parts are displayed within these distances, in units of the whole's own."""

    limits: np.ndarray

    @property
    def rings(self) -> tuple[np.ndarray, np.ndarray]:
        """Share of the disc's area in each ring, and how many parts an object there displays."""
        edges, count = np.unique(-self.limits, return_counts=True)
        area = np.diff(np.append(-edges, 0.0) ** 2) * -1
        return area, np.cumsum(count)

    def moments(self) -> tuple[float, float]:
        """Parts per object displayed, and its dispersion."""
        area, parts = self.rings
        return float(area @ parts), float(area @ parts**2 / (area @ parts))

    def draw(self, chance, mean: float, fields: int) -> tuple[np.ndarray, np.ndarray]:
        """Objects and parts displayed in each of so many fields of ``mean`` objects."""
        area, parts = self.rings
        count = chance.poisson(mean * area, (fields, len(area)))
        return count.sum(1), count @ parts

    def sampled(self, chance, mean: float, effort: StoppingRule) -> list[tuple[int, ...]]:
        """As many fields as the experiment would take, by its own rule."""
        per_object, dispersion = self.moments()
        variance = dispersion * per_object * mean
        pairs = (mean, mean), (per_object * mean, variance)
        needed = max(fields_needed(*pair, effort.target) for pair in pairs)
        drawn: list[tuple[int, ...]] = []

        def field(index: int) -> tuple[int, ...]:
            if index >= len(drawn):
                columns = self.draw(chance, mean, needed + 16)
                drawn.extend(zip(*(column.tolist() for column in columns), strict=True))
            return drawn[index]

        return sample(field, needed, 2, effort)


TREE = Kind(np.repeat([1.0, 0.5, 0.3, 0.17, 0.09, 0.06], [1, 8, 40, 200, 900, 900]))
SHRUB = Kind(np.repeat([1.0, 0.6, 0.4, 0.25, 0.1], [1, 8, 20, 22, 26]))
FIGURE = Kind(np.repeat([1.0, 0.6, 0.3, 0.1], [1, 9, 15, 40]))
BUSH = Kind(np.repeat([1.0, 0.4], [1, 10]))


def sweep(chance, kinds, means, target):
    """One synthetic data set, sampled as the experiment does: objects, parts, means, φ."""
    rows = []
    for kind, mean in zip(kinds, means, strict=True):
        per_object, dispersion = kind.moments()
        drawn = kind.sampled(chance, mean, StoppingRule(target, 4, 20_000))
        rows += [(o, p, mean, per_object * mean, dispersion) for o, p in drawn]
    return (np.array(column, np.float64) for column in zip(*rows, strict=True))


def coverage(draws: int, seed: int, *case) -> dict[str, float]:
    """How often each 95 % interval holds the truth, which is 1 for all of them."""
    chance = np.random.default_rng(seed)
    hits = {}
    for _ in range(draws):
        objects, parts, mean, parts_mean, dispersion = sweep(chance, *case)
        found = {
            "objects slope": two_sided_slope(objects, mean),
            "parts slope": two_sided_slope(parts, parts_mean, dispersion),
            "objects ratio": two_sided_ratio(objects, mean),
            "parts ratio": two_sided_ratio(parts, parts_mean, dispersion),
        }
        for name, estimate in found.items():
            hits.setdefault(name, []).append(estimate.low <= 1.0 <= estimate.high)
    return {name: float(np.mean(hit)) for name, hit in hits.items()}


# Kinds and mean numbers of objects, point by point, and the standard error aimed at.
SWEEPS = {
    "many small fields to few large ones": ([SHRUB] * 5, [50, 300, 2000, 12000, 1e5], 0.02),
    "dispersion from point to point": ([SHRUB, BUSH] * 3, [50, 200, 1e3, 5e3, 2e4, 1e5], 0.02),
    "the small fields quieter": ([BUSH] + [SHRUB] * 4, [50, 500, 5e3, 2e4, 1e5], 0.02),
    "three points of figures": ([FIGURE] * 3, [200, 2000, 20000], 0.02),
    "three points of trees": ([TREE] * 3, [300, 3000, 30000], 0.04),
}


@pytest.mark.parametrize("name", SWEEPS)
def test_intervals_cover_at_their_rate(name):
    # 300 draws: 95 ± 1.26 %, so ± 4.4 is three and a half standard deviations.
    for estimate, share in coverage(300, 1, *SWEEPS[name]).items():
        assert 0.906 <= share <= 0.994, (estimate, share)


def test_the_weights_are_needed():
    """Many quiet small fields, few noisy large ones: one pooled dispersion claims too much."""
    chance = np.random.default_rng(3)
    hits = []
    for _ in range(300):
        _, parts, _, mean, dispersion = sweep(chance, *SWEEPS["the small fields quieter"])
        found = two_sided_slope(parts, mean), two_sided_slope(parts, mean, dispersion)
        hits.append([estimate.low <= 1 <= estimate.high for estimate in found])
    pooled, weighted = np.mean(hits, axis=0)
    assert pooled < 0.9 < weighted


def test_a_false_slope_is_found():
    chance = np.random.default_rng(4)
    _, parts, _, mean, dispersion = sweep(chance, *SWEEPS["many small fields to few large ones"])
    found = two_sided_slope(parts, mean**0.95, dispersion)
    assert found.low > 1.02 and found.value == pytest.approx(1 / 0.95, abs=0.01)


@pytest.mark.filterwarnings("ignore:Perfect separation")
def test_exact_data_give_the_exact_power():
    x = np.repeat(np.geomspace(1, 1e4, 9), 2)
    found = two_sided_slope(3 * x**-2.0, x)
    assert found.value == pytest.approx(-2.0, abs=1e-6) and found.high - found.low < 1e-6
    assert two_sided_ratio(3 * x, x).value == pytest.approx(3.0)


def test_standard_error_and_the_fields_it_takes():
    assert standard_error(np.array([9.0, 11.0])) == pytest.approx(0.1)
    assert standard_error(np.array([0.0, 0.0])) == math.inf
    assert standard_error(np.array([5.0])) == math.inf
    assert fields_needed(100.0, 100.0, 0.005) == 401
    assert fields_needed(1e9, 1e9, 0.005) == 1


@pytest.mark.parametrize(
    "call",
    [
        lambda: two_sided_slope(np.ones(2), np.array([1.0, 2.0])),
        lambda: two_sided_slope(np.ones(3), np.array([1.0, 2.0, -1.0])),
        lambda: two_sided_slope(np.array([1.0, -1.0, 2.0]), np.array([1.0, 2.0, 3.0])),
        lambda: two_sided_ratio(np.ones(1), np.ones(1)),
        lambda: fields_needed(0.0, 1.0, 0.005),
    ],
)
def test_what_cannot_be_estimated_is_refused(call):
    with pytest.raises(InputError):
        call()


def test_a_ratio_of_means_knows_its_error_and_refuses_what_has_none():
    """Groups of unlike size, of which the larger are the brighter: no mean of ratios."""
    rng = np.random.default_rng(7)
    inside = 0
    for _ in range(300):
        counts, out_of = (rng.poisson(mean, 12).astype(np.float64) for mean in (200.0, 100.0))
        sums = counts * (0.02 + 1e-4 * counts) * (1 + 0.1 * rng.normal(size=12))
        found = two_sided_ratio_of_means(sums, counts, 0.02 * out_of, out_of)
        inside += found.low <= 2.005 <= found.high
    # E[Σc²] / E[Σc] = 201: the mean is 0.02 + 0.0201, over 0.02
    assert 270 <= inside <= 297
    one = np.array((4.0, 6.0))
    assert two_sided_ratio_of_means(one, one, 2 * one, one).value == 0.5
    with pytest.raises(InputError):
        two_sided_ratio_of_means(one[:1], one[:1], one[:1], one[:1])
    with pytest.raises(InputError):
        two_sided_ratio_of_means(one, np.array((0.0, 1.0)), one, one)


@pytest.mark.parametrize("n", [3, 6])
def test_one_bound_is_past_the_mean_of_places_in_1_of_20_experiments(n):
    """As many places as presets have, whose errors scatter as the normal law says."""
    rng = np.random.Generator(np.random.Philox(n))
    tries = 4000
    made = [one_sided_mean(0.01 + 0.004 * rng.standard_normal(n)) for _ in range(tries)]
    scatter = 4 * (0.05 * 0.95 / tries) ** 0.5
    assert np.mean([each.high < 0.01 for each in made]) == pytest.approx(0.05, abs=scatter)
    assert np.mean([each.low > 0.01 for each in made]) == pytest.approx(0.05, abs=scatter)


def test_holm_rejects_in_order_until_one_does_not():
    assert holm([0.04, 0.001, 0.02], 0.05) == [True, True, True]
    assert holm([0.04, 0.001, 0.03], 0.05) == [False, True, False]
    assert holm([], 0.05) == []


@given(st.lists(st.floats(0, 1), min_size=1, max_size=20), st.floats(0.001, 0.2))
def test_holm_lies_between_bonferroni_and_none(chances, level):
    found = holm(chances, level)
    for chance, rejects in zip(chances, found, strict=True):
        assert (chance <= level / len(chances)) <= rejects <= (chance <= level)


def test_holm_rejects_any_true_hypothesis_in_one_family_of_twenty():
    """Ten true ones that depend on each other, and ten false ones beside them."""
    rng = np.random.Generator(np.random.Philox(11))
    wrong = 0
    for _ in range(2000):
        shared = rng.normal()
        true = stats.norm.sf(0.6 * shared + 0.8 * rng.normal(size=10))
        wrong += any(holm([*true, *[1e-9] * 10], 0.05)[:10])
    assert wrong / 2000 < 0.05 + 3 * math.sqrt(0.05 * 0.95 / 2000)
