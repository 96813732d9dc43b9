"""An error says what arrived; of something long, both ends."""

from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

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


@given(st.text(st.characters(codec="ascii", exclude_characters="\\\n'"), max_size=300))
def test_what_arrived_is_told_in_at_most_eighty_characters(text: str) -> None:
    message = str(InputError("KEY", text, "a rule", "a cure"))
    assert message.startswith("KEY: ") and message.endswith(": a rule; a cure")
    told = message.removeprefix("KEY: ").removesuffix(": a rule; a cure")
    assert len(told) <= 80
    assert told == repr(text) or (told[:39], told[-40:]) == (repr(text)[:39], repr(text)[-40:])


def test_a_long_path_keeps_the_name_of_its_file() -> None:
    path = f"/{'a' * 200}/claims.csv"
    assert "/claims.csv'" in str(InputError("DIR", path, "a rule"))
