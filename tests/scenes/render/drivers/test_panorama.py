"""A panorama: where things are in it, no seam at its edges, and what cannot render one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.air import Air
from lod.camera import FULL_TURN
from lod.errors import InputError
from scenes.frame.assemble import frame_quality
from scenes.frame.frame_input import FrameInput
from scenes.preset.load import load_preset
from scenes.render.mitsuba import variants
from scenes.render.pipeline.render import render_frame

SIZE = (64, 32)
VARIANT = variants.JIT_VARIANT

pytestmark = pytest.mark.skipif(
    variants.works(VARIANT) is not True, reason=f"{VARIANT} does not work here"
)


def panorama(make, **place):
    return replace(make.camera(SIZE, **place), panorama=True, fov_x=FULL_TURN)


def frame(make, camera, *displayed, spp=4, air=None, after=None):
    quality = make.quality(VARIANT, spp=spp)
    return render_frame(
        FrameInput(camera, displayed, air or make.clear, make.light, quality, after)
    )


@pytest.mark.parametrize("heading", [0.0, 90.0])
def test_things_are_where_their_azimuth_and_elevation_say(make, heading):
    """Ahead, right, left, behind, and 45° up: in a sphere about an eye 2 m up."""
    turn = math.radians(heading)
    spots = []
    for azimuth, rise in ((0, 0), (90, 0), (-90, 0), (180, 0), (0, 45)):
        a, e = math.radians(azimuth) + turn, math.radians(rise)
        spots.append(
            (10 * math.sin(a) * math.cos(e), 10 * math.cos(a) * math.cos(e), 2 + 10 * math.sin(e))
        )
    layers = frame(make, panorama(make, heading=heading), make.balls(spots, radius=0.8))
    for number, place in enumerate(((32, 16), (48, 16), (16, 16), None, (32, 8)), 1):
        rows, columns = np.nonzero(layers.object == number)
        if place:
            assert (columns.mean() + 0.5, rows.mean() + 0.5) == pytest.approx(place, abs=0.6)
        else:  # behind: half of it at either edge
            assert {0, 63} <= set(columns) and not set(columns) & set(range(3, 61))
    met = layers.object > 0
    assert layers.Z[met].min() > 9.1 and layers.Z[met].max() < 10.1


def test_no_seam_between_the_edges(make):
    """The picture turned by half, rendered with its edge where its middle was, is the same."""
    balls = make.balls([(-4.0, 6.0, 2.0), (3.0, -7.0, 1.5), (0.2, -9.0, 3.0)], radius=0.9)
    scene = balls, make.ground()
    here, turned = (
        frame(make, panorama(make, heading=heading), *scene, spp=64, air=Air(200.0))
        for heading in (20.0, 200.0)
    )
    here, turned = (np.minimum(each.rgb, 1.0) for each in (here, turned))  # the sun is noise
    rolled = np.roll(turned, SIZE[0] // 2, axis=1)
    assert np.abs(rolled - here).mean() < 0.03 * here.mean()
    edge = np.abs(here[:, 0] - here[:, -1]).mean()
    assert edge < 1.5 * np.abs(np.diff(here, axis=1)).mean()


def test_motion_goes_the_shorter_way_across_the_edge(make):
    camera, after = (panorama(make, heading=heading) for heading in (0.0, 10.0))
    layers = frame(make, camera, make.ground(), after=after)
    np.testing.assert_allclose(layers.motion[..., 0], -64 * 10 / 360, atol=0.01)
    np.testing.assert_allclose(layers.motion[..., 1], 0, atol=0.01)


def test_a_variant_without_such_a_camera_is_refused_in_one_line():
    preset = load_preset("meadow", ["camera.projection=panorama"])
    with pytest.raises(InputError, match="JIT variant") as caught:
        frame_quality(preset, variants.SCALAR_VARIANT)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "setting",
    ["camera.f_stop=2", "view.metric=depth", "render.haze=medium", "render.spectral=true"],
)
def test_what_a_panorama_cannot_have_is_refused(setting):
    with pytest.raises(InputError):
        load_preset("meadow", ["camera.projection=panorama", setting])
