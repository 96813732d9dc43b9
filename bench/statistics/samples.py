"""How many fields does a case need, for every mean to be known well enough?"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from bench.statistics.estimates import standard_error

Row = tuple[int, ...]


@dataclass(frozen=True)
class StoppingRule:
    """The rule that says when a case has enough fields.

    target       relative standard error that every mean must get below
    least, most  the fewest and the most fields of a case
    """

    target: float
    least: int
    most: int

    def planned(self, needed: int) -> int:
        """Return how many fields to begin with: a tenth more than the law expects to be needed."""
        return min(self.most, max(self.least, math.ceil(1.1 * needed)))


def sample(draw: Callable[[int], Row], needed: int, judged: int, rule: StoppingRule) -> list[Row]:
    """Draw the rows of fields 0, 1, … until the means of the first ``judged`` columns are known.

    The sample begins with as many fields as the law expects to be needed, and grows while their
    own spread is too large for the target.
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
    """Return the largest relative standard error of the means of the first ``judged`` columns."""
    columns = np.array(rows, np.float64).T[:judged]
    return max(standard_error(column) for column in columns)
