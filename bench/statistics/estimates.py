"""How sure: slopes, ratios and errors of counts whose noise is compound Poisson. Pure, no files.

Every row is one field (one independent seed). Its count has mean μ and variance scale·φ·μ, where
φ is the dispersion that the law predicts for its row: 1 for objects; for parts more, because the
parts of one object come together, and not the same at every point of a sweep. Rows are weighted by
1/φ, and the one scale left is measured (Pearson's χ² over its degrees of freedom), so that a wrong
φ widens the interval instead of hiding in it: a quasi-Poisson model (Wedderburn 1974; McCullagh &
Nelder, "Generalized Linear Models", 2nd ed., §9.2) with Student's t for the interval.

Without the weights one pooled dispersion stands for all points: it is that of the points with the
most fields. Where dispersion varies from point to point, its 95 % intervals of a slope covered the
truth anywhere from 81 % to 98 % of the time in simulation; the weighted ones 94 % to 96 %.
"""

import math
from dataclasses import dataclass

import numpy as np
import statsmodels.api as sm
from scipy import stats

from lod.arrays import Reals
from lod.errors import InputError

CONFIDENCE = 0.95

LEAST_REPEATS = 8
"""Repeats of whatever is timed, after a first one that is not counted, before a median is told."""


@dataclass(frozen=True)
class Estimate:
    """A measured number with its 95 % interval.

    scale is the variance measured over the variance assumed (1: the law's noise is right too);
    rows is the number of fields behind it.
    """

    value: float
    low: float
    high: float
    standard_error: float
    scale: float
    rows: int


def slope(counts: Reals, covariate: Reals, dispersion: Reals | None = None) -> Estimate:
    """Exponent b of E[count] = a·covariate^b: a quasi-Poisson GLM with log link."""
    log_x = np.log(_positive("covariate", covariate))
    if len(log_x) < 3 or np.ptp(log_x) == 0:
        raise InputError("slope", len(log_x), "at least 3 rows at 2 or more different covariates")
    # Centred, so that the level and the exponent are nearly uncorrelated.
    design = np.column_stack((np.ones_like(log_x), log_x - log_x.mean()))
    return _fit(counts, design, None, dispersion)


def ratio(counts: Reals, predicted: Reals, dispersion: Reals | None = None) -> Estimate:
    """Measured ÷ predicted, one number over all rows: a GLM with offset log(predicted)."""
    offset = np.log(_positive("predicted", predicted))
    if len(offset) < 2:
        raise InputError("ratio", len(offset), "at least 2 rows")
    fit = _fit(counts, np.ones((len(offset), 1)), offset, dispersion)
    # The interval is symmetric for the logarithm, as the model is.
    value, low, high = (math.exp(v) for v in (fit.value, fit.low, fit.high))
    return Estimate(value, low, high, value * fit.standard_error, fit.scale, fit.rows)


def share(counts: Reals, out_of: Reals) -> Estimate:
    """Σcounts ÷ Σout_of over fields, each field's counts being among its ``out_of``.

    The standard error of a ratio of means, by linearisation (Cochran, "Sampling Techniques", 3rd
    ed., §6.3), with Student's t; the interval is kept within 0 to 1.
    """
    counts, out_of = np.asarray(counts, np.float64), np.asarray(out_of, np.float64)
    if len(counts) != len(out_of) or len(counts) < 2:
        raise InputError("share", (len(counts), len(out_of)), "2 fields or more, the same")
    if not (np.isfinite(out_of).all() and (0 <= counts).all() and (counts <= out_of).all()):
        raise InputError("share", "a count outside 0 to what it is out of", "a share of each field")
    if not out_of.any():
        return Estimate(0.0, 0.0, 0.0, 0.0, 1.0, len(counts))
    value = float(counts.sum() / out_of.sum())
    spread = float(np.std(counts - value * out_of, ddof=1)) / math.sqrt(len(counts))
    error = spread / float(out_of.mean())
    reach = float(stats.t.ppf((1 + CONFIDENCE) / 2, len(counts) - 1)) * error
    low, high = max(0.0, value - reach), min(1.0, value + reach)
    return Estimate(value, low, high, error, 1.0, len(counts))


def paired_ratio(counts: Reals, wholes: Reals) -> Estimate:
    """Σcounts ÷ Σwholes over pairs, by leaving one pair out at a time (the jackknife: Efron and
    Tibshirani, "An Introduction to the Bootstrap", §11), with Student's t."""
    n = len(counts)
    if n < 2 or len(wholes) != n or not (wholes > 0).any():
        raise InputError("paired_ratio", (n, len(wholes)), "2 pairs or more, not all of nothing")
    value = float(counts.sum() / wholes.sum())
    without = (counts.sum() - counts) / (wholes.sum() - wholes)
    error = math.sqrt((n - 1) * float(without.var()))
    reach = float(stats.t.ppf((1 + CONFIDENCE) / 2, n - 1)) * error
    return Estimate(value, value - reach, value + reach, error, 1.0, n)


