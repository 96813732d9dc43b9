"""A detail that fits a budget: never over it, nearly all of it used, in a few prunes."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from scenes.render.budget import MAX_PRUNES, MIN_BUDGET_USE, find_detail


@given(
    away=st.floats(-1.5, 1.5),
    power=st.floats(1.2, 2.5),
    most=st.integers(1000, 10**7),
    start=st.floats(0.05, 50),
)
def test_a_power_law_is_met_in_a_few_prunes(away, power, most, start):
    """The detail looked for is up to 30 times finer or coarser than the first."""

    def parts_at(detail: float) -> int:
        return int(most * (start * 10**away / detail) ** power)

    fit = find_detail(parts_at, most, start)
    assert MIN_BUDGET_USE * most <= fit.parts <= most
    assert fit.parts == parts_at(fit.detail)
    assert fit.prunes <= 8


@given(most=st.integers(10, 990), start=st.floats(0.1, 10))
def test_where_parts_come_all_at_once_the_near_side_of_the_step_is_taken(most, start):
    """A thousand parts up to 1 px, ten beyond it: all that fits is ten."""
    fit = find_detail(lambda tau: 1000 if tau < 1 else 10, most, start)
    assert fit.parts == 10 and fit.detail >= 1 and fit.prunes <= MAX_PRUNES


def test_what_cannot_fit_is_refused():
    with pytest.raises(InputError, match="--max-parts: 6"):
        find_detail(lambda tau: 7, 6, 1.0)


def test_few_parts_at_any_detail_fit():
    fit = find_detail(lambda tau: 7, 100, 1.0)
    assert fit.parts == 7 and math.isfinite(fit.detail)
