"""A lens blurs by its formula, and a panorama sees all round without a seam."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.air import Air
from lod.camera import FULL_TURN, ThinLens
from lod.errors import InputError
from lod.viewing import DISC_WIDTH, Defocus, defocus_width
from scenes.frame.frame_input import FrameInput
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.render import render_frame
from scenes.scene import frame_quality

WIDTH, HEIGHT = 24, 700
FOV = 4.0


def edge_frame(make, variant, lens, distance=4.0, spp=4):
    """A wall that covers the right half of the picture, without haze; every row is alike."""
    camera = replace(make.camera((WIDTH, HEIGHT), fov=FOV, eye=(0.0, 0.0, 0.0)), lens=lens)
    s = 5 * distance
    wall = make.quad(
        [(0, distance, -s), (s, distance, -s), (s, distance, s), (0, distance, s)], 0.5
    )
    quality = make.quality(variant, spp=spp, max_depth=2)
    return render_frame(FrameInput(camera, (wall,), make.clear, make.light, quality))


def disc_edge(x, diameter):
    """Share of a disc about each x that is right of 0: the edge's profile."""
    u = np.clip(2 * x / diameter, -1, 1)
    return 0.5 + (u * np.sqrt(1 - u * u) + np.arcsin(u)) / math.pi


@pytest.mark.parametrize("focus", [8.0, 2.4])
def test_the_profile_of_a_defocused_edge(make, variant, focus):
    """Behind and before the plane in focus, in both drivers; the albedo has no light to it."""
    pixel = 2 * math.tan(math.radians(FOV / 2)) / WIDTH
    lens = ThinLens(12 * pixel / abs(1 / 4.0 - 1 / focus), focus)
    frame = edge_frame(make, variant, lens)
    profile = frame.albedo[..., 0].mean(axis=0) / 0.5
    fine = (np.arange(WIDTH * 64) + 0.5) / 64 - WIDTH / 2  # pixels, averaged over their width
    expected = disc_edge(fine, 12.0).reshape(WIDTH, 64).mean(axis=1)
    assert np.abs(profile - expected).max() < 0.03
    # Its spread is the width that the cascade counts, with the pixel's own, in quadrature.
    slope, at = np.diff(profile), np.arange(1, WIDTH) - WIDTH / 2
    middle = np.average(at, weights=slope)
    spread = math.sqrt(12 * np.average((at - middle) ** 2, weights=slope)) * pixel
    (width,) = defocus_width(Defocus(lens), np.array([4.0]))
    assert width == pytest.approx(DISC_WIDTH * 12 * pixel)
    assert spread == pytest.approx(math.hypot(width, pixel, pixel), rel=0.03)


def test_depth_normals_and_ids_are_those_of_the_lens_centre(make, variant):
    frame = edge_frame(make, variant, ThinLens(0.2, 8.0))
    half = WIDTH // 2
    assert (frame.object[:, :half] == 0).all()
    assert (frame.object[:, half:] == 1).all()
    np.testing.assert_allclose(frame.N[:, half:, 1], -1, atol=1e-6)
    blurred = np.ptp(frame.albedo[..., 0].mean(axis=0)[half - 2 : half + 2])
    assert 0.05 < blurred < 0.45  # and the picture is not sharp


def test_what_is_in_focus_is_sharp(make, variant):
    frame = edge_frame(make, variant, ThinLens(0.2, 4.0))
    profile = frame.albedo[..., 0].mean(axis=0)
    assert (profile[: WIDTH // 2] == 0).all()
    np.testing.assert_allclose(profile[WIDTH // 2 :], 0.5, atol=1e-6)


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
