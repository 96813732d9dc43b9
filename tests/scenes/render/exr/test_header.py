"""A header says what made the frame, in types that other programs read, and whether it is whole."""

import operator
import tempfile
from fractions import Fraction
from pathlib import Path

import numpy as np
import OpenImageIO as oiio
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from scenes.frame.layers import Layers
from scenes.presets.load import load_preset, preset_from, preset_names
from scenes.presets.schema import OutputPreset
from scenes.render.exr import layer_file as exr
from scenes.render.exr.frames_on_disk import read_whole, settings_hash
from scenes.render.exr.header import (
    frame_header,
    frame_settings,
    preset_from_settings,
    settings_attributes,
    settings_in,
)
from scenes.render.exr.layer_file import read_header, write_exr

EYE = np.array([1.25, 2.0, 3.0])
SIZE = (9, 5)


def camera(corner=(-3, 5), size=SIZE, fov=60.0):
    return camera_from_heading(Corner(*corner), EYE, 30, -5, fov, size)


def some_layers(size=SIZE):
    shape = size[::-1]
    colour = np.random.default_rng(0).random((*shape, 3))
    ids = np.arange(shape[0] * shape[1]).reshape(shape)
    return Layers(colour, ids + 0.5, colour, colour, ids, ids, ids)


def written(folder, settings, frame=7, fps=23.976, **about):
    """The header that a file has."""
    path = Path(folder) / "a.exr"
    header = frame_header(camera(**about), fps, settings, frame)
    write_exr(path, some_layers(), header)
    return read_header(path)


def test_the_eye_is_where_it_is_whatever_table_of_a_preset_is_called_so(tmp_path):
    for eye in ({}, {"eye": {"blur_arcmin": 0.7}}):
        settings = frame_settings(preset_from(eye), "scalar_rgb")
        header = written(tmp_path, settings)
        assert header["lod:eye"].tolist() == EYE.tolist()
        assert settings_in(header) == settings
        (tmp_path / "a.exr").unlink()


def test_numbers_are_numbers(tmp_path):
    settings = {"seed": 7, "air": {"on": True, "none": None}, "size": [640, 360], "fov": 0.1}
    header = written(tmp_path, {**settings, "at": [0.1, 2.0], "large": 2**63 - 1, "many": [1] * 4})
    assert header["lod:frame"] == 7 and header["lod:preset.seed"] == 7
    assert header["lod:preset.size"].dtype == np.int32
    assert header["lod:preset.at"].tolist() == [0.1, 2.0]
    assert header["lod:preset.fov"].tolist() == [0.1] != np.float32(0.1)
    assert header["lod:corner"].tolist() == [-3, 5]
    assert header["lod:preset.large"] == "9223372036854775807"
    assert header["lod:preset.air.on"] == "true" and header["lod:preset.air.none"] == "null"
    assert header["lod:preset.many"] == "[1, 1, 1, 1]"
    assert header["framesPerSecond"] == Fraction(2997, 125)
    assert np.allclose(header["chromaticities"], exr.REC709)
    spec = oiio.ImageInput.open(str(tmp_path / "a.exr")).spec()
    types = {"seed": "int", "fov": "double", "size": "vector2i", "at": "double2"}
    for name, type_ in types.items():
        (found,) = (each for each in spec.extra_attribs if each.name == f"lod:preset.{name}")
        assert str(found.type) in (type_, type_.replace("double2", "vector2d")), name


def test_no_attribute_is_there_twice(tmp_path):
    written(tmp_path, frame_settings(load_preset("zoo"), "scalar_rgb"))
    raw = (tmp_path / "a.exr").read_bytes()
    names, at = [], 8
    while raw[at]:
        name, kind, rest = raw[at:].split(b"\0", 2)
        at += len(name) + len(kind) + 6 + int.from_bytes(rest[:4], "little")
        names.append(name.decode())
    assert len(names) == len(set(names)) > 100 and "lod:eye" in names


@pytest.mark.parametrize("name", [name for name, _ in preset_names()])
def test_the_settings_of_every_preset_come_back_with_their_hash(tmp_path, name):
    settings = frame_settings(load_preset(name), "llvm_ad_rgb")
    back = settings_in(written(tmp_path, settings))
    assert back == settings and settings_hash(back) == settings_hash(settings)
    assert read_whole(tmp_path / "a.exr")[:2] == (7, settings)


def test_the_camera_matrices_are_those_that_openexr_documents(tmp_path):
    """Right, up and +z ahead; the picture from (0, 0), upper left, to (1, 1)."""
    header, seen = written(tmp_path, {}), camera((0, 0))
    ahead = np.append(EYE + seen.forward, 1)
    at = {"right": seen.right, "up": seen.up, "ahead": seen.forward}
    for (name, way), axis in zip(at.items(), np.eye(3), strict=True):
        point = np.append(EYE + way, 1) @ header["worldToCamera"]
        assert np.allclose(point, (*axis, 1), atol=1e-6), name
    x, y = seen.tan_half
    corners = {(0, 0): (-x, y), (1, 0): (x, y), (1, 1): (x, -y), (0.5, 0.5): (0, 0)}
    for expected, (across, up) in corners.items():
        point = ahead[:3] + across * seen.right + up * seen.up
        found = np.append(point, 1) @ header["worldToNDC"]
        assert np.allclose(found[:2] / found[3], expected, atol=1e-6)


