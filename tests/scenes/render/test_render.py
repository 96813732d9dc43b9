"""Frames by every driver: crops and their windows, frames in a row, motion blur, pairs of eyes."""

import math
from dataclasses import fields, replace

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.air import Air
from lod.camera import Corner, ThinLens, camera_from_heading
from lod.errors import InputError
from lod.motion import subframe_offsets
from lod.shapes import Sticks
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput, Window
from scenes.presets.load import load_preset
from scenes.presets.schema import OutputPreset
from scenes.presets.values import parse_crop
from scenes.render import variants
from scenes.render.exr.header import frame_header
from scenes.render.exr.layer_file import channel_types, read_exr, read_pixels, write_exr
from scenes.render.render import build_frame, render_frame, render_subframes, trace
from scenes.scene import Scene

SIZE = 24, 14
WINDOW = Window(5, 3, 17, 12)


def frame(make, variant, window, **changes):
    """Balls on a ground in haze, in runs of which no border is a row's."""
    balls = make.balls([(x, 12.0, 1.0 + x / 5) for x in range(-4, 5, 2)], radius=0.8)
    camera = replace(make.camera(SIZE), lens=ThinLens(0.1, 8.0))
    quality = replace(
        make.quality(variant, spp=5), window=window, most_samples=5 * 100, coverage=True, **changes
    )
    after = make.camera(SIZE, heading=1.0)
    return render_frame(
        FrameInput(camera, (balls, make.ground()), Air(300.0), make.light, quality, after)
    )


def test_a_crop_is_the_same_pixels(make, variant):
    same_pixels(make, variant)


@pytest.mark.slow
def test_a_crop_is_the_same_pixels_in_a_medium(make, variant):
    same_pixels(make, variant, haze="medium", max_depth=4)


def same_pixels(make, variant, **changes):
    whole, crop = (frame(make, variant, window, **changes) for window in (None, WINDOW))
    rows, columns = slice(WINDOW.top, WINDOW.bottom), slice(WINDOW.left, WINDOW.right)
    layers = [
        each.name for each in fields(whole) if isinstance(getattr(whole, each.name), np.ndarray)
    ]
    assert {"rgb", "Z", "object", "motion", "albedo"} <= set(layers)
    for name in layers:
        np.testing.assert_array_equal(
            getattr(crop, name), getattr(whole, name)[rows, columns], err_msg=name
        )
    number = np.full(SIZE[::-1], -1)
    number[rows, columns] = np.arange(crop.Z.size).reshape(crop.Z.shape)
    at = number.ravel()[whole.coverage.pixel]
    np.testing.assert_array_equal(at[at >= 0], crop.coverage.pixel)
    np.testing.assert_array_equal(whole.coverage.object[at >= 0], crop.coverage.object)
    np.testing.assert_allclose(whole.coverage.share[at >= 0], crop.coverage.share)


TINTS = np.array([[0.5, 0.2, 0.1], [0.1, 0.5, 0.2], [0.2, 0.1, 0.5]])


@pytest.fixture
def jit():
    answer = variants.works(variants.JIT_VARIANT)
    if answer is not True:
        pytest.skip(f"no JIT variant works here: {answer}")
    variants.use(variants.JIT_VARIANT)
    return variants.JIT_VARIANT


def clump(make, counts, at=(0.0, 8.0, 1.0)):
    """So many sticks of each tint; one object and part each."""
    n, tint = sum(counts), np.repeat(np.arange(len(counts)), counts)
    balls = make.balls(np.asarray(at) + np.random.default_rng(n).uniform(-2, 2, (n, 3)), 0.2)
    end = balls.shape.start + np.array([0.0, 0.0, 0.5])
    radius = balls.shape.start_radius
    shape = Sticks(balls.shape.start, end, radius, radius, tint, TINTS, np.arange(n))
    return DisplayedRepresentation("clump", balls.cut, shape)


