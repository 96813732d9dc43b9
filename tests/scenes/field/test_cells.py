"""."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from scenes.field.cells import PoissonCells

DENSITIES = st.floats(1e-8, 100.0)


def square(side, x=0, y=0):
    """A block of side × side cells."""
    grid = np.meshgrid(np.arange(x, x + side), np.arange(y, y + side), indexing="ij")
    return tuple(axis.ravel() for axis in grid)


@given(DENSITIES)
def test_a_cell_holds_a_few_objects(density):
    cells = PoissonCells(0, "figure", density)
    assert 0.9 <= density * cells.side_m**2 <= 4.1 or cells.exponent == -3


@given(density=DENSITIES, x=st.integers(-(2**50), 2**50), seed=st.integers(0, 2**63 - 1))
def test_a_cell_always_holds_the_same_objects(density, x, seed):
    cells = PoissonCells(seed, "tree", density)
    block = cells.sample(*square(4, x))
    one = cells.sample(np.array([x + 1]), np.array([2]))
    rows = (block.cell_x == x + 1) & (block.cell_y == 2)
    assert block.u[rows].tolist() == one.u.tolist()


@pytest.mark.parametrize("density", [0.0007, 0.3])
def test_counts_are_poisson_and_places_uniform(density):
    cells = PoissonCells(11, "figure", density)
    x, y = square(200, -100, 5)
    samples = cells.sample(x, y)
    mean = density * cells.side_m**2
    count = np.bincount(samples.cell_x * 200 + samples.cell_y - samples.cell_y.min() + 100 * 200)
    observed = np.bincount(count, minlength=30)[:30].astype(float)
    observed[0] += len(x) - len(count)
    model = stats.poisson.pmf(np.arange(30), mean) * len(x)
    keep = model > 5
    assert (
        stats.chisquare(
            observed[keep], model[keep] * observed[keep].sum() / model[keep].sum()
        ).pvalue
        > 1e-3
    )
    assert len(samples) == pytest.approx(mean * len(x), abs=4 * np.sqrt(mean * len(x)))
    for column in samples.u.T:
        assert stats.kstest(column, "uniform").pvalue > 1e-3
    assert np.abs(np.corrcoef(samples.u.T) - np.eye(8)).max() < 0.02
