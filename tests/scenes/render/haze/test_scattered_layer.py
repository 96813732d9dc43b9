"""Haze lit as its layer lights it, against the medium that scatters, and against itself."""

import numpy as np
import pytest

from lod.air import Air, Mist
from scenes.frame.frame_input import FrameInput
from scenes.frame.quality import Quality
from scenes.render.description import medium_box as medium
from scenes.render.description.describe import describe_frame
from scenes.render.description.direction_table import (
    azimuth,
    interpolate,
    interpolate_planes,
    row_sine,
    row_sqrt_sine,
    row_upper,
)
from scenes.render.haze.scattered_layer import with_scattering_layer
from scenes.render.mitsuba import variants
from scenes.render.mitsuba.emitters import radiance, surroundings
from scenes.render.pipeline.render import render_frame

AIR = Air(2000.0)


def test_a_table_gives_back_what_it_holds_and_lines_between():
    rows, columns = 6, 8
    up, turn = (np.arange(rows) + 0.5) / rows * 2 - 1, np.arange(columns) / columns
    table = np.stack(np.broadcast_arrays(up[:, None], np.cos(2 * np.pi * turn)), axis=2)
    found = interpolate(table, row_sine(rows, up)[:, None], turn[None])
    assert np.allclose(found, table)
    half = interpolate(table, np.array([2.5]), np.array([-0.5 / columns]))[0]
    assert np.allclose(half, (table[2, 0] + table[3, -1]) / 2 * (1, 1), atol=0.2)
    assert half[0] == pytest.approx((up[2] + up[3]) / 2)
    assert row_upper(5, np.array([0.0, 0.25, 1.0])).tolist() == [0, 2, 4]
    assert azimuth(np.array([[1.0, 0, 0], [0, -1, 0]])).tolist() == [0.25, 0.5]


def test_a_table_of_planes_is_looked_up_plane_by_plane():
    planes, rows, columns = 3, 5, 4
    up = np.linspace(-1, 1, rows)
    table = np.zeros((planes, rows, columns, 1)) + np.arange(planes)[:, None, None, None] * 10
    table = table + up[:, None, None]
    sines = np.sign(up) * up**2
    found = interpolate_planes(
        table, np.array([[0], [1.25], [7]]), row_sqrt_sine(rows, sines), 0.3 * up
    )
    expected = np.array([[0], [12.5], [20]]) + up
    assert np.allclose(found[..., 0], expected)


def test_surroundings_stand_where_the_table_says(make, variant):
    """Its light comes from the direction that it was tabulated for, and none from below."""
    variants.use(variant)
    light = with_scattering_layer(describe_frame(make.frame(make.ground())), AIR)["light"]
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
        return render_frame(FrameInput(camera, tuple(scene), AIR, make.light, quality)).rgb.mean(
            axis=1
        )

    medium_rows, closed = rows("medium", 512), rows("scattered", 64)
    assert np.allclose(closed, medium_rows, rtol=0.03)


@pytest.mark.parametrize("air", [AIR, Air(20e3, Mist(400.0, 5.0, 30.0))])
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
