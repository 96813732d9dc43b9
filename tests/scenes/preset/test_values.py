"""Lengths carry their unit; sizes are whole and positive."""

import pytest

from lod.errors import InputError
from scenes.presets.values import parse_height, parse_length, parse_size


@pytest.mark.parametrize(
    ("text", "metres"),
    [("20km", 20_000.0), ("500 m", 500.0), (" 1.5km ", 1500.0), (".5m", 0.5), ("1e3km", 1e6)],
)
def test_a_length_is_in_metres(text: str, metres: float) -> None:
    assert parse_length(text) == metres


@pytest.mark.parametrize(("text", "metres"), [("-3m", -3.0), ("0m", 0.0), ("1.2km", 1200.0)])
def test_a_height_may_be_below(text: str, metres: float) -> None:
    assert parse_height(text) == metres


@pytest.mark.parametrize(
    "text",
    [
        "20",
        20,
        20.0,
        "km",
        "",
        "-3km",
        "0m",
        "3 miles",
        "3KM",
        "1e400km",
        "nan m",
        "inf km",
        "1 2m",
        "١km",
        None,
        "3km 4m",
        "--3km",
    ],
)
def test_what_is_no_length_is_refused_with_the_units(text: object) -> None:
    with pytest.raises(InputError, match="km") as caught:
        parse_length(text, "--visibility")
    assert caught.value.where == "--visibility"
    assert caught.value.arrived == text


@pytest.mark.parametrize("text", ["0", "0km", "-3", "-0.0 m"])
def test_what_is_not_above_0_is_not_cured_by_a_unit(text: str) -> None:
    with pytest.raises(InputError, match=r"above 0.*20km"):
        parse_length(text, "--visibility")


@pytest.mark.parametrize(
    ("text", "size"), [("640x360", (640, 360)), (" 1 x 1 ", (1, 1)), ("16384x2", (16384, 2))]
)
def test_a_size_is_width_and_height(text: str, size: tuple[int, int]) -> None:
    assert parse_size(text) == size


@pytest.mark.parametrize(
    "text",
    [
        "0x0",
        "0x5",
        "5x0",
        "640",
        "640x",
        "x360",
        "-1x3",
        "1.5x2",
        "16385x1",
        "1x1x1",
        "9" * 5000 + "x1",
    ],
)
def test_what_is_no_size_is_refused(text: str) -> None:
    with pytest.raises(InputError, match="640x360"):
        parse_size(text, "--size")
