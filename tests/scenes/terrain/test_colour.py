"""What lies on the ground: where, and how bright."""

import numpy as np
import pytest

from lod.camera import Corner
from lod.errors import InputError
from scenes.terrain.colour import GROUND_MATERIALS, SNOW, ground_colours
from scenes.terrain.terrain import Terrain


def albedo(cover, rise, slope, n=4000):
    """Mean albedo of much ground of that height and slope, (3,)."""
    xy = np.random.default_rng(1).uniform(0, 5000, (n, 2))
    flat = np.full(n, rise), np.full(n, slope), np.full(n, 1.0)
    colours = ground_colours(4, Corner(0, 0), xy, *flat, GROUND_MATERIALS[cover])
    assert colours.min() >= 0 and colours.max() <= 1
    return colours.mean(axis=0)


def test_snow_lies_high_and_not_on_cliffs():
    below, above = albedo("snowy", -1.5, 0.1), albedo("snowy", 1.5, 0.1)
    cliff = albedo("snowy", 1.5, 2.0)
    assert above == pytest.approx(SNOW, abs=0.02)
    assert below.max() < 0.2 and cliff.max() < 0.25
    middle = albedo("snowy", GROUND_MATERIALS["snowy"].snow_line, 0.1)
    assert below[1] + 0.1 < middle[1] < above[1] - 0.1


def test_grass_is_green_and_stone_is_not():
    grass, stone = albedo("grassy", 0.0, 0.1), albedo("bare", 0.0, 0.1)
    assert grass[1] > grass[0] > grass[2]
    assert stone[0] > stone[1] > stone[2]
    steep = [albedo(name, 0.0, 1.5) for name in GROUND_MATERIALS]
    for name, colour in zip(GROUND_MATERIALS, steep, strict=True):
        assert colour == pytest.approx(GROUND_MATERIALS[name].steep, rel=0.05)


def test_an_unknown_cover_is_refused():
    with pytest.raises(InputError, match="grassy, bare, snowy"):
        Terrain(1, 10.0, 64.0, 0.8, 100.0, cover="lava")
