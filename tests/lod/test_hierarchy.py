"""Hierarchies are trees of sizes; an only part that is no smaller goes with its whole (§4.2)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from lod.hierarchy import Hierarchy, representative
from lod.metric import METRICS, limit_distances
from lod.shapes import StickTable
from scenes.sticks.prototype import PartPlaces, assemble_prototype


def chain(**changes):
    """A whole, its part, and the part's part, each 1 m along x."""
    fields = {
        "parent": [-1, 0, 1],
        "level": [0, 1, 2],
        "position": [[0, 0, 0], [1, 0, 0], [2, 0, 0]],
        "P": [2.0, 1.0, 0.5],
        "R": [2.5, 1.5, 0.5],
        "B": [2.5, 1.5, 0.5],
        "separation": [0.0, 1.0, 1.0],
    }
    return Hierarchy(**{k: np.array(v) for k, v in (fields | changes).items()})


def test_arrays_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        chain().P[0] = 1.0


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"P": [2.0, 0.0, 0.5]}, r"P\[1\]"),
        ({"R": [2.5, -1.0, 0.5]}, r"R\[1\]"),
        ({"parent": [-1, 2, 1]}, r"parent\[1\]"),
        ({"parent": [0, 0, 1]}, r"parent\[0\]"),
        ({"level": [0, 2, 1]}, r"level\[2\]"),
        ({"B": [2.0, 1.5, 0.5]}, r"B\[0\]"),
        ({"P": [2.0, 1.0]}, r"hierarchy\.P"),
        ({"contrast_to_whole": [1.0, 0.0, 1.0]}, r"hierarchy\.contrast_to_whole"),
        ({"contrast_to_whole": [1.0, 1.5, 1.0]}, r"hierarchy\.contrast_to_whole"),
        ({"overlap": [0.0, 1.0, 0.0]}, r"hierarchy\.overlap"),
    ],
)
def test_what_is_not_a_tree_of_sizes_is_refused(changes, named):
    with pytest.raises(InputError, match=named):
        chain(**changes)


def test_an_object_has_at_least_itself():
    empty = {k: [] for k in ("parent", "level", "P", "R", "B", "separation")}
    with pytest.raises(InputError, match="at least one part"):
        chain(**empty, position=np.zeros((0, 3)))


def balls_along_x(radii, owners=None):
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
        h = balls_along_x(radii)
        D = limit_distances(h, METRICS[name], m)
        assert D[-1] == D[-2] > 0
        assert np.array_equal(h.position[-1], h.position[-2])  # so that d is the same too


def test_an_only_part_that_is_smaller_goes_before_its_whole():
    h = balls_along_x((0.5, 0.49))
    assert np.array_equal(h.position[:, 0], (0, 3))
    D = limit_distances(h, METRICS["blake"], 0.01)
    assert D[1] < D[0]


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