def test_twelve_frames_of_a_walk_compile_once(make, jit):
    """Of every tint there may be no stick, one, or many; the camera moves and turns."""
    import drjit as dr

    quality = make.quality(jit, spp=2)
    counts = [(3, 4, 9), (1, 1, 1), (0, 2, 5), (0, 0, 0), (1, 0, 7), (2, 1, 0)]
    misses = []
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for number in range(12):
            camera = make.camera((13, 7), heading=0.7 * number, eye=(0.2 * number, 0.0, 2.0))
            scene = [clump(make, counts[number % len(counts)]), make.ground(1500 + 10 * number)]
            dr.kernel_history_clear()
            render_frame(FrameInput(camera, tuple(scene), make.clear, make.light, quality), number)
            misses.append([not k["cache_hit"] for k in dr.kernel_history() if "cache_hit" in k])
    assert all(misses) and not any(any(each) for each in misses[1:])


def test_another_scene_that_is_still_there_takes_no_ids(make, jit):
    quality = make.quality(jit)
    lit = make.clear, make.light, quality
    seen = FrameInput(make.camera(), (clump(make, (2, 3, 4)), make.ground()), *lit)
    alone = render_frame(seen)
    balls = make.balls([(0.0, 5.0, 1.0)] * 3)
    other = build_frame(FrameInput(make.camera(), (make.ground(), balls), *lit))
    beside = render_frame(seen)
    late = trace(other, quality)
    for name in ("object", "part", "level"):
        assert np.array_equal(getattr(alone, name), getattr(beside, name))
    assert set(np.unique(late.object).tolist()) <= {0, 1, 2, 3, 4} and late.object.any()


SUBFRAMES = 16
WIDE_SIZE, FOCAL = (96, 6), 48.0
"""A picture 90° wide: f = 48 px."""
WIDE_M, AWAY_M = 0.4, 8.0
LEAN = 1 / WIDE_SIZE[1]

PAN = (
    "render.size=48x27",
    "render.spp=32",
    "camera.turn=90",
    "view.shutter=180",
    "species.tree.density=0",
    "species.sward.density=0",
    "species.figure.prototypes=1",
)


def camera():
    return camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, 0.0, 90.0, WIDE_SIZE)


def bar_at(make, x):
    """A wall of WIDE_M, facing the camera AWAY_M ahead of it: a box in every row of the picture.

    It leans by LEAN, so that its edges fall elsewhere in the pixels of each row.
    """
    left, right, lean = x - WIDE_M / 2, x + WIDE_M / 2, 6 * LEAN
    low, high = (AWAY_M, -4), (AWAY_M, 8)
    corners = [
        (left - lean, *low),
        (right - lean, *low),
        (right + lean, *high),
        (left + lean, *high),
    ]
    return make.quad(corners, albedo=0.8)


def blurred(make, moments, quality):
    """A frame of sub-frames, each a camera and what is displayed."""
    inputs = [FrameInput(*each, make.clear, make.light, quality) for each in moments]
    makers = tuple(lambda each=each: each for each in inputs)
    return render_subframes(replace(inputs[0], subframes=makers))


def profile_variance(make, variant, length_px, subframes=SUBFRAMES):
    """Of the albedo across the picture [px²], of a bar that goes ``length_px`` while it is open."""
    metres = length_px * AWAY_M / FOCAL
    places = (0.3 + metres * subframe_offsets(subframes)).tolist()
    moments = [(camera(), (bar_at(make, x),)) for x in places]
    quality = replace(make.quality(variant, subframes * 4), max_depth=2)
    layers = blurred(make, moments, quality)
    mass = layers.albedo[..., 0].astype(float)
    mass /= mass.sum(axis=1, keepdims=True)
    x = np.arange(WIDE_SIZE[0]) + 0.5
    mean = mass @ x
    return float((mass @ x**2 - mean**2).mean())