def ratio_of_means(sums: Reals, counts: Reals, wholes: Reals, out_of: Reals) -> Estimate:
    """(Σsums ÷ Σcounts) ÷ (Σwholes ÷ Σout_of) over groups, by leaving one group out at a time, as
    in ``paired_ratio``."""
    columns = sums, counts, wholes, out_of
    n, rest = len(sums), [each.sum() - each for each in columns]
    if n < 2 or not all((each > 0).all() for each in rest[1:]):
        rule = "2 groups or more, and without any one of them some of everything"
        raise InputError("ratio_of_means", n, rule)
    total = [each.sum() for each in columns]
    value = float(total[0] / total[1] / (total[2] / total[3]))
    without = rest[0] / rest[1] / (rest[2] / rest[3])
    error = math.sqrt((n - 1) * float(without.var()))
    reach = float(stats.t.ppf((1 + CONFIDENCE) / 2, n - 1)) * error
    return Estimate(value, value - reach, value + reach, error, 1.0, n)


def median(values: Reals) -> Estimate:
    """The median; its interval from order statistics, whatever the distribution.

    The k-th smallest and k-th largest of n hold it with probability 1 − 2·B(k − 1; n, ½) (David &
    Nagaraja, "Order Statistics", 3rd ed. 2003, §7.1): the greatest k for which that is enough.
    """
    n = len(values)
    k = int(stats.binom.ppf((1 - CONFIDENCE) / 2, n, 0.5))
    if n < LEAST_REPEATS or not np.isfinite(values).all():
        raise InputError("median", n, f"at least {LEAST_REPEATS} finite values")
    up = np.sort(values)
    low, high = float(up[k - 1]), float(up[n - k])
    return Estimate(float(np.median(values)), low, high, (high - low) / 4, 1.0, n)


def quantile(values: Reals, share: float) -> Estimate:
    """A quantile with its interval by order statistics, whatever the distribution."""
    ordered, n = np.sort(values), len(values)
    ends = stats.binom.ppf([(1 - CONFIDENCE) / 2, (1 + CONFIDENCE) / 2], n, share).astype(int)
    low, high = ordered[np.clip(ends - [1, 0], 0, n - 1)]
    value = float(np.clip(np.quantile(ordered, share), low, high))
    return Estimate(value, float(low), float(high), float(high - low) / 4, 1.0, n)


def mean(values: Reals) -> Estimate:
    """Mean with Student's interval."""
    error = float(values.std(ddof=1)) / len(values) ** 0.5
    half = float(stats.t.ppf((1 + CONFIDENCE) / 2, len(values) - 1)) * error
    value = float(values.mean())
    return Estimate(value, value - half, value + half, error, 1.0, len(values))


def standard_error(counts: Reals) -> float:
    """Standard error of the mean, as a share of the mean; infinite where nothing was counted."""
    mean = float(np.mean(counts))
    if len(counts) < 2 or mean == 0:
        return math.inf
    return float(np.std(counts, ddof=1)) / math.sqrt(len(counts)) / mean


def fields_needed(mean: float, variance: float, target: float) -> int:
    """Fields for which a mean of that variance has a relative standard error below ``target``."""
    if not (mean > 0 and variance >= 0 and target > 0):
        raise InputError("fields", (mean, variance, target), "a mean and a target above 0")
    return math.floor(variance / (mean * target) ** 2) + 1


def _fit(
    counts: Reals, design: np.ndarray, offset: Reals | None, dispersion: Reals | None
) -> Estimate:
    """The last coefficient of the weighted quasi-Poisson model, with its t interval."""
    counts = np.asarray(counts, np.float64)
    if len(counts) != len(design) or not (np.isfinite(counts).all() and (counts >= 0).all()):
        raise InputError("counts", len(counts), f"{len(design)} finite counts, none below 0")
    if not counts.any():
        raise InputError("counts", 0, "something was counted", "widen the sweep")
    weights = 1 / (np.ones(len(counts)) if dispersion is None else _positive("φ", dispersion))
    model = sm.GLM(counts, design, sm.families.Poisson(), offset=offset, var_weights=weights)
    fit = model.fit(scale="X2")
    value, error = float(fit.params[-1]), float(fit.bse[-1])
    reach = float(stats.t.ppf((1 + CONFIDENCE) / 2, fit.df_resid)) * error
    return Estimate(value, value - reach, value + reach, error, float(fit.scale), len(counts))


def _positive(name: str, values: Reals) -> np.ndarray:
    values = np.asarray(values, np.float64)
    if not (np.isfinite(values).all() and (values > 0).all()):
        raise InputError(name, float(values.min()), "every value finite and above 0")
    return values
