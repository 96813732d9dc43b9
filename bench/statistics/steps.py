"""Where does a series of measurements step from one level to another?"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals

LEAST_BESIDE = 3
"""The fewest measurements on either side of a step."""

LEVEL = 0.01
PERMUTATIONS = 1999


@dataclass(frozen=True)
class Step:
    """The first row after a step, and the mean after it less that before."""

    row: int
    height: float


def find_step(values: Reals) -> Step | None:
    """Find the one step of a series, (n,); None where chance explains its largest as well.

    The statistic is the largest over all splits of Student's t between both sides; its null
    distribution is that of the same values in ``PERMUTATIONS`` random orders, so that no
    distribution is assumed but that the order does not matter (a permutation test of a change
    point, Antoch and Hušková 2001). A step is found where p ≤ ``LEVEL``; fewer than 3 values on
    either side are no level.
    """
    n = len(values)
    if n < 2 * LEAST_BESIDE:
        return None
    splits = np.arange(LEAST_BESIDE, n - LEAST_BESIDE + 1)
    rng = np.random.default_rng(0)
    orders = np.stack([values, *(rng.permutation(values) for _ in range(PERMUTATIONS))])
    sums = np.cumsum(orders, axis=1)[:, splits - 1]
    left, right = sums / splits, (values.sum() - sums) / (n - splits)
    inside = (values**2).sum() - splits * left**2 - (n - splits) * right**2
    spread = np.sqrt(np.maximum(inside, 1e-300) / (n - 2) * (1 / splits + 1 / (n - splits)))
    most = np.max(np.abs(right - left) / spread, axis=1)
    if (most >= most[0] * (1 - 1e-12)).mean() > LEVEL:
        return None
    at = int(np.argmax(np.abs(right - left)[0] / spread[0]))
    return Step(int(splits[at]), float(right[0, at] - left[0, at]))
