"""Frames survive the round trip, in three readers, and damage does not pass for a frame."""

import contextlib
import hashlib
import os
import struct
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from scenes.frame.layers import SKY_Z, Layers
from scenes.preset.tables import OutputPreset
from scenes.render.files import exr
from scenes.render.files.digests import PIXELS_SHA256, pixels_digest
from scenes.render.files.exr import read_exr, read_header, read_pixels, write_exr
from scenes.render.files.header import frame_header, picture_windows


def some_layers(size=(9, 5), seed=0):
    generator = np.random.default_rng(seed)
    w, h = size
    ids = generator.integers(0, 2**32, (3, h, w), dtype=np.uint32)
    return Layers(
        rgb=generator.uniform(0, 3, (h, w, 3)),
        Z=np.where(generator.random((h, w)) < 0.3, SKY_Z, generator.uniform(0.1, 5e4, (h, w))),
        N=generator.uniform(-1, 1, (h, w, 3)),
        albedo=generator.uniform(0, 1, (h, w, 3)),
        object=ids[0],
        part=ids[1],
        level=ids[2],
    )


def with_extras(layers):
    """The same layers with motion and a denoised picture."""
    motion = np.dstack([layers.Z * 1e-3, -layers.Z])
    return replace(layers, motion=motion, denoised=layers.rgb / 2)


def some_header(**settings):
    camera = camera_from_heading(Corner(-3, 2**50), np.array([1.0, 2.0, 3.0]), 30, -5, 60, (9, 5))
    return frame_header(camera, 23.976, settings, 7)


def test_layers_come_back(tmp_path):
    layers = some_layers()
    digest = write_exr(tmp_path / "a.exr", layers, some_header())
    back, _ = read_exr(tmp_path / "a.exr")
    for name in ("rgb", "albedo", "Z", "object", "part", "level"):
        assert np.array_equal(getattr(back, name), getattr(layers, name))
    assert np.array_equal(back.N, layers.N.astype(np.float16))
    assert len(digest) == 64 and sorted(p.name for p in tmp_path.iterdir()) == ["a.exr"]


def test_a_rational_without_a_denominator_is_no_header(tmp_path):
    write_exr(tmp_path / "a.exr", some_layers(), some_header())
    data, key = (tmp_path / "a.exr").read_bytes(), b"framesPerSecond\0rational\0"
    at = data.index(key) + len(key) + 8  # after the length of the value and its numerator
    (tmp_path / "a.exr").write_bytes(data[:at] + bytes(4) + data[at + 4 :])
    with pytest.raises(InputError, match="readable OpenEXR"):
        read_header(tmp_path / "a.exr")


def test_same_layers_same_bytes(tmp_path):
    first = write_exr(tmp_path / "a.exr", some_layers(), some_header(x=1))
    again = write_exr(tmp_path / "b.exr", some_layers(), some_header(x=1))
    other = write_exr(tmp_path / "c.exr", some_layers(), some_header(x=2))
    assert first == again != other


OUTPUTS = [OutputPreset(compression=each) for each in ("zips", "piz", "rle", "none")]
OUTPUTS += [OutputPreset(multipart=True), OutputPreset(multipart=True, colour="half")]


@pytest.mark.parametrize("output", OUTPUTS)
def test_every_form_of_file_gives_the_same_layers_back(tmp_path, output):
    layers, header = with_extras(some_layers()), some_header(seed=2**63 - 1)
    write_exr(tmp_path / "plain.exr", layers, header, output=OutputPreset(colour=output.colour))
    write_exr(tmp_path / "a.exr", layers, header, output=output)
    (plain, _), (back, kept) = (read_exr(tmp_path / name) for name in ("plain.exr", "a.exr"))
    for name in ("rgb", "Z", "N", "albedo", "object", "part", "level", "motion", "denoised"):
        assert np.array_equal(getattr(back, name), getattr(plain, name)), name
    assert kept["lod:preset.seed"] == "9223372036854775807"


def test_half_rounds_colour_and_nothing_else(tmp_path):
    layers = with_extras(some_layers())
    write_exr(tmp_path / "a.exr", layers, some_header(), output=OutputPreset(colour="half"))
    back, _ = read_exr(tmp_path / "a.exr")
    for name in ("rgb", "albedo", "denoised"):
        assert np.array_equal(getattr(back, name), getattr(layers, name).astype(np.float16))
    for name in ("Z", "motion", "object", "part", "level"):
        assert np.array_equal(getattr(back, name), getattr(layers, name))


def test_parts_are_named_for_their_layers_and_each_says_what_made_it(tmp_path):
    layers = with_extras(some_layers())
    write_exr(tmp_path / "a.exr", layers, some_header(seed=7), output=OutputPreset(multipart=True))
    file, parts = oiio.ImageInput.open(str(tmp_path / "a.exr")), {}
    while file.seek_subimage(len(parts), 0):
        spec = file.spec()
        parts[spec.getattribute("name")] = set(spec.channelnames)
        assert spec.getattribute("lod:preset.seed") == 7
    assert parts == {
        "rgba": set("RGBA"),
        "depth": {"Z"},
        "N": {"N.X", "N.Y", "N.Z"},
        "albedo": {"albedo.R", "albedo.G", "albedo.B"},
        "id": {"id.object", "id.part", "detail.level"},
        "motion": {"motion.X", "motion.Y"},
        "denoised": {"denoised.R", "denoised.G", "denoised.B"},
    }


