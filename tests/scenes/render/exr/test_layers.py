"""Frames survive the round trip in three readers, damage does not pass, and mattes are decoded."""

import contextlib
import hashlib
import json
import os
import struct
import subprocess
from dataclasses import replace

import numpy as np
import OpenImageIO as oiio
import pytest

from lod.air import Air
from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from scenes.frame.layers import SKY_Z, Layers, add_coverage
from scenes.presets.schema import OutputPreset
from scenes.render import variants
from scenes.render.exr import layer_file as exr
from scenes.render.exr.header import frame_header, picture_windows
from scenes.render.exr.layer_file import (
    MATTE_CHANNELS,
    PIXELS_SHA256,
    RANKS,
    channel_types,
    matte_id,
    pixels_digest,
    read_exr,
    read_header,
    read_pixels,
    with_mattes,
    write_exr,
)
from scenes.render.render import render_frame

SHAPE = (5, 7)


def murmur(data, seed=0):
    """MurmurHash3_x86_32, as Appleby published it."""

    def turned(x, by):
        return (x << by | x >> 32 - by) & 0xFFFFFFFF

    hashed = seed
    for at in range(0, len(data), 4):
        word = int.from_bytes(data[at : at + 4], "little") * 0xCC9E2D51 & 0xFFFFFFFF
        hashed ^= turned(word, 15) * 0x1B873593 & 0xFFFFFFFF
        if at + 4 <= len(data):
            hashed = (turned(hashed, 13) * 5 + 0xE6546B64) & 0xFFFFFFFF
    hashed ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        hashed = (hashed ^ hashed >> shift) * factor & 0xFFFFFFFF
    return hashed


def mm3hash_float(name):
    """The specification's own example, with the hash above."""
    hash_32 = murmur(name.encode())
    exponent = hash_32 >> 23 & 255
    if exponent in (0, 255):
        hash_32 ^= 1 << 23
    return struct.unpack("<f", struct.pack("<L", hash_32))[0]


def decode(path):
    """Mattes by type and name: the coverage of all ranks that have the name's id."""
    pixels, header = read_pixels(path)
    found = {}
    for attribute, name in header.items():
        if not (attribute.startswith("cryptomatte/") and attribute.endswith("/name")):
            continue
        key = attribute.removesuffix("name")
        assert len(key) <= len("cryptomatte/1234567/")
        assert header[key + "hash"] == "MurmurHash3_32"
        assert header[key + "conversion"] == "uint32_to_float32"
        ranks = [
            (pixels[f"{name}{layer:02d}.{i}"], pixels[f"{name}{layer:02d}.{c}"])
            for layer in range(100)
            if f"{name}{layer:02d}.r" in pixels
            for i, c in ("rg", "ba")
        ]
        found[name] = {
            each: sum(
                np.where(ids == np.float32(mm3hash_float(each)), share, 0) for ids, share in ranks
            )
            for each in json.loads(header[key + "manifest"])
        }
    return found


def covered(seed=0, objects=40):
    """Layers whose pixels show up to eight objects, and their names."""
    generator = np.random.default_rng(seed)
    pixel = np.repeat(np.arange(SHAPE[0] * SHAPE[1]), 8)
    share = generator.dirichlet(np.ones(8), SHAPE[0] * SHAPE[1]).ravel()
    coverage = add_coverage(pixel, generator.integers(0, objects, len(pixel)), share)
    blank, ids = np.zeros((*SHAPE, 3)), np.zeros(SHAPE)
    names = {i: (f"tree_{i}_-3", f"kind é{i % 3}") for i in range(1, objects)}
    layers = Layers(blank, ids, blank, blank, ids, ids, ids, coverage=coverage)
    return layers, names


def test_the_examples_of_the_specification():
    for name, hashed, value in (
        ("torus", 4053562365, -1.54943624832e30),
        ("равнина", 2518896926, -1.31926312124e-25),
    ):
        assert murmur(name.encode()) == hashed == matte_id(name)
        assert mm3hash_float(name) == pytest.approx(value, rel=1e-6)


def test_no_id_is_a_number_that_programs_stumble_on():
    names = [f"tree_{i}" for i in range(20_000)]
    values = np.array([matte_id(each) for each in names], np.uint32).view(np.float32)
    assert np.isfinite(values).all() and (np.abs(values) >= np.finfo(np.float32).tiny).all()
    assert values.tolist() == [mm3hash_float(each) for each in names]
    assert any(murmur(each.encode()) != matte_id(each) for each in names)


@pytest.mark.parametrize("multipart", [False, True])
def test_mattes_come_back(tmp_path, multipart):
    layers, names = covered()
    output = OutputPreset(multipart=multipart, cryptomatte=True)
    write_exr(tmp_path / "a.exr", with_mattes(layers, names), {}, output)
    pixels, _ = read_pixels(tmp_path / "a.exr")
    assert {name: each.dtype for name, each in pixels.items()} == channel_types(output)
    found, coverage = decode(tmp_path / "a.exr"), layers.coverage
    for number, kind in enumerate(("CryptoObject", "CryptoSpecies")):
        shares = {}
        for pixel, thing, share in zip(
            coverage.pixel.tolist(), coverage.object.tolist(), coverage.share, strict=True
        ):
            if thing:
                row = shares.setdefault(pixel, {})
                row[names[thing][number]] = row.get(names[thing][number], 0) + share
        assert set(found[kind]) == {name for row in shares.values() for name in row}
        for pixel, row in shares.items():
            first = dict(sorted(row.items(), key=lambda each: -each[1])[:RANKS])
            for name, matte in found[kind].items():
                assert matte.flat[pixel] == pytest.approx(first.get(name, 0), abs=1e-6)


