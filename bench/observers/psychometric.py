"""Psychometric functions: how they are sampled, fitted, and joined over observers.

An observer who chooses between two pictures is right with the probability

    p(x) = 1 − λ − (1 − ½ − λ)·exp(−10^(β·(x − α))),    x = log₁₀ τ,

a Weibull function of τ with slope β and lapse rate λ, who guesses right half of the time. τ₇₅ is
where an observer without lapses is right three times in four: 10^(β·(x₇₅ − α)) = ln 2.

**Sampling** is QUEST+ (Watson, Journal of Vision 17(3):10, 2017): of all levels the next is that
after which the expected entropy of the posterior is least. With w the posterior and p_L(θ) the
chance of a right answer, that entropy is, up to a constant, −Σ w·h(p_L) + h(Σ w·p_L), where
h(p) = p·ln p + (1−p)·ln(1−p).

**Fitting** integrates the posterior over a grid (Schütt et al., Vision Research 122, 2016). Priors
are weak: log₁₀ τ₇₅ is normal about the middle of the levels, ln β is normal, λ is Beta(1,
LAPSE_BETA). Estimates and intervals are quantiles of the posterior.

**Joining** is a mixed model of the estimates, y_ij = μ_j + b_i + e_ij: conditions j are fixed,
observers i random, and the variance of e_ij is its own plus one from condition to condition. The
prior is divided out of each estimate first. Both variances are found by restricted maximum
likelihood (Harville, JASA 72, 1977).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Bool, Float64, Int64
from scipy import optimize, stats

from bench.statistics.estimates import TWO_SIDED_TAILS, Estimate, student_interval
from lod.arrays import Ints, Reals
from lod.errors import InputError

GUESS = 0.5
AT_75 = math.log10(math.log(2))  # β·(x₇₅ − α)

THRESHOLD_DEVIATION = 0.4
SLOPE_PRIOR = 2.5, 0.4
LAPSE_BETA = 30.0
"""Priors: deviation of log₁₀ τ₇₅ (95 % within a factor of 6); median of β and deviation of ln β."""


def chance_correct(
    x: np.ndarray, alpha: np.ndarray, beta: np.ndarray, lapse: np.ndarray
) -> np.ndarray:
    """Return the probability of a right answer at levels x = log₁₀ τ; arguments broadcast."""
    return np.asarray(1 - lapse - (1 - GUESS - lapse) * np.exp(-(10.0 ** (beta * (x - alpha)))))


def _grid(*axes: Sequence[float] | np.ndarray) -> list[np.ndarray]:
    return [each.ravel() for each in np.meshgrid(*axes, indexing="ij")]


def _information(p: np.ndarray) -> np.ndarray:
    return np.asarray(p * np.log(p) + (1 - p) * np.log1p(-p))


@dataclass(frozen=True)
class Staircase:
    """QUEST+ at levels x over a grid of α, β and λ, with a flat prior, as the page runs it."""

    levels: tuple[float, ...]
    thresholds: tuple[float, ...]
    slopes: tuple[float, ...]
    lapses: tuple[float, ...]

    @cached_property
    def _tables(self) -> tuple[np.ndarray, np.ndarray]:
        grid = _grid(self.thresholds, self.slopes, self.lapses)
        p = chance_correct(np.array(self.levels)[:, None], *grid)
        return p, _information(p)

    def start(self, count: int) -> Float64[np.ndarray, "n k"]:
        """Return the prior of so many staircases."""
        size = self._tables[0].shape[1]
        return np.full((count, size), 1 / size)

    def next_level(self, posterior: Float64[np.ndarray, "n k"]) -> Ints:
        """Return the number of the level that every staircase shows next, (n,)."""
        p, information = self._tables
        return np.argmin(_information(posterior @ p.T) - posterior @ information.T, axis=1)

    def updated(
        self, posterior: Float64[np.ndarray, "n k"], level: Ints, correct: Bool[np.ndarray, " n"]
    ) -> Float64[np.ndarray, "n k"]:
        """Return the posterior after an answer in each staircase."""
        p = self._tables[0][level]
        after = posterior * np.where(correct[:, None], p, 1 - p)
        return after / after.sum(axis=1, keepdims=True)


@dataclass(frozen=True)
class Fits:
    """Fits of n staircases: log₁₀ τ₇₅, deviation, 95 % interval, (n,) each; the prior's middle."""

    value: Reals
    deviation: Reals
    low: Reals
    high: Reals
    middle: float


