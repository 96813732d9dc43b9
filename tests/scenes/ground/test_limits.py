"""P, R and limit distances of the ground's tiles: what of a bump the eye sees decides."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.metric import METRICS
from scenes.ground.mesh import Terrain
from scenes.ground.quadtree import UNLIT, priorities, ranges, seen_tilt
from tests.scenes.ground.grounds import HILLS, view_of

RIDGES = Terrain(9, 190.0, 4096.0, 0.95, reach=6000.0, ridged=True)


def at_tilt(terrain: Terrain, tilt: float) -> np.ndarray:
    return priorities(terrain.relief, terrain.spacings, np.full(len(terrain.spacings), tilt))


def test_seen_edge_on_a_bump_is_as_large_as_it_is_wide_and_high():
    P, spacing = at_tilt(HILLS, 0.0), HILLS.spacings[3]
    octave = HILLS.relief.wavelengths == 2 * spacing
    assert P[3] == pytest.approx(np.sqrt(spacing * HILLS.relief.rms[octave][0]))
    assert np.all(np.diff(P) < 0)
    assert np.all(np.diff(ranges(HILLS.relief, HILLS.spacings)) < 0)


def test_seen_from_above_a_bump_is_the_mean_of_half_a_wave_each_way():
    """Numerical mean of sin·sin over half a period of each: what its shade covers in full."""
    x = (np.arange(1000) + 0.5) / 1000 * np.pi
    mean = np.outer(np.sin(x), np.sin(x)).mean()
    more = at_tilt(HILLS, 1.0) ** 2 - at_tilt(HILLS, 0.0) ** 2
    assert more == pytest.approx(mean * HILLS.spacings**2, rel=1e-5)


def test_crests_of_ridged_relief_are_larger_bumps_than_its_rms():
    smooth, ridged = (Terrain(7, 8.0, 256.0, 0.8, 400.0, ridged=r) for r in (False, True))
    P, P_ridged = at_tilt(smooth, 0.0), at_tilt(ridged, 0.0)
    np.testing.assert_allclose((P_ridged / P) ** 2, 0.5128 / 0.3578)
    R, R_ridged = (ranges(each.relief, each.spacings) for each in (smooth, ridged))
    np.testing.assert_array_equal(R, R_ridged)


@pytest.mark.parametrize("terrain", [HILLS, RIDGES])
@pytest.mark.parametrize("elevation", [0.0, 0.1, 0.5])
def test_the_tilt_of_seen_ground_is_that_of_sampled_facets(terrain, elevation):
    """Facets of the map weigh by the area that they show, which is also what is averaged."""
    spacings = terrain.spacings[-3:]
    found = seen_tilt(terrain.relief, spacings, np.full(3, elevation))
    variance = terrain.relief.slope_variances.sum()
    drawn = variance - terrain.relief.left_out_slope_variance(4 * spacings)
    for sigma, tilt in zip(np.sqrt(drawn), found, strict=True):
        towards = np.random.default_rng(1).normal(0.0, sigma, 400_000)
        shown = np.maximum(elevation + towards, 0.0)
        assert tilt == pytest.approx(min((shown**2).sum() / shown.sum(), 1.0), rel=0.01)


@pytest.mark.parametrize("above", [1.7, 300.0])
@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle"])
def test_limits_are_the_metrics_own_of_p_and_r(metric, above):
    view = view_of(HILLS, metric=metric, above=above)
    R, limit = ranges(HILLS.relief, HILLS.spacings), METRICS[metric].limit
    inside, *unseen = HILLS.limits(view)
    finer, *out_of_view = replace(HILLS, detail=0.5).limits(view)
    np.testing.assert_array_equal(finer, HILLS.limits(replace(view, detail=view.detail / 2))[0])
    np.testing.assert_array_equal(out_of_view, unseen)
    outside = max(view.m_offscreen, math.radians(0.533))
    for got, m in zip(unseen, (view.m_offscreen, outside, UNLIT * outside), strict=True):
        np.testing.assert_allclose(got[1:], limit(at_tilt(HILLS, 0.0), R, m)[1:])
    # At its limit in view, a tile's P is of the tilt at that very distance.
    tilt = seen_tilt(HILLS.relief, HILLS.spacings, above / inside)
    P = priorities(HILLS.relief, HILLS.spacings, tilt)
    np.testing.assert_allclose(inside[1:], limit(P, R, view.m)[1:], rtol=1e-6)
    assert np.all(inside >= unseen[0])
