"""Is it a power law? Log-log fits with robust errors, and a rival by Akaike's criterion. Pure.

Errors are heteroscedasticity-consistent (HC3: MacKinnon & White, J. Econometrics 29, 1985), because
what is timed scatters in proportion to itself, or not, and nobody knows which.
"""

import math
from dataclasses import dataclass

import numpy as np
import statsmodels.api as sm
from scipy import stats

from bench.statistics.estimates import CONFIDENCE, Estimate
from lod.arrays import Reals
from lod.errors import InputError

EVEN = 2.0
"""A difference of AIC that says nothing (Burnham & Anderson, "Model Selection and Multimodel
Inference", 2nd ed. 2002, §2.6)."""

LEAST_ROWS = 4


@dataclass(frozen=True)
class RivalModels:
    """Two models of the same rows: y = a·x^b, scattering by factors, and y = a + b·log x.

    power       (a, b) of the first;  logarithm: (a, b) of the second, by natural logarithms
    aic_gained  AIC of the second less that of the first: above 0 the power law describes y better
    """

    power: tuple[float, float]
    logarithm: tuple[float, float]
    aic_gained: float

    @property
    def words(self) -> str:
        """Which describes the rows better, and by how much."""
        if abs(self.aic_gained) < EVEN:
            return "a power law and a + b·log x describe it equally well (AIC)"
        better, worse = ("a power law", "a + b·log x")[:: 1 if self.aic_gained > 0 else -1]
        return f"{better} describes it better than {worse}, by {abs(self.aic_gained):.0f} in AIC"

    def line(self, x: Reals) -> Reals:
        """What the better of the two gives."""
        if self.aic_gained >= 0:
            return np.asarray(self.power[0] * x ** self.power[1])
        return np.asarray(self.logarithm[0] + self.logarithm[1] * np.log(x))


def fit_exponent(x: Reals, y: Reals) -> Estimate:
    """b of y = a·x^b by least squares of logarithms, errors HC3, with Student's t."""
    fit = sm.OLS(np.log(_positive(y)), sm.add_constant(np.log(_positive(x)))).fit(cov_type="HC3")
    value, error = float(fit.params[1]), float(fit.bse[1])
    reach = float(stats.t.ppf((1 + CONFIDENCE) / 2, fit.df_resid)) * error
    return Estimate(value, value - reach, value + reach, error, 1.0, len(y))


def compare_with_log(x: Reals, y: Reals) -> RivalModels:
    """Both models, by least squares. Both AICs are of y itself: the density of log y gains Σ log y.

    Raises InputError for fewer than 4 rows, or what has no logarithm.
    """
    if len(x) < LEAST_ROWS:
        raise InputError("compare_with_log", len(x), f"at least {LEAST_ROWS} rows")
    design = sm.add_constant(np.log(_positive(x)))
    power, plain = sm.OLS(np.log(_positive(y)), design).fit(), sm.OLS(y, design).fit()
    gained = float(plain.aic - (power.aic + 2 * np.log(y).sum()))
    a, b = (float(v) for v in power.params)
    return RivalModels((math.exp(a), b), (float(plain.params[0]), float(plain.params[1])), gained)


def _positive(values: Reals) -> Reals:
    if not (np.isfinite(values).all() and (values > 0).all() and len(values) > 2):
        raise InputError(
            "compare_with_log", float(np.min(values)), "3 values or more, finite and above 0"
        )
    return values