@pytest.mark.parametrize(
    "variant",
    [variants.SCALAR_VARIANT, pytest.param(variants.JIT_VARIANT, marks=pytest.mark.slow)],
    indirect=True,
)
def test_the_profile_of_what_moves_has_the_variance_of_the_quadrature_sum(make, variant):
    """Speeds from 0 to 40 pixels a shutter, within 3 %."""
    # Bar, the pixel that it falls on, and its lean within a row.
    own = ((WIDE_M * FOCAL / AWAY_M) ** 2 + 1 + LEAN**2) / 12
    for length in np.linspace(0, 40, 8).tolist():
        expected = own + length**2 / 12 * (1 - 1 / SUBFRAMES**2)
        assert profile_variance(make, variant, length) == pytest.approx(expected, rel=0.03)


def test_a_moving_camera_builds_its_scene_once_and_gives_the_same_as_building_it_again(
    make, variant
):
    scene = (make.balls([(0, 6, 2)]), make.ground())
    cameras = [replace(camera(), eye=np.array((x, 0.0, 2.0))) for x in (-0.4, 0.0, 0.4)]
    quality = make.quality(variant, 6)
    kept = blurred(make, [(each, scene) for each in cameras], quality)
    anew = blurred(make, [(each, scene[:1] + scene[1:]) for each in cameras], quality)
    for name in ("rgb", "albedo", "Z", "object"):
        assert np.array_equal(getattr(kept, name), getattr(anew, name))


def test_more_sub_frames_than_samples_are_refused(make):
    moments = [(camera(), (make.ground(),))] * 3
    with pytest.raises(InputError, match="subframes"):
        blurred(make, moments, make.quality("scalar_rgb", 2))


def shot(*settings):
    preset = load_preset("meadow", (*PAN, *settings))
    return Scene(preset).input(2, "scalar_rgb")


def test_a_pan_has_sub_frames_of_one_and_the_same_cut():
    made = shot()
    moments = [instant() for instant in made.subframes]
    assert len(moments) == 16
    assert all(each.displayed is made.displayed for each in moments)
    headings = [np.degrees(np.arctan2(*each.camera.forward[:2])) for each in moments]
    assert np.allclose(np.diff(headings), 90 / 48 / 16)
    assert np.mean(headings) == pytest.approx(20 + 90 / 24)


def test_the_shutter_prunes_only_where_heed_is_paid_to_it():
    parts, pruned = (
        sum(each.cut.displayed_parts for each in shot(f"view.smear={heed}").displayed)
        for heed in ("off", "shutter")
    )
    unblurred = sum(each.cut.displayed_parts for each in shot("view.shutter=0").displayed)
    assert pruned < parts == unblurred
    assert len(shot("view.smear=off").subframes) == 16


def test_where_nothing_moves_there_are_no_sub_frames():
    still = ("camera.speed=0", "camera.turn=0")
    assert shot(*still).subframes == ()
    assert shot("view.shutter=0").subframes == ()
    assert len(shot("render.spp=5").subframes) == 5


def test_walkers_are_posed_anew_in_each_sub_frame_and_the_ground_is_not():
    walking = ("camera.turn=0", "camera.speed=0", "species.figure.patrol=5")
    first, last = (shot(*walking).subframes[k]() for k in (0, -1))
    names = [each.name for each in first.displayed]
    for name, a, b in zip(names, first.displayed, last.displayed, strict=True):
        if isinstance(a.shape, Sticks):
            moved = np.linalg.norm(b.shape.start - a.shape.start, axis=1)
            assert name == "figure" and 0 < moved.max() < 0.2
        else:
            assert np.array_equal(a.shape.vertices, b.shape.vertices)


PAIR_SIZE = (128, 32)


def test_motion_vectors_of_a_blurred_frame_point_a_whole_frame_ahead():
    made = shot("output.motion=true")
    moment = made.subframes[8]()
    turned = np.degrees(np.arccos(moment.after.forward @ moment.camera.forward))
    assert turned == pytest.approx(90 / 24 * np.cos(np.radians(1)), rel=1e-3)
    assert isinstance(made.displayed[0], DisplayedRepresentation)


