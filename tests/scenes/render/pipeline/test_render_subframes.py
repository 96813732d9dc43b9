"""Motion blur: what moves by L is spread as the quadrature sum of box, pixel and shutter says."""

from dataclasses import replace

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from lod.motion import subframe_offsets
from lod.shapes import Sticks
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.render import render_subframes
from scenes.scene import Scene

SUBFRAMES = 16
SIZE, FOCAL = (96, 6), 48.0
"""A picture 90° wide: f = 48 px."""
WIDE_M, AWAY_M = 0.4, 8.0
LEAN = 1 / SIZE[1]

PAN = (
    "render.size=48x27",
    "render.spp=32",
    "camera.turn=90",
    "view.shutter=180",
    "species.tree.density=0",
    "species.figure.prototypes=1",
)


def camera():
    return camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, 0.0, 90.0, SIZE)


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
    x = np.arange(SIZE[0]) + 0.5
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


def test_the_offsets_have_the_variance_that_the_law_asks_for():
    for n in (1, 2, 16):
        assert subframe_offsets(n).mean() == pytest.approx(0, abs=1e-15)
        assert subframe_offsets(n).var() == pytest.approx((1 - 1 / n**2) / 12)


def test_two_sub_frames_are_the_mean_of_two_frames_and_the_ids_those_of_the_second(make, variant):
    quality = make.quality(variant, 8)
    moments = [(camera(), (bar_at(make, x),)) for x in (-1.0, 1.0)]
    both = blurred(make, moments, quality)
    alone = [blurred(make, [each], quality) for each in moments]
    mean = (alone[0].albedo + alone[1].albedo) / 2
    assert np.allclose(both.albedo.sum(), mean.sum(), rtol=0.06)
    assert (both.object == alone[1].object).mean() > 0.98
    assert both.statistics["subframes"] == 2


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
    still = ("camera.turn=0", "camera.speed=0", "species.sward.density=0")
    walking = (*still, "species.figure.patrol=5")
    first, last = (shot(*walking).subframes[k]() for k in (0, -1))
    names = [each.name for each in first.displayed]
    for name, a, b in zip(names, first.displayed, last.displayed, strict=True):
        if isinstance(a.shape, Sticks):
            moved = np.linalg.norm(b.shape.start - a.shape.start, axis=1)
            assert name == "figure" and 0 < moved.max() < 0.2
        else:
            assert np.array_equal(a.shape.vertices, b.shape.vertices)


def test_motion_vectors_of_a_blurred_frame_point_a_whole_frame_ahead():
    made = shot("output.motion=true")
    moment = made.subframes[8]()
    turned = np.degrees(np.arccos(moment.after.forward @ moment.camera.forward))
    assert turned == pytest.approx(90 / 24 * np.cos(np.radians(1)), rel=1e-3)
    assert isinstance(made.displayed[0], DisplayedRepresentation)
