"""Contrast falls as exp(−β·d) in every channel, and land fades into the horizon's own radiance.

Scattered haze is lit as its layer lights it, gathered along lines of sight over ground of any
height, and held against the medium that scatters.
"""

import numpy as np
import pytest

from lod.air import (
    Air,
    Mist,
    mist_extinction,
    optical_depth,
    rgb_wavelengths,
)
from lod.plane_parallel import RINGS, SPOKES, directions
from scenes.frame.frame_input import FrameInput, Quality
from scenes.frame.layers import SKY_Z
from scenes.render import description as medium
from scenes.render import variants
from scenes.render.description import describe_frame
from scenes.render.haze import Direction, Haze, JitArrays, NumpyArrays, air_along
from scenes.render.light import (
    azimuth,
    horizon,
    interpolate,
    make_bands,
    radiance,
    row_upper,
    sun_disc,
    surroundings,
)
from scenes.render.render import render_frame
from scenes.render.scattered_layer import (
    DISTANCES_M,
    NEAR_M,
    RATIO,
    Lines,
    Sources,
    gather,
    ground_profile,
    heights_at,
    with_scattering_layer,
)
from scenes.world.sun_and_sky import Light

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


MIST = Air(20e3, Mist(400.0, 5.0, 30.0))
"""The eye stands in it, 3 m below its base."""


@pytest.mark.parametrize("pitch", [-2.0, 0.4, 12.0])
def test_contrast_in_mist_is_that_of_the_closed_form(make, variant, pitch):
    """Down to below the base, level, out through the base, and far above it."""
    distance, up = 300.0, 2 + 300 * np.tan(np.radians(pitch))
    path = (np.array([2.0]), np.array([up]), np.array([300 / np.cos(np.radians(pitch))]))
    camera = make.camera((4, 4), pitch=pitch, fov=0.1)

    def seen(albedo, air):
        wall = make.wall(distance, albedo)
        frame = make.rendered(variant, wall, camera=camera, air=air)
        return frame.rgb.mean(axis=(0, 1))

    contrast = (seen(0.5, MIST) - seen(0.0, MIST)) / seen(0.5, make.clear)
    depth = optical_depth(MIST, *path, rgb_wavelengths())[0]
    assert np.allclose(contrast, np.exp(-depth), rtol=4e-3)


def test_mist_veils_the_sky_above_the_eye_without_a_seam(make, variant):
    """From the airlight at the horizon to hardly any of it straight up."""
    camera, quality = make.camera((4, 120), fov=0.4), make.quality(variant)
    column = render_frame(FrameInput(camera, (), MIST, make.light, quality)).rgb.mean(axis=1)
    assert (np.abs(np.diff(column, axis=0)) < 0.03 * column[:-1]).all()
    up = make.camera((4, 4), pitch=60, fov=1)
    veiled, clear = (
        render_frame(FrameInput(up, (), air, make.light, quality)).rgb.mean(axis=(0, 1))
        for air in (MIST, make.clear)
    )
    # Metres at the base that hold as much mist as an endless path upwards.
    base, scale, start = MIST.mist.base_m, MIST.mist.scale_m, 2.0
    metres = max(base - start, 0.0) + scale * np.exp(-max(start - base, 0.0) / scale)
    metres /= np.sin(np.radians(60))
    through = np.exp(-metres * mist_extinction(MIST, rgb_wavelengths()))
    variants.use(variant)
    to_sun = make.light.to_sun
    air = horizon({"to_sun": to_sun, "turbidity": make.light.turbidity})[0]  # due north
    assert np.allclose(veiled, clear * through + air * (1 - through), rtol=1e-3)


def test_both_drivers_see_the_same_mist(make):
    for name in (variants.SCALAR_VARIANT, variants.JIT_VARIANT):
        if variants.works(name) is not True:
            pytest.skip(f"{name} does not work here")
    scene = [make.balls([(x, 40.0, 1.0) for x in range(-20, 21, 4)], 1.5), make.ground()]
    camera = make.camera((48, 27), pitch=2)
    scalar, jit = (
        make.rendered(name, *scene, camera=camera, air=MIST, spp=64).rgb
        for name in (variants.SCALAR_VARIANT, variants.JIT_VARIANT)
    )
    assert np.allclose(scalar.mean(axis=(0, 1)), jit.mean(axis=(0, 1)), rtol=2e-3)


LAYER_AIR = Air(2000.0)


