"""Contrast falls as exp(−β·d) in every channel, and land fades into the horizon's own radiance."""

import numpy as np
import pytest

from scenes.render import variants
from scenes.render.build import sun_disc
from scenes.render.frame import SKY_Z, Air, Light
from scenes.render.haze import airlight
from scenes.render.render import render_frame

BETA = np.array([2e-4, 5e-4, 1e-3])


def look_at_wall(make, variant, distance, albedo, air, spp=4):
    camera = make.camera(size=(8, 4), fov=1.0, eye=(0, 0, 0))
    wall = make.wall(distance, albedo)
    return render_frame(camera, [wall], air, make.light, make.quality(variant, spp))


@pytest.mark.parametrize("distance", [50.0, 700.0, 4000.0])
def test_contrast_of_grey_on_black(make, variant, distance):
    grey_air = look_at_wall(make, variant, distance, 0.5, Air(BETA))
    black_air = look_at_wall(make, variant, distance, 0.0, Air(BETA))
    grey_clear = look_at_wall(make, variant, distance, 0.5, make.clear)
    contrast = (grey_air.rgb - black_air.rgb) / grey_clear.rgb
    assert np.allclose(contrast, np.exp(-BETA * distance), rtol=2e-3, atol=1e-5)


def test_black_wall_shows_airlight_growing_to_the_horizon_s(make, variant):
    full = look_at_wall(make, variant, 1e5, 0.0, Air(BETA)).rgb.mean(axis=(0, 1))
    for distance in (100.0, 2000.0):
        seen = look_at_wall(make, variant, distance, 0.0, Air(BETA)).rgb.mean(axis=(0, 1))
        assert np.allclose(seen / full, 1 - np.exp(-BETA * distance), rtol=2e-3)


def test_no_seam_between_land_sky_and_what_lies_beyond_the_land(make, variant):
    """Straight through the horizon over land that ends at 30 km: no step, no dark line."""
    camera = make.camera(size=(4, 120), fov=0.4, eye=(0, 0, 100))
    air = Air(np.full(3, 3.912 / 5000))
    frame = render_frame(camera, [make.ground(30e3)], air, make.light, make.quality(variant, spp=4))
    column = frame.rgb.mean(axis=1)
    beyond = (frame.Z == SKY_Z).all(axis=1)
    assert beyond.any() and not beyond.all()
    assert (np.abs(np.diff(column, axis=0)) < 0.03 * column[:-1]).all()


def test_beyond_the_land_is_never_black_even_in_clear_air(make, variant):
    camera = make.camera(size=(8, 8), fov=90, pitch=-40)
    frame = render_frame(camera, [], make.clear, make.light, make.quality(variant))
    assert (frame.rgb > 0.01).all()


@pytest.mark.parametrize("spp", [1, 3, 5, 16])
def test_any_sample_count_keeps_the_mean(make, variant, spp):
    """Near balls before far haze: pixels that mix distances are what a wrong mean would show in."""
    balls = make.balls([(x, 10, z) for x in np.arange(-6, 7, 1.5) for z in (0.5, 2, 3.5)], 0.4)
    camera = make.camera(size=(96, 48))
    air, ground = Air(np.full(3, 0.02)), make.ground()
    scene = [balls, ground]
    few = render_frame(camera, scene, air, make.light, make.quality(variant, spp, seed=4))
    many = render_frame(camera, scene, air, make.light, make.quality(variant, 64, seed=5))
    assert np.allclose(few.rgb.mean(axis=(0, 1)), many.rgb.mean(axis=(0, 1)), rtol=4e-3)


def test_coarse_pixels_hold_the_mean_of_fine_ones(make, variant):
    """Dark and near before bright and far in every pixel: what a mean distance would get wrong."""
    spots = [(x, 10, z) for x in np.arange(-6, 6.1, 0.5) for z in np.arange(-3, 7, 0.5)]
    scene = [make.balls(spots, radius=0.2, albedo=0.02), make.wall(400, 0.8)]
    air = Air(np.full(3, 0.004))

    def mean(size, spp):
        camera = make.camera(size, fov=30)
        quality = make.quality(variant, spp)
        return render_frame(camera, scene, air, make.light, quality).rgb.mean(axis=(0, 1))

    assert np.allclose(mean((6, 4), 400), mean((96, 64), 4), rtol=0.01)


def test_neither_sun_nor_airlight_is_negative(variant):
    """The sky model's blue is below 0 for a sun near the horizon."""
    variants.use(variant)
    for elevation in (0.5, 2.0):
        for turbidity in (1.0, 2.0, 10.0):
            light = {"to_sun": Light(30, elevation).to_sun, "turbidity": turbidity}
            assert (sun_disc(light)[0] >= 0).all()
            assert (airlight(light) >= 0).all()