def test_ranks_fall_and_what_is_not_there_is_zero(tmp_path):
    layers, names = covered()
    channels = with_mattes(layers, names).mattes.channels
    assert tuple(channels) == MATTE_CHANNELS
    for kind in ("CryptoObject", "CryptoSpecies"):
        own = [each for each in MATTE_CHANNELS if each.startswith(kind)]
        shares = np.array([channels[name] for name in own[1::2]])
        ids = np.array([channels[name] for name in own[0::2]])
        assert (np.diff(shares, axis=0) <= 0).all() and ((ids == 0) == (shares == 0)).all()
        assert (shares.sum(axis=0) <= 1 + 1e-6).all()


def test_a_picture_of_sky_has_mattes_of_nothing(tmp_path):
    layers, _ = covered()
    pixel = np.arange(35)
    sky = replace(layers, coverage=add_coverage(pixel, pixel * 0, np.ones(35)))
    write_exr(tmp_path / "a.exr", with_mattes(sky, {}), {})
    assert decode(tmp_path / "a.exr") == {"CryptoObject": {}, "CryptoSpecies": {}}


@pytest.mark.parametrize(
    "wanted", [variants.SCALAR_VARIANT, variants.JIT_VARIANT, "subframes", "medium"]
)
def test_coverage_is_the_share_of_a_pixel(make, wanted):
    """A wall's edge goes through the middle of a column of pixels: half of each is sky."""
    variant = variants.JIT_VARIANT if wanted == variants.JIT_VARIANT else variants.SCALAR_VARIANT
    edge = 10 * np.tan(np.radians(30)) * (2 * 10.5 / 16 - 1)
    wall = make.quad([(-9, 10, -9), (edge, 10, -9), (edge, 10, 19), (-9, 10, 19)], name="wall")
    seen = make.frame(wall, variant=variant)
    quality = replace(seen.quality, spp=16, coverage=True)
    if wanted == "medium":
        quality, seen = replace(quality, haze="medium"), replace(seen, air=Air(20_000.0))
    seen = replace(seen, quality=quality)
    if wanted == "subframes":
        seen = replace(seen, subframes=(lambda: seen_still, lambda: seen_still))
    seen_still = replace(seen, subframes=())
    coverage = render_frame(seen).coverage
    share = np.zeros((2, 8, 16))
    share[coverage.object, coverage.pixel // 16, coverage.pixel % 16] = coverage.share
    assert np.allclose(share.sum(axis=0), 1)
    assert (share[1, :, :10] == 1).all() and (share[0, :, 11:] == 1).all()
    if wanted != "medium":  # whose guide is one sample
        assert np.allclose(share[1, :, 10], 0.5, atol=0.13)
    assert set(np.unique(share[1] * 16)) <= set(range(17))


BLENDER = """
import sys, bpy
path, kind, name, width, height, out = sys.argv[1:]
tree = bpy.data.node_groups.new("matte", "CompositorNodeTree")
tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
node = tree.nodes.new("CompositorNodeCryptomatteV2")
node.source, node.image = "IMAGE", bpy.data.images.load(path)
node.layer_name, node.matte_id = kind, name
tree.links.new(node.outputs["Matte"], tree.nodes.new("NodeGroupOutput").inputs[0])
scene = bpy.context.scene
scene.compositing_node_group = tree
scene.camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
scene.collection.objects.link(scene.camera)
scene.render.engine, scene.cycles.samples = "CYCLES", 1
scene.render.resolution_x, scene.render.resolution_y = int(width), int(height)
scene.render.resolution_percentage = 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = out
bpy.ops.render.render(write_still=True)
"""


@pytest.mark.slow
@pytest.mark.skipif("LODBENCH_BPY" not in os.environ, reason="LODBENCH_BPY names no Python")
@pytest.mark.parametrize(
    ("kind", "name"), [("CryptoObject", "tree_7_-3"), ("CryptoSpecies", "kind é1")]
)
def test_blender_pulls_the_same_matte(tmp_path, kind, name):
    """How to have its Python: test_other_programs.py."""
    layers, names = covered()
    path, out = tmp_path / "a.exr", tmp_path / "matte.exr"
    write_exr(path, with_mattes(layers, names), {})
    size = (str(SHAPE[1]), str(SHAPE[0]))
    command = [os.environ["LODBENCH_BPY"], "-c", BLENDER, str(path), kind, name, *size, str(out)]
    subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    wanted = decode(path)[kind][name]
    assert wanted.max() > 0.1 and np.allclose(read_pixels(out)[0]["R"], wanted, atol=1e-6)


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


OUTPUTS = [OutputPreset(compression=each) for each in ("piz", "none")]
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


@pytest.mark.parametrize("compression", ["zip", "zips", "none"])
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
