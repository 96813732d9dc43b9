"""A layer of air between sky and ground: what must hold of its light whatever the method."""

import numpy as np
import pytest

from lod.plane_parallel import (
    RINGS,
    SPOKES,
    Scattering,
    SlabInputs,
    direct_irradiance,
    directions,
    henyey_greenstein,
    mean_path_fraction,
    radiance,
    source_function,
)

HAZE = Scattering(0.97, 0.71)
SUN = np.array((0.48, 0.64, 0.6))


def lit(thickness=0.1, sky=0.0, sun=0.0, ground=0.0, steps=8, cover=0.0, plants=0.0):
    """One band, 80 m, the cover spread over it evenly."""
    return SlabInputs(
        height=np.linspace(0.0, 80.0, steps + 1),
        depth=np.full((steps, 1), thickness / steps),
        cover=np.full(steps, cover / steps),
        to_sun=SUN,
        sun=np.array([sun]),
        sky=np.full((RINGS // 2, SPOKES, 1), sky),
        ground=np.array([ground]),
        plants=np.array([plants]),
    )


def flux(light):
    """Net, downwards, of each height's light, (levels,)."""
    up = directions()[..., 2]
    return (light[..., 0] * up).sum(axis=(1, 2)) * 4 * np.pi / (RINGS * SPOKES)


@pytest.mark.parametrize("cover", [0.0, 0.5])
def test_light_that_is_even_all_round_stays_so(cover):
    """Nothing absorbs, ground and plants are white: one radiance everywhere, in balance."""
    between = lit(0.3, sky=0.2, ground=1.0, cover=cover, plants=1.0)
    source = source_function(between, Scattering(1.0, 0.71))
    assert np.allclose(source, 0.2, rtol=1e-3)


@pytest.mark.parametrize("ground", [0.0, 0.4])
@pytest.mark.parametrize("cover", [0.0, 0.2])
def test_what_absorbs_nothing_passes_the_same_flux_at_every_height(ground, cover):
    between = lit(0.4, sky=0.1, sun=1.0, ground=ground, cover=cover, plants=1.0)
    source = source_function(between, Scattering(1.0, 0.71))
    light = radiance(between, source, sent_by_plants(between, source))
    net = flux(light) + direct_irradiance(between)[:, 0] * SUN[2]
    assert np.allclose(net, net[0], rtol=5e-3)


def sent_by_plants(between, source):
    """ϱ/4π·(E + ∫L·dω), settled."""
    sent = np.zeros((len(between.height), 1))
    for _ in range(60):
        around = radiance(between, source, sent).sum(axis=(1, 2)) * 4 * np.pi / (RINGS * SPOKES)
        sent = between.plants / (4 * np.pi) * (direct_irradiance(between) + around)
    return sent


def test_what_stands_keeps_the_sun_as_beer_says():
    """exp(−K·A/sin e) of it is left on the ground of thin air."""
    left = direct_irradiance(lit(1e-9, sun=2.0, cover=0.3))[:, 0]
    assert left[0] == pytest.approx(2 * np.exp(-0.3 / SUN[2]))
    assert left[4] == pytest.approx(2 * np.exp(-0.15 / SUN[2]))


def test_black_plants_hide_the_sky_and_send_nothing():
    """exp(−K·A/sin e) of it comes down, however bright a source the air has that is not there."""
    between, up = lit(1e-12, sky=1.0, cover=0.3), directions()[RINGS // 2 :, :, 2]
    source = np.full((len(between.height), RINGS, SPOKES, 1), 5.0)
    light = radiance(between, source, np.zeros((len(between.height), 1)))
    assert np.allclose(light[0, RINGS // 2 :, :, 0], np.exp(-0.3 / up))
    assert np.allclose(light[-1, : RINGS // 2], 0.0, atol=1e-9)


def test_a_thin_layer_scatters_once():
    """J of the sun alone tends to ϖ·p·E where nothing comes twice."""
    source = source_function(lit(1e-7, sun=2.0), HAZE)
    once = 0.97 * henyey_greenstein(directions() @ SUN, 0.71) * 2.0
    assert np.allclose(source[..., 0], once[None], rtol=1e-3)


def test_the_phase_function_sums_to_one_and_has_its_mean_cosine():
    cosine = (np.arange(4000) + 0.5) / 2000 - 1
    weight = henyey_greenstein(cosine, 0.71) * 2 * np.pi / 2000
    assert weight.sum() == pytest.approx(1.0, rel=1e-4)
    assert (weight * cosine).sum() == pytest.approx(0.71, rel=1e-4)


def test_finer_steps_change_nothing_that_counts():
    few, many = (source_function(lit(0.1, 0.1, 1.0, 0.2, steps), HAZE) for steps in (8, 32))
    assert np.allclose(few, many[::4], rtol=3e-3)


def test_where_the_light_of_a_path_comes_from():
    depth = np.array([0.0, 1e-4, 1e-3, 0.3, 4.0, 800.0])
    x = (np.arange(200000) + 0.5) / 200000
    weight = np.exp(-depth[:, None] * x)
    expected = (weight * x).sum(axis=1) / weight.sum(axis=1)
    assert np.allclose(mean_path_fraction(depth), expected, rtol=1e-3)
    assert (np.diff(mean_path_fraction(np.linspace(0, 5, 5000))) < 0).all()
