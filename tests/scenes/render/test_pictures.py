"""Previews have one exposure and a colour for each level, and denoising brings them nearer."""

import sys
from dataclasses import replace

import drjit
import numpy as np
import pytest
from PIL import Image

from lod.errors import InputError
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset
from scenes.render.exr.header import frame_settings, settings_attributes
from scenes.render.exr.layer_file import write_exr
from scenes.render.object_keys import identities
from scenes.render.pictures import (
    KEY,
    LEVELS,
    SKY,
    TONE_CURVES,
    PictureStyle,
    auto_exposure,
    denoise_layers,
    level_colours,
    level_pixels,
    preview_pixels,
    to_srgb_8bit,
    write_contact_sheet,
)
from scenes.render.render import render_frame
from scenes.scene import Scene


def frame(path, value, size=(32, 18)):
    w, h = size
    grey, ids = np.full((h, w, 3), value), np.ones((h, w))
    write_exr(path, Layers(grey, ids, grey * 0, grey * 0, ids, ids, ids), {})
    return path


def test_mid_grey_is_what_the_curve_and_srgb_say():
    """0.18 → Narkowicz 0.2668 → sRGB 0.5537."""
    assert abs(int(to_srgb_8bit(np.full((1, 1, 3), 0.18), 1.0)[0, 0, 0]) - 141) <= 1


def test_exposure_brings_the_log_average_to_the_key():
    assert np.isclose(auto_exposure(np.full((4, 4, 3), 0.03)) * 0.03, KEY)
    assert auto_exposure(np.zeros((4, 4, 3))) == 1.0


def test_a_sheet_exposes_all_frames_alike(tmp_path):
    paths = [frame(tmp_path / f"a.{n:04d}.exr", 0.05 * n) for n in (1, 2, 3)]
    sheet = np.array(Image.open(write_contact_sheet(paths, tmp_path / "s.png")))
    greys = [int(sheet[90, 6 + 160 + k * 326, 0]) for k in range(3)]
    assert greys[0] < greys[1] < greys[2]
    assert not list(tmp_path.glob(".*"))


@pytest.mark.parametrize("tone", list(TONE_CURVES))
def test_tone_curves_rise_from_black_to_white(tone):
    curve = TONE_CURVES[tone](np.linspace(0, 4, 400))
    assert curve[0] == 0 and (np.diff(curve) > 0).all()
    assert to_srgb_8bit(np.full((1, 1, 3), 8.0), 1.0, tone).tolist() == [[[255] * 3]]


def test_linear_is_srgb_and_a_stop_is_a_factor_of_two():
    ramp = np.linspace(0.0, 0.4, 9)[None, :, None].repeat(3, axis=2)
    expected = np.rint(
        255 * np.where(ramp <= 0.0031308, 12.92 * ramp, 1.055 * ramp ** (1 / 2.4) - 0.055)
    )
    assert np.array_equal(to_srgb_8bit(ramp, 1.0, "linear"), expected)
    assert PictureStyle(stops=1.0).exposure_of(ramp) == pytest.approx(2 * auto_exposure(ramp))


@pytest.mark.parametrize("look", [{"tone": "vivid"}, {"stops": float("nan")}, {"stops": 50.0}])
def test_bad_looks_are_refused(look):
    with pytest.raises(InputError, match="--"):
        PictureStyle(**look)


def denoised_frame(make, spp, denoise=False, size=(48, 32)):
    scene = [make.balls([(x, 8.0, 1.0) for x in range(-3, 4)]), make.ground()]
    quality = make.quality("scalar_rgb", spp)
    camera = make.camera(size)
    return render_frame(
        FrameInput(camera, tuple(scene), make.clear, make.light, quality, denoise=denoise)
    )


def test_the_error_falls_and_the_raw_picture_stays(make):
    pytest.importorskip("mitsuba_oidn")
    raw, with_it = (denoised_frame(make, 1, each, (96, 64)) for each in (False, True))
    truth = denoised_frame(make, 256, size=(96, 64)).rgb
    assert raw.denoised is None
    assert np.array_equal(raw.rgb, with_it.rgb)
    assert with_it.denoised.shape == truth.shape and (with_it.denoised >= 0).all()
    before, after = (np.mean((each - truth) ** 2) for each in (raw.rgb, with_it.denoised))
    assert after < before / 4, before / after
    assert with_it.seconds["denoise"] > 0


