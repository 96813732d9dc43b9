"""Mattes are read back by a decoder written from Cryptomatte's specification 1.2.0."""

import json
import os
import struct
import subprocess
from dataclasses import replace

import mitsuba as mi
import numpy as np
import OpenEXR
import pytest

from lod.air import Air
from scenes.frame.layers import Layers, add_coverage
from scenes.preset.tables import OutputPreset
from scenes.render.files.cryptomatte import CHANNELS, RANKS, matte_id, with_mattes
from scenes.render.files.exr import channel_types, read_pixels, write_exr
from scenes.render.mitsuba import variants
from scenes.render.pipeline.render import render_frame

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
    assert tuple(channels) == CHANNELS
    for kind in ("CryptoObject", "CryptoSpecies"):
        own = [each for each in CHANNELS if each.startswith(kind)]
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


def test_readers_open_it_by_their_plain_calls(tmp_path):
    layers, names = covered()
    write_exr(tmp_path / "a.exr", with_mattes(layers, names), {})
    assert "RGBA" in OpenEXR.File(str(tmp_path / "a.exr")).channels()
    mi.set_variant("scalar_rgb")
    assert "CryptoObject00" in dict(mi.Bitmap(str(tmp_path / "a.exr")).split())


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
