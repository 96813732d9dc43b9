"""Is a relation a power law? Log-log fits with robust errors, and Akaike's criterion.

Errors are heteroscedasticity-consistent (HC3: MacKinnon & White, J. Econometrics 29, 1985), because
whether the scatter of a time is in proportion to the time is not known. Functions touch no files.

What is the error of a picture with all noise taken away? Fitted from a few counts of samples.

The mean FLIP of two renders with other seeds grows with their noise, whose standard deviation falls
as 1/√N with N samples a pixel. So errors at several N are fitted by a + b/√N (least squares), and a
is what is left where nothing is noisy. Nothing is subtracted from it: two renders of one scene have
an a near 0, which tells how far the fit can be trusted. Functions here touch no files.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from bench.statistics.estimates import Estimate, student_interval
from lod.arrays import Reals
from lod.errors import InputError

EVEN = 2.0
"""A difference of AIC that does not decide between two models (Burnham & Anderson, "Model Selection
and Multimodel Inference", 2nd ed. 2002, §2.6)."""

LEAST_ROWS = 4
"""The fewest rows of which two models are compared."""


@dataclass(frozen=True)
class RivalModels:
    """Two models of one set of rows: y = a·x^b with log-normal errors, and y = a + b·ln x.

    power       (a, b) of the power law
    logarithm   (a, b) of the logarithm
    aic_gained  AIC of the logarithm − AIC of the power law: above 0 the power law is better
    """

    power: tuple[float, float]
    logarithm: tuple[float, float]
    aic_gained: float

    @property
    def words(self) -> str:
        """A phrase that says which model describes the rows better, and by how much."""
        if abs(self.aic_gained) < EVEN:
            return "a power law and a + b·log x describe it equally well (AIC)"
        better, worse = ("a power law", "a + b·log x")[:: 1 if self.aic_gained > 0 else -1]
        return f"{better} describes it better than {worse}, by {abs(self.aic_gained):.0f} in AIC"

    def line(self, x: Reals) -> Reals:
        """Return y of the better model at each x, (n,)."""
        if self.aic_gained >= 0:
            return np.asarray(self.power[0] * x ** self.power[1])
        return np.asarray(self.logarithm[0] + self.logarithm[1] * np.log(x))


def fit_exponent(x: Reals, y: Reals) -> Estimate:
    """Estimate b of y = a·x^b, (n,) each, with a two-sided 95 % interval.

    The fit is least squares of logarithms; errors are HC3, the interval is Student's. Raises
    InputError for fewer than 3 values and for values that are not finite and above 0.
    """
    import statsmodels.api as sm

    fit = sm.OLS(np.log(_positive(y)), sm.add_constant(np.log(_positive(x)))).fit(cov_type="HC3")
    value, error = float(fit.params[1]), float(fit.bse[1])
    return student_interval(value, error, float(fit.df_resid), len(y))


def compare_with_log(x: Reals, y: Reals) -> RivalModels:
    """Fit both models to rows (n,) by least squares, and compare them by AIC.

    Both AICs are of y: that of log y is raised by 2·Σ log y, for the change of variable. Raises
    InputError for fewer than LEAST_ROWS rows and for values that have no logarithm.
    """
    if len(x) < LEAST_ROWS:
        raise InputError("compare_with_log", len(x), f"at least {LEAST_ROWS} rows")
    import statsmodels.api as sm

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


def noise_free(
    samples: Float64[np.ndarray, " counts"], errors: Float64[np.ndarray, "counts n"]
) -> Float64[np.ndarray, " n"]:
    """Fit a + b/√N to each column of errors, and return every a, (n,).

    ``samples`` (counts,) holds the samples of a pixel, N. Raises InputError for fewer than two
    different counts and for counts below 1.
    """
    counts = np.asarray(samples, np.float64)
    if len(set(counts.tolist())) < 2 or counts.min() < 1:
        raise InputError("samples", counts.tolist(), "two counts or more, each at least 1")
    design = np.column_stack((np.ones_like(counts), 1 / np.sqrt(counts)))
    fitted = np.linalg.lstsq(design, np.asarray(errors, np.float64), rcond=None)[0]
    return np.asarray(fitted[0])
