"""How many fields: as many as it takes for every mean to be known well enough, and no more."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bench.statistics.estimates import standard_error

Row = tuple[int, ...]


@dataclass(frozen=True)
class StoppingRule:
    """When there are enough fields of a case.

    target   relative standard error that every mean must get below
    least, most   fields of a case
    """

    target: float
    least: int
    most: int

    def planned(self, needed: int) -> int:
        """Fields to begin with where the law expects to need so many: a tenth more."""
        return min(self.most, max(self.least, math.ceil(1.1 * needed)))


def sample(draw: Callable[[int], Row], needed: int, judged: int, rule: StoppingRule) -> list[Row]:
    """Rows draw(0), draw(1), … until the first ``judged`` columns' means meet the target.

    Begins with what the law expects to be needed; adds fields where their own spread asks for it.
    """
    rows = [draw(index) for index in range(rule.planned(needed))]
    while len(rows) < rule.most:
        error = worst_error(rows, judged)
        if error < rule.target:
            break
        growth = min(4.0, 1.1 * (error / rule.target) ** 2)
        wanted = min(rule.most, math.ceil(len(rows) * growth) + 1)
        rows += [draw(index) for index in range(len(rows), wanted)]
    return rows


def worst_error(rows: list[Row], judged: int) -> float:
    """The largest relative standard error of the first ``judged`` columns."""
    columns = np.array(rows, np.float64).T[:judged]
    return max(standard_error(column) for column in columns)