def haze_of(air, airlight_table, sky_table=None):
    bands, up = make_bands(False), np.array([0.0, 0.6, 0.8])
    sine = 0.0 if sky_table is not None else 0.01
    sun = np.array([4.0, 3.0, 2.0])
    return Haze(air, bands, 2.0, airlight_table, sky_table, sine, up, sun, 0.9)


def test_a_table_of_planes_is_looked_up_plane_by_plane(variant):
    variants.use(variant)
    rows, planes = 5, np.arange(3)[:, None, None, None] * 10.0
    up = np.linspace(-1, 1, rows)
    table = np.broadcast_to(planes + up[:, None, None], (3, rows, 4, 3))
    sine = (np.sign(up) * up**2)[:, None]
    directions = Direction(np.sqrt(1 - sine**2), 0 * sine, sine)
    for plane, expected in ((0, 0), (1.25, 12.5), (7, 20)):
        distance = np.full_like(sine, NEAR_M * RATIO**plane)
        through, added = air_along(
            haze_of(AIR, table), distance, directions, sine < -2, NumpyArrays
        )
        assert np.allclose(added / (1 - through), expected + up[:, None])


@pytest.mark.parametrize("tables", ["analytic", "scattered"])
@pytest.mark.parametrize("air", [AIR, Air(20e3, Mist(400.0, 5.0, 30.0))])
def test_samples_and_means_of_pixels_have_the_same_air(variant, air, tables):
    """On arrays of Dr.Jit as of NumPy, whatever a ray meets."""
    if variant.startswith("scalar"):
        pytest.skip("a driver of its own samples")
    variants.use(variant)
    import mitsuba as mi

    generator = np.random.default_rng(2)
    shape = (1, 1, 9, 3) if tables == "analytic" else (3, 6, 9, 3)
    sky = None if tables == "analytic" else generator.random((6, 9, 3))
    haze = haze_of(air, generator.random(shape), sky)
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


def test_surroundings_stand_where_the_table_says(make, variant):
    """Its light comes from the direction that it was tabulated for, and none from below."""
    variants.use(variant)
    light = with_scattering_layer(describe_frame(make.frame(make.ground())), LAYER_AIR)["light"]
    way = np.array([(0.6, 0.0, 0.8), (0.0, 0.8, 0.6), (-0.48, -0.64, 0.6), (0.8, -0.6, 0.02)])
    way /= np.linalg.norm(way, axis=1)[:, None]
    seen = light["scattering_layer"].sky_from_ground
    expected = interpolate(seen, row_upper(len(seen), way[:, 2]), azimuth(way))
    import mitsuba as mi

    emitter = mi.load_dict(surroundings(light))
    assert np.allclose(radiance(emitter, way)[:, :3], expected, rtol=0.02)
    assert (radiance(emitter, -way)[:, :3] == 0).all()


def test_ground_and_sky_are_as_bright_as_in_the_medium(make, variant, monkeypatch):
    """Over even ground below 100 m of air, by rows of the picture, colour by colour."""
    monkeypatch.setattr(medium, "HEIGHT_M", 100.0)
    camera = make.camera((32, 6), pitch=0.0, fov=40.0)
    scene = [make.ground(9000.0)]

    def rows(haze, spp):
        quality = Quality(variant, spp, 3, 16, haze)
        return render_frame(
            FrameInput(camera, tuple(scene), LAYER_AIR, make.light, quality)
        ).rgb.mean(axis=1)

    medium_rows, closed = rows("medium", 512), rows("scattered", 64)
    assert np.allclose(closed, medium_rows, rtol=0.03)


@pytest.mark.parametrize("air", [LAYER_AIR, Air(20e3, Mist(400.0, 5.0, 30.0))])
def test_no_seam_at_the_horizon_and_both_drivers_alike(make, air):
    for name in (variants.SCALAR_VARIANT, variants.JIT_VARIANT):
        if variants.works(name) is not True:
            pytest.skip(f"{name} does not work here")
    camera = make.camera((4, 60), fov=0.4, eye=(0, 0, 60))
    scalar, jit = (
        render_frame(
            FrameInput(
                camera, (make.ground(30e3),), air, make.light, Quality(name, 4, 1, 4, "scattered")
            )
        ).rgb.mean(axis=1)
        for name in (variants.SCALAR_VARIANT, variants.JIT_VARIANT)
    )
    assert np.allclose(scalar, jit, rtol=0.02)
    step = np.diff(np.log(jit), axis=0)  # the sky brightens upwards, but nowhere at once
    assert (np.abs(np.diff(step, axis=0)) < 0.03).all()


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
