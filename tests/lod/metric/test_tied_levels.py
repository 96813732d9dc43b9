"""An only part drops in and out with its whole only where it is no smaller (§4.2)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.metric.family import METRICS, limit_distances
from lod.metric.tied_levels import max_over_tied, representative
from lod.stick_table import StickTable
from scenes.sticks.prototype import PartPlaces, assemble_prototype

HERE = np.zeros(3)


def chain(radii, owners=None):
    """Balls side by side along x, each the whole of the next unless said otherwise."""
    n = len(radii)
    whole = np.arange(n) - 1 if owners is None else np.array(owners)
    origin = np.outer(np.arange(n, dtype=float), (3.0, 0.0, 0.0))
    r = np.array(radii, float)
    balls = StickTable.of(n, np.arange(n), origin, origin, r, r, np.zeros(n, np.int64))
    none = StickTable.of(n, np.zeros(0), *(np.zeros((0, 3)),) * 2, *(np.zeros(0),) * 3)
    level = np.minimum(np.arange(n), 1)
    places = PartPlaces(whole, level, origin)
    return assemble_prototype("chain", places, none, balls, np.full((1, 3), 0.5)).hierarchy


@pytest.mark.parametrize("name", sorted(METRICS))
@pytest.mark.parametrize("m", [1e-3, 0.02, 0.3])
def test_an_only_part_no_smaller_than_its_whole_comes_and_goes_with_it(name, m):
    for radii in ((0.5, 0.5), (0.5, 0.9), (2.0, 0.4, 0.4, 0.7)):
        h = chain(radii)
        D = limit_distances(h, METRICS[name], m)
        assert D[-1] == D[-2] > 0
        assert np.array_equal(h.position[-1], h.position[-2])  # so that d is the same too


def test_an_only_part_that_is_smaller_goes_before_its_whole():
    h = chain((0.5, 0.49))
    assert np.array_equal(h.position[:, 0], (0, 3))
    D = limit_distances(h, METRICS["blake"], 0.01)
    assert D[1] < D[0]


def test_of_two_parts_none_is_one_with_its_whole():
    h = chain((0.5, 0.9, 0.9), owners=(-1, 0, 0))
    assert np.array_equal(h.position[:, 0], (0, 3, 6))


def test_one_that_grows_by_its_part_is_compared_as_such():
    """The last is larger than the first, and so what it is one with is one with the first."""
    assert representative(np.array([-1, 0, 1]), np.array([2.0, 1.0, 3.0])).tolist() == [0, 0, 0]
    assert representative(np.array([-1, 0, 1]), np.array([4.0, 1.0, 3.0])).tolist() == [0, 1, 1]
    assert max_over_tied(np.array([4.0, 1.0, 3.0]), np.array([0, 1, 1])).tolist() == [4.0, 3.0, 3.0]


trees = st.lists(st.tuples(st.integers(0, 9), st.integers(1, 5)), max_size=12)


@given(trees)
def test_in_any_tree_exactly_those_are_one(drawn):
    """Against the rule by itself, applied until nothing changes."""
    whole = np.array([-1] + [owner % (i + 1) for i, (owner, _) in enumerate(drawn)])
    P = np.array([3.0] + [float(size) for _, size in drawn])
    one, group = representative(whole, P), np.arange(len(P))
    for _ in P:
        for row in range(1, len(P)):
            above, alone = whole[row], np.count_nonzero(whole == whole[row]) == 1
            if alone and P[group == group[row]].max() >= P[group == group[above]].max():
                group[group == group[row]] = group[above]
    assert one.tolist() == group.tolist()
