"""What is the error of a picture with all noise taken away? Fitted from a few counts of samples.

The mean FLIP of two renders with other seeds grows with their noise, whose standard deviation falls
as 1/√N with N samples a pixel. So errors at several N are fitted by a + b/√N (least squares), and a
is what is left where nothing is noisy. Nothing is subtracted from it: two renders of one scene have
an a near 0, which tells how far the fit can be trusted. Functions here touch no files.
"""

import math

import numpy as np
from jaxtyping import Float64
from scipy import stats

from bench.statistics.estimates import Estimate
from bench.statistics.excess_flip import ONE_SIDED_CONFIDENCE
from lod.arrays import Reals
from lod.errors import InputError


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


def one_sided_mean(values: Reals) -> Estimate:
    """Estimate the mean of n ≥ 2 values, (n,), with one-sided 95 % bounds (Student's t).

    The truth is above the upper bound in 5 % of experiments and below the lower one in 5 %. Raises
    InputError for fewer than 2 values.
    """
    n = len(values)
    if n < 2:
        raise InputError("values", n, "two or more, to bound their mean")
    error = float(values.std(ddof=1)) / math.sqrt(n)
    reach = float(stats.t.ppf(ONE_SIDED_CONFIDENCE, n - 1)) * error
    mean = float(values.mean())
    return Estimate(mean, mean - reach, mean + reach, error, 1.0, n)
