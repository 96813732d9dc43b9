"""At equal error: the τ and the parts at which every metric's excess FLIP comes up to one value.

Read between two details along straight lines of their logarithms; intervals are percentiles of a
bootstrap over pairs of seeds.
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
    """Of a metric in a view: τ [px] and parts there, over all pairs and over resampled ones.

    NaN where the error is never there between the details; (1 + draws,) each.
    """

    metric: str
    details: Reals
    parts: Reals

    @property
    def found(self) -> bool:
        """Whether every draw comes up to the error."""
        return bool(np.isfinite(self.details).all())

    def parts_over(self, other: "Reached") -> Estimate:
        """Its parts ÷ the other's, the same pairs drawn for both."""
        return _estimate(self.parts / other.parts)

    @property
    def detail(self) -> Estimate:
        """τ [px]."""
        return _estimate(self.details)

    @property
    def part_count(self) -> Estimate:
        """Parts displayed there."""
        return _estimate(self.parts)


def equal_error(points: Sequence[Point]) -> dict[str, Reached]:
    """Every metric of one view's points, in the order they come."""
    rows = {metric: curve(points, metric) for metric in metrics_of(points)}
    return {metric: _reached(metric, row) for metric, row in rows.items()}


def metrics_of(points: Sequence[Point]) -> list[str]:
    """The metrics that species are pruned by."""
    return list(dict.fromkeys(p.case["metric"] for p in where(points, pruned=SPECIES)))


def curve(points: Sequence[Point], metric: str) -> list[Point]:
    """The species pruned by a metric, from the finest detail to the coarsest."""
    mine = where(points, metric=metric, pruned=SPECIES)
    return sorted(mine, key=lambda p: p.case["detail"])


def excesses(point: Point) -> Reals:
    """Excess FLIP of every pair of seeds, (pairs,)."""
    return column(point, "flip") - column(point, "flip_floor")


def column(point: Point, quantity: str, **keys: Key) -> Reals:
    """A column of millionths, as numbers of its unit."""
    return point.values(quantity, **keys) / 1e6


def reached(points: Sequence[Point], draws: Drawn, error: float = EQUAL_ERROR) -> Crossings:
    """τ [px] and number of parts at which the excess comes up to an error, (draws, 2).

    ``draws`` (draws, pairs): the pairs of seeds that each is a mean over. Between two details along
    straight lines of their logarithms, no part counting as one; NaN where it is never there.
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
    """The first, with the percentiles of the others."""
    value, others = float(draws[0]), draws[1:]
    low, high = np.quantile(others, TWO_SIDED_TAILS)
    ends = min(float(low), value), max(float(high), value)
    return Estimate(value, *ends, float(others.std(ddof=1)), 1.0, len(draws))
