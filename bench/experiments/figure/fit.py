"""How sure are exponents over poses, and rank correlations over parts?

Intervals are 95 % and two-sided: percentiles over bootstrap samples (Efron & Tibshirani, "An
Introduction to the Bootstrap", 1993, ch. 13). Exponents resample whole poses, since the counts of
one pose at its distances depend on each other; correlations resample groups of like parts, since a
left arm repeats the right one. Intervals say what other poses would have given; whether a count is
a straight line on logarithmic axes at all is seen by ``halves``. Functions touch no files.
"""

import numpy as np
from jaxtyping import Bool, Float64, Int64

from bench.experiments.figure.cases import Distances
from bench.statistics.estimates import TWO_SIDED_TAILS, Estimate
from lod.arrays import Ints, Reals
from lod.errors import InputError

Counts = Int64[np.ndarray, "distances poses"]
Chosen = Bool[np.ndarray, "distances poses"]

Weights = Float64[np.ndarray, "resamples parts"]

RESAMPLES = 2000


def exponent(
    counts: Counts, distances: Distances, chosen: Chosen, rng: np.random.Generator
) -> Estimate:
    """Estimate b of count ∝ distance^b: least squares of logarithms over chosen counts.

    Raises InputError unless every bootstrap sample has counts at 2 or more distances.
    """
    sums = _sums(counts, distances, chosen)
    weight = _resampled(counts.shape[1], rng)
    drawn = _slopes(weight @ sums)
    if not np.isfinite(drawn).all():
        raise InputError("exponent", int(chosen.sum()), "counts at 2 or more distances a sample")
    return _estimate(float(_slopes(sums.sum(axis=0))), drawn, counts.shape[1])


def line(counts: Counts, distances: Distances, chosen: Chosen) -> tuple[float, float]:
    """Return the exponent and the factor of the line fitted by ``exponent``."""
    sums = _sums(counts, distances, chosen).sum(axis=0)
    slope = float(_slopes(sums))
    return slope, float(np.exp((sums[2] - slope * sums[1]) / sums[0]))


def halves(counts: Counts, distances: Distances, chosen: Chosen) -> tuple[float, float]:
    """Return the exponents of the nearer and of the farther half of the chosen range, in ratio."""
    rows = np.flatnonzero(chosen.any(axis=1))
    middle = np.sqrt(distances[rows[0]].min() * distances[rows[-1]].max())
    near = distances <= middle
    nearer, farther = (line(counts, distances, chosen & half)[0] for half in (near, ~near))
    return nearer, farther


def rank_correlation(level: Ints, size: Ints, alike: Ints, rng: np.random.Generator) -> Estimate:
    """Estimate Spearman's ρ of size with level; parts ``alike`` are drawn together.

    ``alike`` (n,) numbers the group of each part, from 0.
    """
    weight = _resampled(int(alike.max()) + 1, rng)[:, alike]
    drawn = _spearman(level, size, weight)
    value = float(_spearman(level, size, np.ones((1, len(level))))[0])
    # a sample in which all levels or all sizes are one says nothing
    return _estimate(value, drawn[np.isfinite(drawn)], len(level))


def _sums(counts: Counts, distances: Distances, chosen: Chosen) -> Float64[np.ndarray, "poses 5"]:
    """Return the sums of 1, x, y, x² and x·y over each pose's chosen counts, in logarithms."""
    x = np.where(chosen, np.log(distances), 0.0)
    y = np.log(np.where(chosen, counts, 1))
    return np.stack([term.sum(axis=0) for term in (1.0 * chosen, x, y, x * x, x * y)], axis=1)


def _slopes(sums: Float64[np.ndarray, "... 5"]) -> Float64[np.ndarray, "..."]:
    n, x, y, xx, xy = np.moveaxis(sums, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((n * xy - x * y) / (n * xx - x * x))


def _resampled(n: int, rng: np.random.Generator) -> Float64[np.ndarray, "resamples n"]:
    """Draw how often each of n poses is in each bootstrap sample."""
    return rng.multinomial(n, np.full(n, 1 / n), size=RESAMPLES).astype(np.float64)


def _spearman(level: Ints, size: Ints, weight: Weights) -> Float64[np.ndarray, " resamples"]:
    """Return the correlation of ranks in samples that hold each part ``weight`` times."""
    a, b = (_ranks(values, weight) for values in (level, size))
    total = weight.sum(axis=1, keepdims=True)
    a, b = (ranks - (weight * ranks).sum(axis=1, keepdims=True) / total for ranks in (a, b))
    with np.errstate(invalid="ignore"):
        both = np.sqrt((weight * a * a).sum(axis=1) * (weight * b * b).sum(axis=1))
        return np.asarray((weight * a * b).sum(axis=1) / both)


def _ranks(values: Ints, weight: Weights) -> Weights:
    below = values[:, None] < values
    equal = values[:, None] == values
    return weight @ below + (weight @ equal) / 2


def _estimate(value: float, drawn: Reals, rows: int) -> Estimate:
    share = TWO_SIDED_TAILS[0]
    low, high = (float(v) for v in np.quantile(drawn, (share, 1 - share)))
    # scale is of models that assume a variance; a bootstrap assumes none
    return Estimate(value, min(low, value), max(high, value), float(drawn.std()), 1.0, rows)
