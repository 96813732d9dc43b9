"""Which τ and how many parts give every metric the same error?

Both are read between two details along straight lines of their logarithms, in every replicate by
itself: a field, or a pair of seeds. Intervals are 95 % and two-sided, of the mean of logarithms
over replicates (Student's t).
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from bench.records.records import Point, grouped
from bench.statistics.estimates import Estimate, two_sided_factor
from lod.arrays import Reals, freeze

EQUAL_ERROR = 0.01  # the error at which ways to prune are compared

GRASS_ERROR = 0.05
"""The error at which metrics are compared over nothing but grass: less takes nearly every blade."""


@dataclass(frozen=True, eq=False)
class Reached:
    """The τ [px] and the parts at which one metric comes up to the error in each replicate, (n,).

    They are NaN where the error is never reached between the details.
    """

    metric: str
    details: Reals
    parts: Reals

    def __post_init__(self) -> None:
        freeze(self, details=np.float64, parts=np.float64)

    @property
    def found(self) -> bool:
        """Whether every replicate comes up to the error, and there are two or more."""
        return bool(np.isfinite(self.details).all()) and len(self.details) > 1

    def parts_over(self, other: "Reached") -> Estimate:
        """Estimate the parts of this metric ÷ those of another, replicate by replicate."""
        return two_sided_factor(self.parts / other.parts)

    @property
    def detail(self) -> Estimate:
        """The τ at equal error, estimated [px]."""
        return two_sided_factor(self.details)


def equal_error(
    points: Sequence[Point], errors: Callable[[Point], Reals], error: float = EQUAL_ERROR
) -> dict[str, Reached]:
    """Find where every metric of these points comes up to an error, in the order they come.

    ``errors`` gives the errors of a point's replicates, (n,).
    """
    made = {}
    for (metric,), row in grouped(points, "metric").items():
        row.sort(key=lambda p: p.case["detail"])
        found = np.array([errors(p) for p in row])
        parts = [np.broadcast_to(p.values("parts"), found.shape[1:]) for p in row]
        details = np.array([p.case["detail"] for p in row], np.float64)
        crossed = crossings(details, found, np.array(parts), error)
        made[metric] = Reached(metric, crossed[:, 0], crossed[:, 1])
    return made


def crossings(
    details: Float64[np.ndarray, " details"],
    errors: Float64[np.ndarray, "details n"],
    parts: Float64[np.ndarray, "details n"],
    error: float = EQUAL_ERROR,
) -> Float64[np.ndarray, "n 2"]:
    """Find the τ [px] and the parts at which errors first come up to one, (n, 2).

    ``details`` [px] grow. Values between two of them lie on straight lines of logarithms, where 0
    parts count as 1. NaN says that the error is never reached.
    """
    found, level = np.log(np.maximum(errors, 1e-6)), math.log(error)
    at = np.stack(np.broadcast_arrays(np.log(details)[:, None], np.log(np.maximum(parts, 1))), 2)
    made = np.full((errors.shape[1], 2), math.nan)
    for k in range(len(details) - 1, 0, -1):  # the first crossing is written last
        here = np.flatnonzero((found[k - 1] <= level) & (level < found[k]))
        share = (level - found[k - 1, here]) / (found[k, here] - found[k - 1, here])
        step = at[k, here] - at[k - 1, here]
        made[here] = np.exp(at[k - 1, here] + share[:, None] * step)
    return made
