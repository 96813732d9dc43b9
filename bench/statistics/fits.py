"""What is the exponent of a power law? Log-log fits with robust errors.

Errors are heteroscedasticity-consistent (HC3: MacKinnon & White, J. Econometrics 29, 1985), because
whether the scatter of a time is in proportion to the time is not known. Functions touch no files.

Errors of pictures without their noise are fitted as ``bench.images.differences`` says.
"""

import numpy as np
from jaxtyping import Float64

from bench.statistics.estimates import Estimate, student_interval
from lod.arrays import Reals
from lod.errors import InputError


def fit_exponent(x: Reals, y: Reals) -> Estimate:
    """Estimate b of y = a·x^b, (n,) each, with a two-sided 95 % interval.

    The fit is least squares of logarithms; errors are HC3, the interval is Student's. Raises
    InputError for fewer than 3 values and for values that are not finite and above 0.
    """
    import statsmodels.api as sm

    fit = sm.OLS(np.log(_positive(y)), sm.add_constant(np.log(_positive(x)))).fit(cov_type="HC3")
    value, error = float(fit.params[1]), float(fit.bse[1])
    return student_interval(value, error, float(fit.df_resid), len(y))


def _positive(values: Reals) -> Reals:
    if not (np.isfinite(values).all() and (values > 0).all() and len(values) > 2):
        raise InputError("values", float(np.min(values)), "3 values or more, finite and above 0")
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
