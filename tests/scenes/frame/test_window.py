"""Windows of a picture: which pixels of a run are in them, and how a preset writes them."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from scenes.frame.frame_input import Window, whole_window
from scenes.presets.load import load_preset
from scenes.presets.values import parse_crop


@st.composite
def windows(draw):
    width, height = draw(st.integers(1, 12)), draw(st.integers(1, 9))
    left, top = draw(st.integers(0, width - 1)), draw(st.integers(0, height - 1))
    window = Window(
        left, top, draw(st.integers(left + 1, width)), draw(st.integers(top + 1, height))
    )
    return (width, height), window


@given(windows(), st.integers(1, 40))
def test_runs_of_a_picture_fill_a_window_once_and_in_order(given, step):
    (width, height), window = given
    picture = np.arange(width * height)
    own = np.full(window.size[0] * window.size[1], -1)
    for first in range(0, width * height, step):
        pixels = slice(first, min(first + step, width * height))
        inside, at = window.share(pixels, width)
        assert (own[at] == -1).all()
        own[at] = picture[pixels][inside]
    expected = picture.reshape(height, width)
    expected = expected[window.top : window.bottom, window.left : window.right]
    np.testing.assert_array_equal(own, expected.ravel())
    assert window.is_all_of((width, height)) == (window == whole_window((width, height)))


@pytest.mark.parametrize(
    ("text", "edges"),
    [
        ("32x18+16+9", (16, 9, 48, 27)),
        ("50%x50%+25%+25%", (16, 9, 48, 27)),
        ("33.3%x100%+0+0", (0, 0, 21, 36)),
        (" 1 x 1+63+35", (63, 35, 64, 36)),
        ("100%x100%+0%+0", (0, 0, 64, 36)),
    ],
)
def test_crops_as_they_are_written(text, edges):
    assert parse_crop(text, (64, 36)) == edges
    assert (
        load_preset("meadow", ["render.size=64x36", f"render.crop={text}"]).render.window == edges
    )


@pytest.mark.parametrize(
    "text", ["32x18", "32x18+40+9", "0x18+0+0", "32.5x18+0+0", "32x18-1+0", "0.1%x1+0+0", "all"]
)
def test_a_crop_that_is_no_window_is_refused_in_one_line(text):
    with pytest.raises(InputError, match=r"render\.crop") as caught:
        load_preset("meadow", ["render.size=64x36", f"render.crop={text}"])
    assert "\n" not in str(caught.value)