@pytest.mark.parametrize("output", OUTPUTS)
def test_every_header_has_the_hash_of_the_pixels_in_its_file(tmp_path, output):
    write_exr(tmp_path / "a.exr", with_extras(some_layers()), some_header(), output)
    pixels, header = read_pixels(tmp_path / "a.exr")
    assert header[PIXELS_SHA256] == pixels_digest(pixels) == written_out(pixels)
    assert set(read_header(tmp_path / "a.exr")) == set(header)
    alone = OutputPreset(colour=output.colour)
    write_exr(tmp_path / "b.exr", with_extras(some_layers()), some_header(), alone)
    assert read_header(tmp_path / "b.exr")[PIXELS_SHA256] == header[PIXELS_SHA256]


def written_out(pixels):
    """As docs/exr.md says it."""
    types = {"e": "half", "f": "float", "I": "uint"}
    digest = hashlib.sha256()
    for name, values in sorted(pixels.items()):
        digest.update(f"{name}\n{types[values.dtype.char]}\n".encode())
        for row in values:
            digest.update(struct.pack(f"<{len(row)}{values.dtype.char}", *row.tolist()))
    return digest.hexdigest()


@pytest.mark.parametrize("compression", ["zip", "zips", "piz", "rle", "none"])
def test_no_changed_pixel_agrees_with_its_header(tmp_path, compression):
    """And zip notices every change of a pixel by itself; a few bits of its stream mean nothing."""
    path, output = tmp_path / "a.exr", OutputPreset(compression=compression)
    write_exr(path, some_layers((64, 48)), some_header(), output)
    whole, generator, passed = path.read_bytes(), np.random.default_rng(1), 0
    right, _ = read_pixels(path)
    for at in generator.integers(len(whole) // 4, len(whole), 60).tolist():
        path.write_bytes(whole[:at] + bytes([whole[at] ^ 16]) + whole[at + 1 :])
        with contextlib.suppress(InputError):
            pixels, header = read_pixels(path)
            same = all(np.array_equal(pixels[name], right[name]) for name in right)
            assert same == (header[PIXELS_SHA256] == pixels_digest(pixels))
            passed += not same
    assert (passed > 0) == (compression not in ("zip", "zips"))


def test_a_sun_in_the_picture_does_not_become_infinite(tmp_path):
    layers = some_layers()
    rgb = layers.rgb.copy()
    rgb[0, 0] = 1e6
    bright = Layers(
        rgb, layers.Z, layers.N, layers.albedo, layers.object, layers.part, layers.level
    )
    write_exr(tmp_path / "a.exr", bright, some_header(), OutputPreset(colour="half"))
    assert np.isfinite(read_exr(tmp_path / "a.exr")[0].rgb).all()


def test_what_stands_there_is_not_touched(tmp_path):
    path = tmp_path / "a.exr"
    path.write_text("before")
    with pytest.raises(FileExistsError):
        write_exr(path, some_layers(), some_header())
    assert path.read_text() == "before"


def test_a_failed_write_leaves_nothing(tmp_path, monkeypatch):
    def refuse(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", refuse)
    with pytest.raises(OSError, match="No space left"):
        write_exr(tmp_path / "a.exr", some_layers(seed=1), some_header())
    assert list(tmp_path.iterdir()) == []


def test_a_file_whose_end_was_not_kept_is_noticed(tmp_path, monkeypatch):
    """The library closes its file without asking whether the last bytes were written."""
    really = exr._write

    def lose_the_end(path, *rest):
        really(path, *rest)
        os.truncate(path, path.stat().st_size - 1)

    monkeypatch.setattr(exr, "_write", lose_the_end)
    with pytest.raises(OSError, match="not kept whole"):
        write_exr(tmp_path / "a.exr", some_layers(), some_header())
    assert list(tmp_path.iterdir()) == []


def test_writing_into_a_folder_that_is_gone_says_so(tmp_path):
    with pytest.raises(FileNotFoundError, match="gone"):
        write_exr(tmp_path / "gone" / "a.exr", some_layers(), some_header())


def cut_to(share):
    return lambda whole: whole[: int(len(whole) * share)]


def flip_a_bit(whole):
    middle = len(whole) // 2
    return whole[:middle] + bytes([whole[middle] ^ 4]) + whole[middle + 1 :]


DAMAGE = [cut_to(0), cut_to(0.01), cut_to(0.3), cut_to(0.9), cut_to(0.9999), flip_a_bit]


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_files_are_refused_without_a_word_on_stdout(tmp_path, damage, capfd):
    path = tmp_path / "a.exr"
    write_exr(path, some_layers((64, 64)), some_header())
    path.write_bytes(damage(path.read_bytes()))
    with pytest.raises(InputError, match=r"a\.exr"):
        read_exr(path)
    assert capfd.readouterr().out == ""


def test_a_strange_exr_is_refused(tmp_path):
    pixels = oiio.ImageBuf(oiio.ImageSpec(4, 4, 3, oiio.HALF))
    pixels.write(str(tmp_path / "other.exr"))
    with pytest.raises(InputError, match="missing"):
        read_exr(tmp_path / "other.exr")
    with pytest.raises(InputError, match="exists"):
        read_exr(tmp_path / "absent.exr")


def test_a_crop_lies_where_it_belongs_in_the_picture(tmp_path):
    layers, path = some_layers((9, 5)), tmp_path / "crop.exr"
    write_exr(path, layers, picture_windows((32, 18), (20, 3, 29, 8)))
    np.testing.assert_array_equal(read_exr(path)[0].rgb, layers.rgb)
    image = oiio.ImageBuf(str(path)).spec()
    assert (image.x, image.y, image.width, image.height) == (20, 3, 9, 5)
    assert (image.full_x, image.full_y, image.full_width, image.full_height) == (0, 0, 32, 18)
    assert picture_windows((32, 18), (0, 0, 32, 18)) == {}
