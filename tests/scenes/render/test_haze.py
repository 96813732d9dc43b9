"""Contrast falls as exp(−β·d) in every channel, and land fades into the horizon's own radiance."""

import numpy as np
import pytest

from lod.air import Air
from scenes.frame.frame_input import FrameInput, Light
from scenes.frame.layers import SKY_Z
from scenes.render import variants
from scenes.render.haze import Direction, Haze, JitArrays, NumpyArrays, air_along, horizon
from scenes.render.light import make_bands, sun_disc
from scenes.render.render import render_frame

AIR = Air(8000.0)


def test_no_seam_between_land_sky_and_what_lies_beyond_the_land(make, variant):
    """Straight through the horizon over land that ends at 30 km: no step, no dark line."""
    camera = make.camera(size=(4, 120), fov=0.4, eye=(0, 0, 100))
    air = Air(5000.0)
    frame = make.rendered(variant, make.ground(30000.0), camera=camera, air=air, spp=4)
    column = frame.rgb.mean(axis=1)
    beyond = (frame.Z == SKY_Z).all(axis=1)
    assert beyond.any() and not beyond.all()
    assert (np.abs(np.diff(column, axis=0)) < 0.03 * column[:-1]).all()


@pytest.mark.parametrize("spp", [1, 5])
def test_any_sample_count_keeps_the_mean(make, variant, spp):
    """Near balls before far haze: pixels that mix distances are what a wrong mean would show in."""
    balls = make.balls([(x, 10, z) for x in np.arange(-6, 7, 1.5) for z in (0.5, 2, 3.5)], 0.4)
    camera = make.camera(size=(96, 48))
    air, ground = Air(195.6), make.ground()
    scene = [balls, ground]
    few = make.rendered(variant, *scene, camera=camera, air=air, spp=spp, seed=4)
    many = make.rendered(variant, *scene, camera=camera, air=air, spp=64, seed=5)
    assert np.allclose(few.rgb.mean(axis=(0, 1)), many.rgb.mean(axis=(0, 1)), rtol=4e-3)


def test_coarse_pixels_hold_the_mean_of_fine_ones(make, variant):
    """Dark and near before bright and far in every pixel: what a mean distance would get wrong."""
    spots = [(x, 10, z) for x in np.arange(-6, 6.1, 0.5) for z in np.arange(-3, 7, 0.5)]
    scene = [make.balls(spots, radius=0.2, albedo=0.02), make.wall(400, 0.8)]
    air = Air(978.0)

    def mean(size, spp):
        camera = make.camera(size, fov=30)
        quality = make.quality(variant, spp)
        return render_frame(FrameInput(camera, tuple(scene), air, make.light, quality)).rgb.mean(
            axis=(0, 1)
        )

    assert np.allclose(mean((6, 4), 400), mean((96, 64), 4), rtol=0.01)


def test_neither_sun_nor_airlight_is_negative(variant):
    """The sky model's blue is below 0 for a sun near the horizon."""
    variants.use(variant)
    for elevation in (0.5, 2.0):
        for turbidity in (1.0, 2.0, 10.0):
            light = {"to_sun": Light(30, elevation).to_sun, "turbidity": turbidity}
            assert (sun_disc(light)[0] >= 0).all()
            assert (horizon(light) >= 0).all()


def test_samples_and_means_of_pixels_have_the_same_air(variant):
    """On arrays of Dr.Jit as of NumPy, whatever a ray meets."""
    if variant.startswith("scalar"):
        pytest.skip("a driver of its own samples")
    variants.use(variant)
    import mitsuba as mi

    generator = np.random.default_rng(2)
    up, sun = np.array([0.0, 0.6, 0.8]), np.array([4.0, 3.0, 2.0])
    haze = Haze(AIR, make_bands(False), generator.random((9, 3)), 0.01, up, sun, 0.9)
    way = generator.normal(size=(400, 3))
    way[:50, 2] = 0.0
    way = (way / np.linalg.norm(way, axis=1)[:, None]).astype(np.float32).astype(np.float64)
    distance = generator.choice([0.0, 3.0, 90.0, 4000.0], 400)[:, None]
    x, y, z = np.split(way, 3, axis=1)
    expected = air_along(haze, distance, Direction(x, y, z), z <= haze.horizon_sine, NumpyArrays)
    ray = mi.Vector3f(way.T.astype(np.float32))
    found = air_along(haze, mi.Float(distance[:, 0]), ray, ray.z <= haze.horizon_sine, JitArrays)
    for jit, numpy in zip(found, expected, strict=True):
        assert np.allclose(np.array(jit).T, numpy, rtol=2e-4, atol=2e-5)
