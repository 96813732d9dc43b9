"""Cover by objects too small to display: Poisson laws, and ground that stays what it is."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from scenes.field.far_cover import (
    cover_depths,
    covered_share,
    first_hit_shares,
    surface_irradiance,
    undisplayed_share,
)

UP = np.array(((0.0, 0.0, 1.0),))
SUN = np.array((0.6, 0.0, 0.8))


def test_a_poisson_field_of_discs_leaves_the_gaps_it_should():
    """Discs lying on the ground, seen straight down, strewn at random: share of points free."""
    rng = np.random.default_rng(3)
    K, r, side = 0.05, 1.5, 200.0
    discs = rng.random((rng.poisson(K * side**2), 2)) * side
    points = r + rng.random((4000, 2)) * (side - 2 * r)
    free = np.array([(((discs - p) ** 2).sum(axis=1) > r * r).all() for p in points])
    depths = cover_depths(np.ones((1, 1)), np.array((K,)), np.full((1, 1), np.pi * r * r), UP[:, 2])
    assert abs(covered_share(depths)[0] - (1 - free.mean())) < 0.025  # 3 sd of 4000 points


def test_missing_runs_as_roots_fade():
    d, one, alike = np.array((0.0, 79.9, 90.0, 100.0, 500.0)), np.ones(1), np.ones(2)
    near, both = np.array(((100.0,),)), np.array(((100.0, np.inf),))
    assert np.allclose(undisplayed_share(d, near, one, 0.2), (0, 0, 0.5, 1, 1))
    assert np.allclose(undisplayed_share(d, both, alike, 0.2), (0, 0, 0.25, 0.5, 0.5))
    assert np.array_equal(undisplayed_share(d, near, one, 0.0) > 0.5, d >= 100.0)


shares = st.floats(0, 1)


@given(missing=st.tuples(shares, shares), sine=st.floats(0.01, 1))
def test_cover_grows_with_what_is_missing_and_kinds_share_it(missing, sine):
    K, area, sines = np.array((0.01, 0.2)), np.array(((30.0, 0.5),)), np.array((sine,))
    depths = cover_depths(np.array((missing,)), K, area, sines)
    whole = cover_depths(np.ones((1, 2)), K, area, sines)
    assert 0 <= covered_share(depths)[0] <= covered_share(whole)[0] <= 1
    kinds = first_hit_shares(depths)[0]
    assert np.isclose(kinds.sum(), 1) or not depths.any()
    assert np.allclose(kinds * depths.sum(), depths[0])


@given(tilt=st.floats(0, 0.6), turn=st.floats(0, 6.3))
def test_opposite_slopes_get_the_suns_light_by_their_tilt_and_of_the_sky_what_they_see(tilt, turn):
    across, sky = np.sin(tilt) * np.array((np.cos(turn), np.sin(turn))), np.array((0.1, 0.2, 0.4))
    slopes = np.array([(*(side * across), np.cos(tilt)) for side in (1, -1)])
    told = (1 - sky) * np.cos(tilt) + sky * (1 + np.cos(tilt)) / 2
    assert np.allclose(surface_irradiance(slopes, SUN, sky).mean(axis=0), told)
    assert np.allclose(surface_irradiance(UP, SUN, sky), 1.0)
