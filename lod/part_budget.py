"""The finest detail at which a frame holds no more parts than a budget allows.

After Funkhouser & Séquin, "Adaptive display algorithm for interactive frame rates" (SIGGRAPH '93):
the cost is given, and the detail follows. By the law of §4.1 the number of parts falls about as
τ⁻²: a few prunes find τ.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

from lod.errors import InputError

MIN_BUDGET_USE = 0.98
"""Share of the budget that has to be used before the search ends."""

MAX_PRUNES = 12
"""Number of prunes after which the best detail so far is returned."""

_MAX_FACTOR = 2.0**20
"""Largest factor, up or down, between the first detail and any other that is tried."""


class BudgetFit(NamedTuple):
    """A detail τ [px], the number of parts displayed at it, and the prunes that found it."""

    detail: float
    parts: int
    prunes: int


def find_detail(
    parts_at: Callable[[float], int], most: int, start: float, where: str = "budget"
) -> BudgetFit:
    """Find the detail τ [px] at which at most ``most`` parts are displayed, and nearly as many.

    At least MIN_BUDGET_USE of the budget is used. parts_at(τ) must not grow with τ; where it jumps
    past the budget, the side of the jump below the budget is returned; where even the finest detail
    has fewer, the coarsest one that has as many. ``where`` is what errors call the budget. Raises
    InputError where even the coarsest detail has too many.
    """
    least, greatest = start / _MAX_FACTOR, start * _MAX_FACTOR
    low, high, detail = least, greatest, start
    fit: BudgetFit | None = None
    parts_above: int | None = None
    aim = math.log((1 + MIN_BUDGET_USE) / 2 * most)  # just below the budget
    for prunes in range(1, MAX_PRUNES + 1):
        parts = parts_at(detail)
        if parts <= most:
            high, fit = detail, BudgetFit(detail, parts, prunes)
            if parts >= MIN_BUDGET_USE * most:
                return fit
        else:
            low, parts_above = detail, parts
        # No part changes between details as close as this.
        if high / low < 1 + 1e-6 or detail in (least, greatest):
            break
        if parts_above is None or fit is None:
            # By the law, and ever farther where that is not enough.
            step = 0.5 * (math.log(max(parts, 1)) - aim) * 2.0 ** (prunes - 1)
            step = math.copysign(max(abs(step), 0.02 * 4.0 ** (prunes - 1)), step)
            detail = min(max(detail * math.exp(min(max(step, -14), 14)), low), high)
        else:
            # Secant in logarithms, kept off the ends of the bracket; now and then its middle.
            share = 0.5
            if prunes % 3 and fit.parts:
                rise = math.log(parts_above) - math.log(fit.parts)
                share = min(max((math.log(parts_above) - aim) / rise, 0.02), 0.98)
            detail = low * (high / low) ** share
    if fit is None:
        rule = f"{parts:,} parts are displayed even at {detail:.6g} px"
        raise InputError(where, most, rule, "allow more")
    if parts_above is not None:
        return BudgetFit(fit.detail, fit.parts, prunes)
    # There are not as many parts: the coarsest detail, to a hundredth, that displays them all.
    low, high = fit.detail, max(start, fit.detail)
    while high / low > 1.01:
        middle = math.sqrt(low * high)
        prunes += 1
        low, high = (middle, high) if parts_at(middle) == fit.parts else (low, middle)
    return BudgetFit(low, fit.parts, prunes)
