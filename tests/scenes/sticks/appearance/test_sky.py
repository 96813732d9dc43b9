"""The sky by cells: what Mitsuba's says, and what it sends down."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.calibrate.sky_table import cells
from scenes.render.mitsuba import variants
from scenes.sticks.appearance.sky import (
    ELEVATIONS_DEG,
    SKY_COLUMNS,
    SKY_ROWS,
    TURBIDITIES,
    Sky,
    cell_irradiance,
    sky_at,
)


def test_an_even_sky_sends_its_radiance_to_level_ground():
    assert cell_irradiance().sum() == pytest.approx(1.0)
    even = Sky(np.broadcast_to((0.1, 0.3, 0.5), (SKY_ROWS, SKY_COLUMNS, 3)))
    assert even.share == pytest.approx((0.1, 0.3, 0.5))


def test_level_ground_is_lit_from_a_band_as_its_sines_say():
    """∫ sin h dΩ/π from h₀ to h₁, all round: sin² h₁ − sin² h₀."""
    of_band = cell_irradiance().reshape(SKY_ROWS, SKY_COLUMNS).sum(axis=1)
    edges = np.arange(SKY_ROWS + 1) / SKY_ROWS
    assert of_band == pytest.approx(edges[1:] ** 2 - edges[:-1] ** 2)


@pytest.mark.parametrize(("elevation", "turbidity"), [(1.0, 10.0), (40.0, 3.0), (85.0, 2.0)])
def test_the_table_says_what_mitsuba_does(elevation, turbidity):
    variants.use(variants.SCALAR_VARIANT)
    told = sky_at(elevation, turbidity).radiance
    assert cells(elevation, turbidity, finer=8) == pytest.approx(told, rel=0.05, abs=0.002)
    assert told.mean() > 0.05


@given(st.floats(0.0, 90.0), st.floats(1.0, 10.0))
def test_between_its_entries_it_is_between_them(elevation, turbidity):
    sky = sky_at(elevation, turbidity)
    assert (sky.radiance >= 0).all() and (0 < sky.share).all() and (sky.share <= 1).all()
    around = [
        sky_at(e, t).radiance
        for e in nearest(ELEVATIONS_DEG, elevation)
        for t in nearest(TURBIDITIES, turbidity)
    ]
    assert (sky.radiance >= np.min(around, axis=0) - 1e-9).all()
    assert (sky.radiance <= np.max(around, axis=0) + 1e-9).all()


def nearest(nodes, value):
    """The entries on either side."""
    k = int(np.clip(np.searchsorted(nodes, value), 1, len(nodes) - 1))
    return nodes[k - 1], nodes[k]


def test_a_clear_sky_is_brightest_low_and_about_the_sun():
    luminance = sky_at(40.0, 3.0).radiance @ (0.2126, 0.7152, 0.0722)
    assert luminance[0].mean() > 2 * luminance[-1].mean()
    assert (luminance[:, 0] > 1.2 * luminance[:, -1]).all()
