"""What a lens does to the picture: an edge out of focus, held against the thin lens's formula."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.camera import ThinLens
from lod.viewing import DISC_WIDTH, Defocus, defocus_width
from scenes.frame.frame_input import FrameInput
from scenes.render.pipeline.render import render_frame

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
