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
    flat = np.full(n, rise), np.full(n, slope), np.zeros(n), np.full(n, 1.0)
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


@pytest.mark.parametrize("cover", list(GROUND_MATERIALS))
@pytest.mark.parametrize("spread", [0.1, 0.3, 0.5])
@pytest.mark.parametrize("slope", [0.0, 0.5, 1.0])
def test_hidden_slopes_leave_the_mean_of_their_albedo(cover, spread, slope):
    """Against 4000 sampled facets, on high ground, where snow slides off the steep ones."""
    random = np.random.default_rng(5)
    n, rise = 4000, 1.5
    xy = random.uniform(0, 5000, (n, 2))
    steep = np.hypot(*(random.normal(0, spread, (2, n)) + np.array([[slope], [0.0]])))
    same = 4, Corner(0, 0), xy, np.full(n, rise)
    coarse, materials = np.full(n, 4096.0), GROUND_MATERIALS[cover]
    facets = ground_colours(*same, steep, np.zeros(n), coarse, materials).mean(axis=0)
    found = ground_colours(*same, np.full(n, slope), np.full(n, spread**2), coarse, materials).mean(
        axis=0
    )
    assert found == pytest.approx(facets, abs=0.025)


def test_small_patches_leave_the_mean_of_their_albedo():
    xy = np.random.default_rng(1).uniform(0, 40_000, (40_000, 2))
    one = np.ones(len(xy))
    same = 4, Corner(0, 0), xy, -0.2 * one, 0.4 * one, 0 * one
    for cover, materials in GROUND_MATERIALS.items():
        fine = ground_colours(*same, 0.125 * one, materials)
        coarse = ground_colours(*same, 4096.0 * one, materials)
        assert coarse.mean(axis=0) == pytest.approx(fine.mean(axis=0), abs=0.03), cover


def test_an_unknown_cover_is_refused():
    with pytest.raises(InputError, match="grassy, bare, snowy"):
        Terrain(1, 10.0, 64.0, 0.8, 100.0, cover="lava")
