from dataclasses import dataclass

import numpy as np
import pytest

from lod.arrays import check_columns
from lod.errors import InputError


@dataclass(frozen=True)
class Columns:
    place: np.ndarray
    row: np.ndarray


def columns(place, row=(0, 1)):
    return Columns(np.array(place, np.float64), np.array(row))


def test_columns_of_the_right_shapes_pass():
    check_columns("object", columns([[0, 1, 2], [3, 4, 5]]), place=(2, 3), row=(2,))


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (columns([[0, 1], [3, 4]]), r"object\.place: \(2, 2\): its shape is \(2, 3\)"),
        (columns([[0, 1, 2], [3, np.nan, 5]]), r"object\.place\[1\]: nan: every number is finite"),
        (columns([[0, 1, 2], [3, 4, 5]], [1]), r"object\.row: \(1,\): its shape is \(2,\)"),
    ],
)
def test_the_first_wrong_column_is_named(data, named):
    with pytest.raises(InputError, match=named):
        check_columns("object", data, place=(2, 3), row=(2,))