def fit(
    levels: Sequence[float], right: Int64[np.ndarray, "n m"], shown: Int64[np.ndarray, "n m"]
) -> Fits:
    """Fit n psychometric functions to the right answers among those shown at m levels.

    ``levels`` are log₁₀ τ of the staircase, and of catch trials behind them; the prior lies about
    the middle of the first and the last but one.
    """
    x = np.asarray(levels, np.float64)
    middle = (x[0] + x[-2]) / 2
    t = middle + THRESHOLD_DEVIATION * np.linspace(-3, 3, 121)
    log_slope = math.log(SLOPE_PRIOR[0]) + SLOPE_PRIOR[1] * np.linspace(-2.5, 2.5, 9)
    # In the middle of bins of equal prior probability.
    lapse = stats.beta.ppf((np.arange(6) + 0.5) / 6, 1, LAPSE_BETA)
    at, slope, lapses = _grid(t, np.exp(log_slope), lapse)
    log_prior = stats.norm.logpdf(at, middle, THRESHOLD_DEVIATION)
    log_prior += stats.norm.logpdf(np.log(slope), math.log(SLOPE_PRIOR[0]), SLOPE_PRIOR[1])
    p = chance_correct(x[:, None], at - AT_75 / slope, slope, lapses)
    log_p, log_q = np.log(p), np.log(np.maximum(1 - p, 1e-12))
    log_posterior = log_prior + right @ log_p + (shown - right) @ log_q
    mass = np.exp(log_posterior - log_posterior.max(axis=1, keepdims=True))
    mass = mass.reshape(len(right), len(t), -1).sum(axis=2)
    mass /= mass.sum(axis=1, keepdims=True)
    mean = mass @ t
    deviation = np.sqrt(np.sum(mass * (t - mean[:, None]) ** 2, axis=1))
    below = np.cumsum(mass, axis=1) - mass / 2
    tails = TWO_SIDED_TAILS[0], 0.5, TWO_SIDED_TAILS[1]
    low, value, high = (np.array([np.interp(tail, row, t) for row in below]) for tail in tails)
    return Fits(value, deviation, low, high, float(middle))


def join(
    found: Fits, observer: Ints, condition: Ints
) -> tuple[tuple[Estimate, ...], tuple[float, float]]:
    """Fit the mixed model to fits, (n,), of observers and conditions, which count from 0.

    Returns log₁₀ τ₇₅ of every condition, and the deviations of b_i and of e_ij beyond its own.
    Raises InputError for a condition of fewer than two observers.
    """
    n_conditions, n_observers = int(condition.max()) + 1, int(observer.max()) + 1
    replicates = np.bincount(condition)
    if replicates.min() < 2:
        raise InputError("observers", int(replicates.min()), "at least 2 in every condition")
    # The product of two normal densities has the sum of their precisions; taken back.
    prior = 1 / THRESHOLD_DEVIATION**2
    precision = np.maximum(1 / found.deviation**2 - prior, 0.02 * prior)
    y = (found.value / found.deviation**2 - found.middle * prior) / precision
    y = np.clip(y, found.middle - 1.0, found.middle + 1.0)
    x, z = np.eye(n_conditions)[condition], np.eye(n_observers)[observer]

    def solved(theta: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        # By Woodbury: V = D + σ²·ZZᵀ, whose inverse needs sums over each observer alone.
        weight = 1 / (1 / precision + theta[1] ** 2)
        share = theta[0] ** 2 / (1 + theta[0] ** 2 * (z.T @ weight))
        wx, wy = weight[:, None] * x, weight * y
        zx, zy = z.T @ wx, z.T @ wy
        information = x.T @ wx - zx.T @ (share[:, None] * zx)
        mean = np.linalg.solve(information, x.T @ wy - zx.T @ (share * zy))
        rest = y - x @ mean
        zr = z.T @ (weight * rest)
        square = rest @ (weight * rest) - zr @ (share * zr)
        log_det = np.log1p(theta[0] ** 2 * (z.T @ weight)).sum() - np.log(weight).sum()
        loss = (log_det + np.linalg.slogdet(information)[1] + square) / 2
        return float(loss), mean, information

    best = optimize.minimize(lambda theta: solved(theta)[0], [0.1, 0.1], bounds=[(0, 2)] * 2)
    _, mean, information = solved(best.x)
    errors = np.sqrt(np.diag(np.linalg.inv(information)))
    made = tuple(
        student_interval(float(m), float(e), int(n) - 1, int(n))
        for m, e, n in zip(mean, errors, replicates, strict=True)
    )
    return made, (float(best.x[0]), float(best.x[1]))
