"""Light without a renderer: a ball in the sun, and tones of shapes whose answer is known.

The sky by cells: what Mitsuba's says, and what it sends down.
"""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.shapes import StickTable
from scenes.appearance import sky as skies
from scenes.appearance.sky import (
    SKY_COLUMNS,
    SKY_ROWS,
    TURBIDITIES,
    Sky,
    SunAndSky,
    cell_irradiance,
    sky_at,
)
from scenes.appearance.tone import Illumination, _fit, fit_tone, lone_object, outgoing_light
from scenes.render import variants
from scenes.sticks.areas import ELEVATIONS_DEG, ViewDependence
from scenes.sticks.prototype import LUMINANCE, PartPlaces, Shapes, assemble_prototype
from tests.tools.sky_table import cells

BLACK = np.zeros(3)


def balls(centres, radius, tint=0, parts=1, owner=None):
    at = np.asarray(centres, np.float64)
    radii = np.broadcast_to(np.asarray(radius, np.float64), len(at))
    owner = np.zeros(len(at), np.int64) if owner is None else owner
    tints = np.broadcast_to(np.asarray(tint), len(at))
    return StickTable.of(parts, owner, at, at, radii, radii, tints)


@pytest.mark.parametrize("elevation", [15.0, 60.0])
def test_a_ball_before_the_sun_sends_what_lambert_says(elevation):
    """The eye in line with the sun, black sky and ground: ∫ cos θ dA = ⅔·π·r², over sin h."""
    table = balls([(0.0, 0.0, 3.0)], 0.5)
    one = lone_object(Shapes.of(table), np.full((1, 3), 0.6), np.zeros(1, np.bool_), BLACK)
    e = math.radians(elevation)
    to_sun = np.array([[math.cos(e), 0.0, math.sin(e)]])
    light = SunAndSky(to_sun, np.zeros(1), np.ones(3), np.zeros((8, 6, 3)))
    randoms = np.random.default_rng(1).random((40_000, 8))
    found = outgoing_light(one, light, elevation, randoms)
    expected = 0.6 * sum(LUMINANCE) * 2 / 3 * math.pi * 0.25 / math.sin(e)
    assert found.shape == (4, 1)
    assert found[0, 0] == pytest.approx(expected, rel=0.02)
    assert not found[1:].any(), "nothing stands for hidden parts"


def test_a_ball_in_an_even_sky_is_as_bright_as_the_share_of_sky_that_it_sees():
    """On black ground a point of normal n sees (1 + n_z)/2 of the sky; from overhead ⅚ in mean."""
    table = balls([(0.0, 0.0, 900.0)], 1.0)
    one = lone_object(Shapes.of(table), np.full((1, 3), 0.5), np.ones(1, np.bool_), BLACK)
    even = SunAndSky(np.array([[0.0, 0.0, 1.0]]), np.zeros(1), np.zeros(3), np.ones((8, 6, 3)))
    randoms = np.random.default_rng(2).random((20_000, 8))
    found = outgoing_light(one, even, 90.0, randoms)
    expected = 0.5 * sum(LUMINANCE) * math.pi * 5 / 6
    assert found[1, 0] == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("order", [(0, 1, 2), (0, 2, 1)])
def test_a_level_board_sends_the_light_of_level_ground_from_whichever_side(order):
    corners = np.array([[(-1, -1, 3), (2, -1, 3), (-1, 1, 3)]], float)[:, order]
    none = balls([(0.0, 0.0, -9.0)], 1e-3).take(np.zeros(0, np.int64))
    board = Shapes(none, corners, np.full((1, 3), 0.6))
    one = lone_object(board, board.colours, np.zeros(1, np.bool_), BLACK)
    to_sun = np.array([[math.cos(0.7), 0.0, math.sin(0.7)]])
    light = SunAndSky(to_sun, np.zeros(1), np.ones(3), np.zeros((8, 6, 3)))
    for elevation in (30.0, 90.0):
        randoms = np.random.default_rng(3).random((40_000, 8))
        found = outgoing_light(one, light, elevation, randoms)
        expected = 0.6 * sum(LUMINANCE) * 3.0 * math.sin(math.radians(elevation))
        assert found[0, 0] == pytest.approx(expected, rel=0.03)


def object_of(leaf_albedo, part_albedo, leaf, parts):
    """A whole whose leaf appearance stands for parts, each of which is one ball."""
    n = 1 + len(parts.tint)
    table = StickTable.merge(
        [
            leaf.with_owner(n, np.zeros(len(leaf), np.int64)),
            parts.with_owner(n, np.arange(1, n)),
        ]
    )
    rows = np.where(np.arange(len(table)) < len(leaf), 0, -1)
    places = PartPlaces(
        np.array([-1, *[0] * (n - 1)]),
        np.array([0, *[1] * (n - 1)]),
        np.vstack((np.zeros(3), parts.start)),
    )
    views = ViewDependence.of_area(rows, np.ones((1, len(ELEVATIONS_DEG))))
    none = table.take(np.zeros(0, np.int64))
    tints = np.array([[leaf_albedo] * 3, [part_albedo] * 3])
    return assemble_prototype("thing", places, none, table, tints, views)


def test_a_shape_twice_as_light_as_what_it_hides_has_half_its_albedo():
    centre, light = [(0.0, 0.0, 2.0)], Illumination(40.0)
    one = object_of(0.6, 0.3, balls(centre, 1.0, 0), balls(centre, 1.0, 1))
    tone = fit_tone((one,), light, lines=6000)
    assert tone.shape[0] == 1
    assert tone == pytest.approx(np.full(tone.shape, 0.5), rel=1e-3)


def test_what_shades_itself_asks_for_darker_shapes_under_any_sun():
    """A cloud of small balls, and one ball of nearly its size, of one albedo."""
    rng = np.random.default_rng(3)
    cloud = rng.normal(size=(400, 3))
    cloud = cloud / np.linalg.norm(cloud, axis=1)[:, None] * rng.uniform(0.2, 1, (400, 1))
    parts = balls(cloud + np.array((0, 0, 1.5)), 0.12, 1)
    one = object_of(0.3, 0.3, balls([(0, 0, 1.5)], 1.0, 0), parts)
    for sun in (15.0, 65.0):
        tone = fit_tone((one,), Illumination(sun), lines=6000)[0]
        assert (tone[:, -1] < 0.9).all() and (tone > 0.2).all()
    low = fit_tone((one,), Illumination(15.0), lines=6000)[0, 0]
    assert low[0] != pytest.approx(low[-2], rel=0.05), "before the sun and against it"


def test_threads_do_not_show(monkeypatch):
    """Sums of many lines are the same to the last bit, whoever adds them up."""
    centre, light = [(0.0, 0.0, 2.0)], Illumination(40.0)
    one = object_of(0.6, 0.3, balls(centre, 1.0, 0), balls(centre, 0.9, 1))
    found = []
    for count in (1, 3):
        monkeypatch.setattr("lod.kernels.get_num_threads", lambda count=count: count)
        found.append(_fit((one,), light, 5000))
    assert np.array_equal(*found)


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
        for e in nearest(skies.ELEVATIONS_DEG, elevation)
        for t in nearest(TURBIDITIES, turbidity)
    ]
    assert (sky.radiance >= np.min(around, axis=0) - 1e-9).all()
    assert (sky.radiance <= np.max(around, axis=0) + 1e-9).all()


def nearest(nodes, value):
    """The entries on either side."""
    k = int(np.clip(np.searchsorted(nodes, value), 1, len(nodes) - 1))
    return nodes[k - 1], nodes[k]
