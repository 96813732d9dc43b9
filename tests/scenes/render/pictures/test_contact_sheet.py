"""Previews: a stated transform, one exposure for a whole sheet."""

import numpy as np
import pytest
from PIL import Image

from lod.errors import InputError
from scenes.frame.layers import Layers
from scenes.render.files.exr import write_exr
from scenes.render.pictures.contact_sheet import contact_sheet, default_columns, preview
from scenes.render.pictures.tone_map import (
    KEY,
    TONE_CURVES,
    PictureStyle,
    auto_exposure,
    to_srgb_8bit,
)


def frame(path, value, size=(32, 18)):
    w, h = size
    grey, ids = np.full((h, w, 3), value), np.ones((h, w))
    write_exr(path, Layers(grey, ids, grey * 0, grey * 0, ids, ids, ids), {})
    return path


def test_display_is_monotone_black_to_white():
    ramp = np.linspace(0, 50, 2000).reshape(1, -1, 1).repeat(3, axis=2)
    shown = to_srgb_8bit(ramp, 1.0)
    assert shown.dtype == np.uint8 and shown[0, 0, 0] == 0 and shown[0, -1, 0] == 255
    assert (np.diff(shown[0, :, 0].astype(int)) >= 0).all()


def test_mid_grey_is_what_the_curve_and_srgb_say():
    """0.18 → Narkowicz 0.2668 → sRGB 0.5537."""
    assert abs(int(to_srgb_8bit(np.full((1, 1, 3), 0.18), 1.0)[0, 0, 0]) - 141) <= 1


def test_exposure_brings_the_log_average_to_the_key():
    assert np.isclose(auto_exposure(np.full((4, 4, 3), 0.03)) * 0.03, KEY)
    assert auto_exposure(np.zeros((4, 4, 3))) == 1.0


def test_a_sheet_exposes_all_frames_alike(tmp_path):
    paths = [frame(tmp_path / f"a.{n:04d}.exr", 0.05 * n) for n in (1, 2, 3)]
    sheet = np.array(Image.open(contact_sheet(paths, tmp_path / "s.png", columns=3, width=64)))
    greys = [int(sheet[20, 6 + 35 + k * 70, 0]) for k in range(3)]
    assert greys[0] < greys[1] < greys[2]
    assert not list(tmp_path.glob(".*"))


def test_a_sheet_has_room_for_every_frame_and_its_number(tmp_path):
    paths = [frame(tmp_path / f"a.{n:04d}.exr", 0.2) for n in range(5)]
    wide = Image.open(contact_sheet(paths, tmp_path / "s.png", width=64))
    assert default_columns(5) in (3, 5) and wide.width >= 3 * 64
    ink = np.array(wide)[6 + 36 : 6 + 36 + 20, :64].max()
    assert ink > 150


def test_a_single_preview_keeps_its_size(tmp_path):
    path = frame(tmp_path / "a.0001.exr", 0.2)
    assert Image.open(preview(path, tmp_path / "p.png")).size == (32, 18)


def test_no_frames_and_bad_exposure(tmp_path):
    with pytest.raises(InputError):
        contact_sheet([], tmp_path / "s.png")
    with pytest.raises(InputError, match="exposure"):
        to_srgb_8bit(np.zeros((1, 1, 3)), float("nan"))


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
