"""The finest detail at which a frame holds no more parts than a budget allows.

After Funkhouser & Séquin, "Adaptive display algorithm for interactive frame rates" (SIGGRAPH '93):
the cost is given, and the detail follows. By the law of §4.1 the number of parts falls about as
τ⁻²: a few prunes find τ.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from lod.errors import InputError

MIN_BUDGET_USE = 0.98
"""Share of the budget that has to be used before the search ends."""

MAX_PRUNES = 12
"""Number of prunes after which the best detail so far is returned."""

_MAX_FACTOR = 2.0**20
"""Largest factor, up or down, between the first detail and any other that is tried."""

_COARSEST_STEP = 1.01
"""Ratio of details at which the search for the coarsest that shows everything ends."""

_STEP = 1e-6
"""Relative difference of details at which the search ends: no part changes in between."""


@dataclass(frozen=True)
class BudgetFit:
    """A detail τ [px], the number of parts displayed at it, and the prunes that found it."""

    detail: float
    parts: int
    prunes: int


def find_detail(parts_at: Callable[[float], int], most: int, start: float) -> BudgetFit:
    """Find the detail τ [px] at which at most ``most`` parts are displayed, and nearly as many.

    At least MIN_BUDGET_USE of the budget is used. parts_at(τ) must not grow with τ; where it jumps
    past the budget, the side of the jump below the budget is returned; where even the finest detail
    has fewer, the coarsest one that has as many. Raises InputError where even the coarsest detail
    has too many.
    """
    low, high, fit = start / _MAX_FACTOR, start * _MAX_FACTOR, None
    above: tuple[float, int] | None = None
    detail = start
    for prunes in range(1, MAX_PRUNES + 1):
        parts = parts_at(detail)
        if parts <= most:
            high, fit = detail, BudgetFit(detail, parts, prunes)
            if parts >= MIN_BUDGET_USE * most:
                return fit
        else:
            low, above = detail, (detail, parts)
        if high / low < 1 + _STEP or detail in (start / _MAX_FACTOR, start * _MAX_FACTOR):
            break
        detail = _next(detail, parts, most, (low, high), (above, fit), prunes)
    if fit is None:
        rule = f"{parts:,} parts are displayed even at {detail:.6g} px"
        raise InputError("--max-parts", most, rule, "allow more")
    if above is None:
        return _coarsest_of_all(parts_at, fit, start, prunes)
    return BudgetFit(fit.detail, fit.parts, prunes)


def _coarsest_of_all(
    parts_at: Callable[[float], int], finest: BudgetFit, start: float, prunes: int
) -> BudgetFit:
    """The coarsest detail, to a hundredth, that displays as many parts as the finest one does."""
    low, high = finest.detail, max(start, finest.detail)
    while high / low > _COARSEST_STEP:
        middle = math.sqrt(low * high)
        prunes += 1
        low, high = (middle, high) if parts_at(middle) == finest.parts else (low, middle)
    return BudgetFit(low, finest.parts, prunes)


def _next(
    detail: float,
    parts: int,
    most: int,
    bracket: tuple[float, float],
    known: tuple[tuple[float, int] | None, BudgetFit | None],
    prunes: int,
) -> float:
    """Next detail to try: a power law through the known counts, aimed just below the budget."""
    (low, high), (above, below) = bracket, known
    aim = math.log((1 + MIN_BUDGET_USE) / 2 * most)
    if above is None or below is None:
        # By the law, and ever farther where that is not enough.
        step = 0.5 * (math.log(max(parts, 1)) - aim) * 2.0 ** (prunes - 1)
        step = math.copysign(max(abs(step), 0.02 * 4.0 ** (prunes - 1)), step)
        return min(max(detail * math.exp(min(max(step, -14), 14)), low), high)
    # Secant in logarithms, kept off the ends of the bracket; now and then its middle.
    share = 0.5
    if prunes % 3 and below.parts:
        rise = math.log(above[1]) - math.log(below.parts)
        share = min(max((math.log(above[1]) - aim) / rise, 0.02), 0.98)
    return low * (high / low) ** share
