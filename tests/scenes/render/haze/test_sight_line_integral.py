"""Light gathered along lines of sight over ground of any height, and that ground."""

import numpy as np
import pytest

from lod.air import Air, Mist
from lod.plane_parallel import RINGS, SPOKES, directions
from scenes.render.haze.ground_profile import DISTANCES_M, ground_profile, heights_at
from scenes.render.haze.sight_line_integral import Lines, Sources, gather

NM = np.array((650.0, 550.0))
HAZE = Air(2000.0)


def even(profile_m):
    return lambda distance: np.full((len(distance), SPOKES), profile_m)


def sources_of(source, ground=(0.0,)):
    """J = source(height of the ground, height above it)."""
    height = np.linspace(0.0, 50.0, 6)
    values = [[np.full((RINGS, SPOKES, 2), source(g, h)) for h in height] for g in ground]
    above = np.repeat(height[None], len(ground), axis=0)
    return Sources(np.array(ground), above, np.array(values))


def test_where_the_source_is_one_an_endless_path_has_it_whole():
    ends = np.array([[10.0], [100.0], [1e6]])
    lines = Lines(2.0, np.array((0.0,)), even(0.0))
    found = gather(sources_of(lambda g, h: 3.0), lines, HAZE, NM, ends)
    assert np.allclose(found.source, 3.0)
    assert np.allclose(found.light[:, 0], 3 * (1 - np.exp(-found.depth))[:, 0, None])
    assert found.depth[1, 0, 1] == pytest.approx(100 * 3.912 / 2000, rel=1e-3)


@pytest.mark.parametrize("air", [HAZE, Air(2000.0, Mist(300.0, 5.0, 10.0))])
def test_the_sum_over_steps_is_the_integral(air):
    """A line that rises over ground that falls, and a source that grows with both."""
    sources = sources_of(lambda g, h: 1.0 + 0.02 * g + 0.05 * h, (-40.0, 0.0))
    fall = Lines(2.0, np.array((0.01,)), lambda d: np.full((1, SPOKES), -0.05) * d[:, None])
    few = gather(sources, fall, air, NM, np.geomspace(2, 400, 20)[:, None])
    many = gather(sources, fall, air, NM, np.linspace(0, 400, 401)[1:, None])
    assert np.allclose(few.source[-1], many.source[-1], rtol=2e-3)
    t = np.linspace(0, 400, 4001)
    j = 1.0 + 0.02 * np.maximum(-0.05 * t, -40) + 0.05 * (2 + 0.06 * t)
    if air == HAZE:
        weight = np.exp(-3.912 / 2000 * t)
        expected = (weight * j).sum() / weight.sum()
        assert few.source[-1, 0, 0, 1] == pytest.approx(expected, rel=2e-3)


def test_sources_are_taken_in_their_own_direction():
    source = sources_of(lambda g, h: 0.0)
    bright = np.zeros(source.source.shape)
    toward = np.array((0.6, 0.0, 0.8))
    bright[..., 0] = np.exp(20 * (directions() @ toward - 1))
    up = np.array((-0.8, 0.0, 0.8))
    lines = Lines(2.0, up, even(0.0))
    found = gather(Sources(source.ground, source.height, bright), lines, HAZE, NM, np.ones((1, 3)))
    row, spoke = np.unravel_index(found.source[0, :, :, 0].argmax(), (3, SPOKES))
    assert (row, spoke) == (2, SPOKES // 4)
    assert found.source[0, 2, SPOKES // 4, 0] == pytest.approx(1.0, abs=0.02)


def test_the_profile_of_a_slope_is_the_slope():
    """Rising to the east by 1 in 10 and falling to the west."""
    rng = np.random.default_rng(1)
    xy = rng.uniform(-3000, 3000, (200_000, 2))
    points = np.column_stack((xy, 0.1 * xy[:, 0]))
    profile = ground_profile(points, np.array((100.0, 50.0, 20.0)))
    found = heights_at(profile, np.array((0.0, 40.0, 400.0, 2000.0)))
    east = SPOKES // 4
    expected = 10 + 0.1 * np.array((0.0, 40.0, 400.0, 2000.0))
    assert np.allclose(found[:, east], expected, rtol=0.1, atol=2.0)
    assert np.allclose(found[:, 0], 10.0, atol=2.0)
    assert np.allclose(found[:, 3 * east], 20 - expected, rtol=0.1, atol=4.0)
    assert profile.shape == (SPOKES, len(DISTANCES_M))
