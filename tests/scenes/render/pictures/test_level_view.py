"""Previews by detail level: who is what colour."""

import numpy as np
import pytest

from lod.errors import InputError
from scenes.frame.layers import Layers
from scenes.render.pictures.level_view import (
    LEVELS,
    SKY,
    level_colours,
    level_pixels,
    preview_pixels,
)
from scenes.render.pictures.tone_map import PictureStyle


def frame(width=400, height=200):
    """Sky above, then levels 0 to 15 in columns, all of them facing up."""
    shape = height, width
    level = np.broadcast_to(np.arange(width) * 16 // width, shape)
    normal = np.broadcast_to(np.array((0.0, 0.0, 1.0)), (*shape, 3))
    met = np.broadcast_to(np.arange(height)[:, None] >= 50, shape)
    grey, depth = np.full((*shape, 3), 0.2), np.full(shape, 5.0)
    level = np.where(met, level, 0)
    return Layers(grey, depth, normal, grey, met.astype(int), level, level)


def test_every_level_has_its_colour_and_the_sky_its_own():
    picture = level_pixels(frame())
    assert np.all(picture[:50] == SKY)
    row = picture[100]
    seen = [row[int((level + 0.5) * 400 / 16)] for level in range(16)]
    distinct = np.unique(np.array(seen), axis=0)
    assert len(distinct) == LEVELS
    for level, colour in enumerate(seen):
        ratio = colour.sum() / level_colours()[min(level, LEVELS - 1)].sum()
        assert ratio == pytest.approx(0.7 + 0.3 * 0.7 / np.sqrt(1.01), abs=0.05)


def test_colours_grow_lighter_with_detail():
    luminance = level_colours() @ (0.2126, 0.7152, 0.0722)
    assert np.all(np.diff(luminance) > 5)


def test_the_legend_is_there_where_there_is_room():
    large, small = level_pixels(frame()), level_pixels(frame(60, 200))
    assert np.all(large[-1, :] == large[-1, 0]), "a strip of paper"
    assert not np.all(small[-1, :] == small[-1, 0])


def test_the_look_chooses():
    layers = frame()
    assert np.array_equal(
        preview_pixels(layers, PictureStyle(view="level"), 1.0), level_pixels(layers)
    )
    assert not np.array_equal(preview_pixels(layers, PictureStyle(), 1.0), level_pixels(layers))
    with pytest.raises(InputError, match="colour, level"):
        PictureStyle(view="depth")
