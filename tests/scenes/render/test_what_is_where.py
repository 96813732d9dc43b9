"""Orientation, ids, distances and normals, on scenes whose answers are known."""

import numpy as np

from scenes.frame.frame_input import Light
from scenes.frame.layers import SKY_Z


def columns_of(layer, value):
    return np.flatnonzero((layer == value).any(axis=0))


def test_east_is_right_and_up_is_up_for_a_camera_that_looks_north(make, variant):
    balls = make.balls([(3, 10, 2), (-3, 10, 2), (0, 10, 4.5)])
    frame = make.rendered(variant, balls, camera=make.camera((64, 48)))
    east, west, high = (frame.object == number for number in (1, 2, 3))
    assert columns_of(east, True).min() > 32 > columns_of(west, True).max()
    assert np.flatnonzero(high.any(axis=1)).max() < 24


def test_the_sun_shines_from_its_azimuth(make, variant):
    """A ball seen from the south, with the sun low in the east, is bright on its right."""
    camera, ball = make.camera((32, 32), fov=10), make.balls([(0, 10, 2)], radius=0.8)
    frame = make.rendered(variant, ball, camera=camera, light=Light(90, 15))
    assert frame.rgb[10:22, 22:26].mean() > 3 * frame.rgb[10:22, 6:10].mean()


def test_ids_are_exact_over_several_representations(make, variant):
    spots = [(x, 12.0, z) for x in (-5, -2.5, 0, 2.5, 5) for z in (1.0, 3.0)]
    balls = make.balls(spots, radius=0.9, first_part=100, level=2)
    others = make.balls([(x, y + 6, z) for x, y, z in spots], 0.3, 0.2, "others", 500, 4)
    scene = [balls, others, make.ground()]
    frame = make.rendered(variant, *scene, camera=make.camera((160, 80)))
    for number, (x, y, z) in enumerate(spots):
        column = int(80 * (1 + x / y / np.tan(np.radians(30))))
        row = int(40 - 80 * (z - 2) / y / np.tan(np.radians(30)))
        ids = frame.object[row, column], frame.part[row, column], frame.level[row, column]
        assert ids == (1 + number, 100 + number, 2)
    bottom = frame.object[-1, 0], frame.part[-1, 0], frame.level[-1, 0]
    assert bottom == (21, 7, 3)
    assert set(np.unique(frame.object)) <= set(range(22))
    sky = frame.object == 0
    assert sky.any() and (frame.part[sky] == 0).all() and (frame.level[sky] == 0).all()


def test_distance_is_along_the_ray_and_the_sky_s_is_finite(make, variant):
    camera = make.camera((64, 32), fov=90, eye=(0, 0, 2))
    frame = make.rendered(variant, make.wall(20, 0.5), camera=camera)
    met = frame.object == 1
    assert (frame.Z[~met] == SKY_Z).all() and (~met).any()
    # A pixel's ray is somewhere in it; the wall is at 20 m along the axis.
    x = (np.arange(64) + 0.5) / 32 - 1
    y = (16 - np.arange(32) - 0.5) / 32
    true = 20 * np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    assert (np.abs(frame.Z - true)[met] < 20 * 0.03).all()
    assert frame.Z[met].max() > 22
    assert np.allclose(frame.N[met], (0, -1, 0), atol=1e-5)
    assert np.allclose(frame.albedo[8:-4, 21:43], 0.5, atol=1e-3)


def test_everything_is_finite_and_nothing_negative_under_a_low_sun(make, variant):
    """The sky model gives negative blue near a low sun."""
    camera = make.camera((64, 32), fov=100, heading=90, pitch=5)
    scene = [make.ground(), make.balls([(10, 1, 2)])]
    for elevation in (0.0, 1.0):
        for turbidity in (1.0, 10.0):
            light = Light(90, elevation, turbidity)
            frame = make.rendered(variant, *scene, camera=camera, light=light)
            for layer in (frame.rgb, frame.Z, frame.albedo):
                assert np.isfinite(layer).all() and (layer >= 0).all()
            assert np.isfinite(frame.N).all()
            assert frame.statistics["replaced"] == 0


def test_the_sun_is_in_the_sky_where_it_should_be(make, variant):
    light = Light(10, 20)
    camera = make.camera((200, 100), heading=10, pitch=20, fov=10)
    frame = make.rendered(variant, camera=camera, light=light)
    rows, columns = np.nonzero(frame.rgb[..., 1] > 100)
    assert abs(columns.mean() - 99.5) < 0.5 and abs(rows.mean() - 49.5) < 0.5
    disc = frame.rgb[..., 1].sum() / np.median(
        frame.rgb[rows, columns, 1]
    )  # pixels; 20 to a degree
    assert abs(2 * np.sqrt(disc / np.pi) / 20 - 0.5358) < 0.03
