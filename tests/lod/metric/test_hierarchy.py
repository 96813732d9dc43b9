import numpy as np
import pytest

from lod.errors import InputError
from lod.metric.hierarchy import Hierarchy


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


def test_depth_and_parts():
    tree = chain(parent=[-1, 0, 0], level=[0, 1, 1])
    assert tree.depth.tolist() == [0, 1, 1]
    assert tree.part_count.tolist() == [2, 0, 0]
    assert tree.order[tree.first_part[0] :][:2].tolist() == [1, 2]


def test_arrays_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        chain().P[0] = 1.0


def test_scaling_scales_every_length():
    tree = chain().scaled(3.0)
    assert tree.P.tolist() == [6.0, 3.0, 1.5]
    assert tree.position[2, 0] == 6.0


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"P": [2.0, 0.0, 0.5]}, r"P\[1\]"),
        ({"P": [2.0, np.nan, 0.5]}, r"P\[1\]"),
        ({"R": [2.5, -1.0, 0.5]}, r"R\[1\]"),
        ({"R": [2.5, np.inf, 0.5]}, r"R\[1\]"),
        ({"position": [[0, 0, 0], [np.nan, 0, 0], [2, 0, 0]]}, r"position\[1\]"),
        ({"parent": [-1, 2, 1]}, r"parent\[1\]"),
        ({"parent": [-1, -1, 1]}, r"parent\[1\]"),
        ({"parent": [0, 0, 1]}, r"parent\[0\]"),
        ({"level": [0, 2, 1]}, r"level\[2\]"),
        ({"level": [1, 2, 2]}, r"level\[0\]"),
        ({"B": [2.0, 1.5, 0.5]}, r"B\[0\]"),
        ({"P": [2.0, 1.0]}, r"hierarchy\.P"),
        ({"overlap": [0.0, 1.0, 0.0]}, r"hierarchy\.overlap"),
        ({"overlap": [0.0, -np.inf, 0.0]}, r"hierarchy\.overlap"),
    ],
)
def test_what_is_not_a_tree_of_sizes_is_refused(changes, named):
    with pytest.raises(InputError, match=named):
        chain(**changes)


def test_an_object_has_at_least_itself():
    empty = {k: [] for k in ("parent", "level", "P", "R", "B", "separation")}
    with pytest.raises(InputError, match="at least one part"):
        chain(**empty, position=np.zeros((0, 3)))
