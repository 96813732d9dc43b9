"""Pictures of a pair of eyes: how far things are apart in them, and how they are filed."""

import math
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from scenes.frame.frame_input import FrameInput
from scenes.presets.schema import OutputPreset
from scenes.render.exr.header import frame_header
from scenes.render.exr.layers import channel_types, read_exr, read_pixels, write_exr
from scenes.render.render import render_frame

SIZE = (128, 32)


def pair_of(make, variant, apart=0.4, sub=False):
    balls = make.balls([(-1.0, 6.0, 2.0), (3.0, 12.0, 2.0)], radius=0.4)
    camera = replace(make.camera(SIZE), baseline_m=apart)
    made = FrameInput(
        camera, (balls, make.ground()), make.clear, make.light, make.quality(variant), camera
    )
    if sub:
        made = replace(made, subframes=(lambda: made, lambda: made))
    return render_frame(made)


def test_nearer_things_are_farther_apart_in_the_two_pictures(make, variant):
    left = pair_of(make, variant)
    pixel = 2 * math.tan(math.radians(30)) / SIZE[0]
    for number, depth in ((1, 6.0), (2, 12.0)):
        at = [np.nonzero(eye.object == number)[1].mean() for eye in (left, left.right)]
        assert at[0] - at[1] == pytest.approx(0.4 / depth / pixel, abs=0.5)
    np.testing.assert_allclose(left.right.motion[left.right.object == 1], 0, atol=1e-4)


def test_each_eye_of_a_pair_is_the_picture_of_that_eye_alone(make, variant):
    left, right = (pair := pair_of(make, variant)), pair.right
    for eye, number in ((left, 0), (right, 1)):
        camera = replace(make.camera(SIZE), baseline_m=0.4).pair[number]
        balls = make.balls([(-1.0, 6.0, 2.0), (3.0, 12.0, 2.0)], radius=0.4)
        scene, quality = (balls, make.ground()), make.quality(variant)
        alone = render_frame(FrameInput(camera, scene, make.clear, make.light, quality, camera))
        np.testing.assert_array_equal(eye.Z, alone.Z)
        np.testing.assert_array_equal(eye.rgb, alone.rgb)


def test_both_eyes_of_sub_frames(make):
    """A pair under an open shutter whose sub-frames are all alike shows what it shows at rest."""
    blurred, still = (pair_of(make, "scalar_rgb", sub=sub) for sub in (True, False))
    for eye, other in ((blurred, still), (blurred.right, still.right)):
        assert (eye.object == other.object).mean() > 0.97


def test_a_pair_is_one_file_whose_plain_reader_sees_the_left_eye(tmp_path, make):
    left = pair_of(make, "scalar_rgb")
    camera, path = replace(make.camera(SIZE), baseline_m=0.4), tmp_path / "pair.exr"
    write_exr(path, left, frame_header(camera, 24.0, {}, 1))
    found, header = read_exr(path)
    for eye, other in ((found, left), (found.right, left.right)):
        np.testing.assert_array_equal(eye.rgb, other.rgb)
        np.testing.assert_array_equal(eye.object, other.object)
        np.testing.assert_array_equal(eye.motion, other.motion)
    assert header["multiView"] == ["left", "right"]
    np.testing.assert_allclose(header["lod:eye"], camera.pair[0].eye)
    pixels, _ = read_pixels(path)
    types = channel_types(OutputPreset(motion=True), stereo=True)
    assert {name: each.dtype for name, each in pixels.items()} == types
    image = oiio.ImageBuf(str(path))
    assert image.spec().getattribute("multiView") == ("left", "right")
    assert image.spec().channelnames[:3] == ("R", "G", "B")
    np.testing.assert_array_equal(image.get_pixels(oiio.FLOAT)[..., :3], left.rgb)
