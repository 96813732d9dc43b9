"""Which τ and how many parts give every metric the same excess FLIP?

Both are read between two details along straight lines of their logarithms. Intervals are 95 % and
two-sided: percentiles of a bootstrap over pairs of seeds.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64

from bench.experiments.fidelity.scene import SPECIES
from bench.records.points import Key, Point, where
from bench.statistics.estimates import TWO_SIDED_TAILS, Estimate
from lod.arrays import Reals

EQUAL_ERROR = 0.01
"""The excess FLIP at which metrics are compared."""

_DRAWS = 400

Drawn = Int64[np.ndarray, "draws pairs"]
Crossings = Float64[np.ndarray, "draws 2"]


@dataclass(frozen=True, eq=False)
class Reached:
    """The τ [px] and the parts at which one metric comes up to the error in one view.

    Both are (1 + draws,): first for all pairs of seeds, then for resampled pairs. They are NaN
    where the error is never reached between the details.
    """

    metric: str
    details: Reals
    parts: Reals

    @property
    def found(self) -> bool:
        """Whether every draw comes up to the error."""
        return bool(np.isfinite(self.details).all())

    def parts_over(self, other: "Reached") -> Estimate:
        """Estimate the parts of this metric ÷ those of another, over the same draws of pairs."""
        return _estimate(self.parts / other.parts)

    @property
    def detail(self) -> Estimate:
        """The τ at equal error, estimated [px]."""
        return _estimate(self.details)

    @property
    def part_count(self) -> Estimate:
        """The number of parts displayed at equal error, estimated."""
        return _estimate(self.parts)


def equal_error(points: Sequence[Point]) -> dict[str, Reached]:
    """Find equal error for every metric of one view's points, in the order they come."""
    rows = {metric: curve(points, metric) for metric in metrics_of(points)}
    return {metric: _reached(metric, row) for metric, row in rows.items()}


def metrics_of(points: Sequence[Point]) -> list[str]:
    """Return the metrics by which species are pruned."""
    return list(dict.fromkeys(p.case["metric"] for p in where(points, pruned=SPECIES)))


def curve(points: Sequence[Point], metric: str) -> list[Point]:
    """Return the points of species pruned by a metric, from the finest detail to the coarsest."""
    mine = where(points, metric=metric, pruned=SPECIES)
    return sorted(mine, key=lambda p: p.case["detail"])


def excesses(point: Point) -> Reals:
    """Return the excess FLIP of every pair of seeds, (pairs,)."""
    return column(point, "flip") - column(point, "flip_floor")


def column(point: Point, quantity: str, **keys: Key) -> Reals:
    """Return a column of millionths as numbers of its unit."""
    return point.values(quantity, **keys) / 1e6


def reached(points: Sequence[Point], draws: Drawn, error: float = EQUAL_ERROR) -> Crossings:
    """Find the τ [px] and the parts at which the excess comes up to an error, (draws, 2).

    ``draws`` (draws, pairs) holds the pairs of seeds over which each draw is a mean. Values between
    two details lie on straight lines of logarithms, where 0 parts count as 1. NaN says that the
    error is never reached.
    """
    rows = np.array([excesses(p) for p in points])[:, draws].mean(axis=2)
    found = np.log(np.maximum(rows, 1e-6))
    at = np.log([(p.case["detail"], max(p.column("parts")[0], 1)) for p in points])
    made, level = np.full((len(draws), 2), math.nan), math.log(error)
    for k in range(len(points) - 1, 0, -1):  # the first crossing is written last
        here = np.flatnonzero((found[k - 1] <= level) & (level < found[k]))
        share = (level - found[k - 1, here]) / (found[k, here] - found[k - 1, here])
        made[here] = np.exp(at[k - 1] + share[:, None] * (at[k] - at[k - 1]))
    return made


def _reached(metric: str, row: Sequence[Point]) -> Reached:
    pairs = np.arange(len(row[0].column("flip")))
    rng = np.random.Generator(np.random.Philox(0))
    draws = np.array([pairs, *(rng.choice(pairs, len(pairs)) for _ in range(_DRAWS))])
    found = reached(row, draws)
    return Reached(metric, found[:, 0], found[:, 1])


def _estimate(draws: Reals) -> Estimate:
    """Estimate the first value, with percentiles of the others as its interval."""
    value, others = float(draws[0]), draws[1:]
    low, high = np.quantile(others, TWO_SIDED_TAILS)
    ends = min(float(low), value), max(float(high), value)
    return Estimate(value, *ends, float(others.std(ddof=1)), 1.0, len(draws))