def test_threads_and_repeats_do_not_matter(make):
    pytest.importorskip("mitsuba_oidn")
    layers, threads = denoised_frame(make, 1), drjit.thread_count()
    try:
        pictures = []
        for count in (1, 2, 3, 2):
            drjit.set_thread_count(count)
            pictures.append(denoise_layers(layers).denoised)
    finally:
        drjit.set_thread_count(threads)
    assert all(np.array_equal(pictures[0], other) for other in pictures[1:])


def test_nothing_bright_or_black_upsets_it(make):
    pytest.importorskip("mitsuba_oidn")
    layers = denoised_frame(make, 1, size=(20, 12))
    rgb = np.array(layers.rgb)
    rgb[:6], rgb[6:] = 0.0, 1e5
    assert np.isfinite(denoise_layers(replace(layers, rgb=rgb)).denoised).all()


def test_without_the_denoiser_the_extra_is_named(make, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba_oidn", None)
    with pytest.raises(InputError, match=r"lodbench\[denoise\]"):
        denoised_frame(make, 1, denoise=True)


def level_frame(width=400, height=200):
    """Sky above, then levels 0 to 15 in columns, all of them facing up."""
    shape = height, width
    level = np.broadcast_to(np.arange(width) * 16 // width, shape)
    normal = np.broadcast_to(np.array((0.0, 0.0, 1.0)), (*shape, 3))
    met = np.broadcast_to(np.arange(height)[:, None] >= 50, shape)
    grey, depth = np.full((*shape, 3), 0.2), np.full(shape, 5.0)
    level = np.where(met, level, 0)
    return Layers(grey, depth, normal, grey, met.astype(int), level, level)


def test_every_level_has_its_colour_and_the_sky_its_own():
    picture = level_pixels(level_frame())
    assert np.all(picture[:50] == SKY)
    row = picture[100]
    seen = [row[int((level + 0.5) * 400 / 16)] for level in range(16)]
    distinct = np.unique(np.array(seen), axis=0)
    assert len(distinct) == LEVELS
    for level, colour in enumerate(seen):
        ratio = colour.sum() / level_colours()[min(level, LEVELS - 1)].sum()
        assert ratio == pytest.approx(0.7 + 0.3 * 0.7 / np.sqrt(1.01), abs=0.05)


def test_the_look_chooses():
    layers = level_frame()
    assert np.array_equal(
        preview_pixels(layers, PictureStyle(view="level"), 1.0, {}), level_pixels(layers)
    )
    assert not np.array_equal(preview_pixels(layers, PictureStyle(), 1.0, {}), level_pixels(layers))
    with pytest.raises(InputError, match="colour, level"):
        PictureStyle(view="depth")
    with pytest.raises(InputError, match="a frame that lodbench made"):
        preview_pixels(layers, PictureStyle(view="species"), 1.0, {})


def test_species_have_hues_of_their_own_and_fine_levels_are_light(tmp_path):
    """Columns of pixels show one object each: figures are blue, rabbits orange, all else grey."""
    path = tmp_path / "a.toml"
    path.write_text(
        "[terrain]\nreach = 100\n[species.figure]\nmodel = 'figure'\ndensity = 0.02\n"
        "prototypes = 1\n[species.rabbit]\nmodel = 'rabbit'\ndensity = 0.05\nprototypes = 1\n"
        "[placed.joe]\nmodel = 'figure'\nposition = [0.0, 4.0]\n[render]\nsize = '96x54'\n"
    )
    preset = load_preset(str(path))
    known = {each.of: each.object for each in identities(Scene(preset), 1)}
    ids = np.repeat([0, *(known[name] for name in ("figure", "rabbit", "joe", "terrain"))], 80)
    shape, level = (200, 400), np.repeat([0, 3], 100)[:, None]
    above, grey = np.array((0.0, 0.0, 1.0)), np.full((*shape, 3), 0.2)
    rows = (np.broadcast_to(each, shape) for each in (ids, level, level))
    layers = Layers(grey, grey[..., 0], np.broadcast_to(above, grey.shape), grey, *rows)
    header = settings_attributes(frame_settings(preset, "scalar_rgb"), 1)
    shown = preview_pixels(layers, PictureStyle(view="species"), 1.0, header).astype(int)
    for coarse, fine in zip(shown[50, 120::80], shown[150, 120::80], strict=True):
        assert fine.sum() > 1.2 * coarse.sum()
    for red, green, blue in (shown[50, 120], shown[150, 120]):
        assert red < green < blue
    for red, green, blue in (shown[50, 200], shown[150, 200]):
        assert red > green > blue
    other = shown[:180, 240:]
    assert np.all(other == other[..., :1])
    assert np.all(shown[:180, :80] == SKY)