@pytest.mark.parametrize("fov", [0.1, 60.0, 90.0, 170.0])
def test_the_screen_window_is_as_wide_as_the_picture_at_distance_one(tmp_path, fov):
    width = written(tmp_path, {}, fov=fov)["screenWindowWidth"]
    assert width == pytest.approx(2 * np.tan(np.radians(fov / 2)), rel=1e-6)


TIMES = [
    (24.0, 1, (0, 0, 0, 0)),
    (24.0, 25, (0, 0, 1, 0)),
    (24000 / 1001, 24 * 3661 + 6, (1, 1, 1, 5)),
    (30.0, 30 * 86400 + 2, (0, 0, 0, 1)),
    (12.5, 26, None),
    (60.0, 61, None),
]


@pytest.mark.parametrize(("fps", "frame", "code"), TIMES)
def test_the_shot_tells_the_time(tmp_path, fps, frame, code):
    made = frame_header(camera(), fps, {}, frame)
    write_exr(tmp_path / "a.exr", some_layers(), made)
    header = read_header(tmp_path / "a.exr")
    assert ("timeCode" in header) == (code is not None)
    if code:
        found = header["timeCode"]
        assert (found.hours, found.minutes, found.seconds, found.frame) == code


VALUES = (
    st.integers()
    | st.floats(allow_nan=False)
    | st.text(max_size=40)
    | st.booleans()
    | st.none()
    | st.sampled_from(["null", "[1]", "7", "NaN", '"x"', "-0", "Infinity", "[" * 10_000])
    | st.lists(st.integers(-(2**40), 2**40), max_size=4)
    | st.lists(st.floats(allow_nan=False), max_size=4)
    | st.lists(st.dictionaries(st.text(max_size=4), st.integers(), max_size=2), max_size=2)
)
KEYS = st.text("abcdefgh-_é", min_size=1, max_size=20)


@given(
    settings=st.dictionaries(KEYS, VALUES | st.dictionaries(KEYS, VALUES, max_size=3), max_size=6),
    frame=st.integers(0, 2**31 - 1),
    fps=st.floats(0.001, 1000),
    cell=st.tuples(*[st.integers(-(2**55), 2**55)] * 2),
)
@hypothesis_settings(max_examples=60, deadline=None)
def test_any_header_survives_the_round_trip(settings, frame, fps, cell):
    header = frame_header(camera(cell), fps, settings, frame)
    with tempfile.TemporaryDirectory() as folder:
        write_exr(Path(folder) / "a.exr", some_layers(), header)
        found, back = read_whole(Path(folder) / "a.exr"), read_header(Path(folder) / "a.exr")
    assert found[:2] == (frame, {"software": header["software"], **settings})
    header.pop("timeCode", None)
    for name, value in header.items():
        same = np.array_equal if isinstance(value, np.ndarray) else operator.eq
        assert same(back[name], value), name


@pytest.mark.parametrize("multipart", [False, True])
def test_no_changed_byte_passes(tmp_path, multipart):
    """Not even those of names whose attributes have a default, and so are read as before."""
    settings, path = frame_settings(preset_from({}), "scalar_rgb"), tmp_path / "a.exr"
    write_exr(
        path, some_layers(), settings_attributes(settings, 7), OutputPreset(multipart=multipart)
    )
    assert read_whole(path)[:2] == (7, settings)
    whole = path.read_bytes()
    for at in range(0, len(whole), 23):
        path.write_bytes(whole[:at] + bytes([whole[at] ^ (1 << at % 8)]) + whole[at + 1 :])
        with pytest.raises(InputError):
            read_whole(path)
    for size in (0, 1, 100, 1000, len(whole) - 1):
        path.write_bytes(whole[:size])
        with pytest.raises(InputError):
            read_whole(path)


def test_a_table_and_a_value_of_one_name_do_not_meet():
    header = settings_attributes({"a": {"b": 1}}, 1) | {"lod:preset.a": 3}
    assert settings_in(header)["a"] == {"b": 1}


def reversed_tables(table):
    return {
        name: reversed_tables(each) if isinstance(each, dict) else each
        for name, each in reversed(table.items())
    }


def test_settings_of_one_hash_number_their_species_alike():
    # Ids of objects count species by species: one hash must not stand for two frames.
    settings = frame_settings(load_preset("zoo"), "scalar_rgb")
    other = reversed_tables(settings)
    assert settings_hash(other) == settings_hash(settings)
    orders = [list(preset_from_settings(each).species) for each in (settings, other)]
    assert orders[0] == orders[1] == sorted(orders[0]) == list(load_preset("zoo").species)


def test_settings_of_another_version_say_which_and_what_is_otherwise():
    settings = frame_settings(load_preset("meadow"), "scalar_rgb")
    settings = {**settings, "camera": {**settings["camera"], "tilt": 1.0}}
    older = {**settings, "software": "lodbench 0.1 (Mitsuba 3.0)"}
    with pytest.raises(InputError, match=r"settings: camera\.tilt"):
        preset_from_settings(settings)
    said = (
        r"frame: 'lodbench 0\.1 .*': settings of lodbench .*\(settings: camera\.tilt: .*render it"
    )
    with pytest.raises(InputError, match=said):
        preset_from_settings(older)