def pair_of(make, variant, apart=0.4, sub=False):
    balls = make.balls([(-1.0, 6.0, 2.0), (3.0, 12.0, 2.0)], radius=0.4)
    camera = replace(make.camera(PAIR_SIZE), baseline_m=apart)
    made = FrameInput(
        camera, (balls, make.ground()), make.clear, make.light, make.quality(variant), camera
    )
    if sub:
        made = replace(made, subframes=(lambda: made, lambda: made))
    return render_frame(made)


def test_nearer_things_are_farther_apart_in_the_two_pictures(make, variant):
    left = pair_of(make, variant)
    pixel = 2 * math.tan(math.radians(30)) / PAIR_SIZE[0]
    for number, depth in ((1, 6.0), (2, 12.0)):
        at = [np.nonzero(eye.object == number)[1].mean() for eye in (left, left.right)]
        assert at[0] - at[1] == pytest.approx(0.4 / depth / pixel, abs=0.5)
    np.testing.assert_allclose(left.right.motion[left.right.object == 1], 0, atol=1e-4)


def test_each_eye_of_a_pair_is_the_picture_of_that_eye_alone(make, variant):
    left, right = (pair := pair_of(make, variant)), pair.right
    for eye, number in ((left, 0), (right, 1)):
        camera = replace(make.camera(PAIR_SIZE), baseline_m=0.4).pair[number]
        balls = make.balls([(-1.0, 6.0, 2.0), (3.0, 12.0, 2.0)], radius=0.4)
        scene, quality = (balls, make.ground()), make.quality(variant)
        alone = render_frame(FrameInput(camera, scene, make.clear, make.light, quality, camera))
        np.testing.assert_array_equal(eye.Z, alone.Z)
        np.testing.assert_array_equal(eye.rgb, alone.rgb)


def test_a_pair_is_one_file_whose_plain_reader_sees_the_left_eye(tmp_path, make):
    left = pair_of(make, "scalar_rgb")
    camera, path = replace(make.camera(PAIR_SIZE), baseline_m=0.4), tmp_path / "pair.exr"
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


@st.composite
def windows(draw):
    width, height = draw(st.integers(1, 12)), draw(st.integers(1, 9))
    left, top = draw(st.integers(0, width - 1)), draw(st.integers(0, height - 1))
    window = Window(
        left, top, draw(st.integers(left + 1, width)), draw(st.integers(top + 1, height))
    )
    return (width, height), window


@given(windows(), st.integers(1, 40))
def test_runs_of_a_picture_fill_a_window_once_and_in_order(given, step):
    (width, height), window = given
    picture = np.arange(width * height)
    own = np.full(window.size[0] * window.size[1], -1)
    for first in range(0, width * height, step):
        pixels = slice(first, min(first + step, width * height))
        inside, at = window.share(pixels, width)
        assert (own[at] == -1).all()
        own[at] = picture[pixels][inside]
    expected = picture.reshape(height, width)
    expected = expected[window.top : window.bottom, window.left : window.right]
    np.testing.assert_array_equal(own, expected.ravel())
    assert window.is_all_of((width, height)) == (window == Window(0, 0, width, height))


@pytest.mark.parametrize(
    ("text", "edges"),
    [
        ("32x18+16+9", (16, 9, 48, 27)),
        ("50%x50%+25%+25%", (16, 9, 48, 27)),
        (" 1 x 1+63+35", (63, 35, 64, 36)),
    ],
)
def test_crops_as_they_are_written(text, edges):
    assert parse_crop(text, (64, 36)) == edges
    assert (
        load_preset("meadow", ["render.size=64x36", f"render.crop={text}"]).render.window == edges
    )


@pytest.mark.parametrize("text", ["32x18", "32x18+40+9", "0x18+0+0", "32x18-1+0"])
def test_a_crop_that_is_no_window_is_refused_in_one_line(text):
    with pytest.raises(InputError, match=r"render\.crop") as caught:
        load_preset("meadow", ["render.size=64x36", f"render.crop={text}"])
    assert "\n" not in str(caught.value)
