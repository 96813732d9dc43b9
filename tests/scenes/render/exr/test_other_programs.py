"""Frames open in other programs by the call that their manuals begin with, every layer by its name.

Blender comes as a module, ``bpy``, for an environment of its own: LODBENCH_BPY names its Python
(python3.11 -m venv bpy && bpy/bin/pip install bpy; then LODBENCH_BPY=bpy/bin/python make slow).
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import mitsuba as mi
import numpy as np
import OpenEXR
import OpenImageIO as oiio
import pytest

from lod.camera import Corner, camera_from_heading
from scenes.frame.layers import SKY_Z, Layers
from scenes.presets.schema import OutputPreset
from scenes.render.exr.header import frame_header
from scenes.render.exr.layer_file import write_exr

os.environ["OPENCV_IO_ENABLE_OPENEXR"] = "1"  # before its first look at a file

FORMS = {
    "one": OutputPreset(),
    "half": OutputPreset(colour="half"),
    "parts": OutputPreset(multipart=True),
    "half_parts": OutputPreset(multipart=True, colour="half"),
}
IN_BLENDER = {
    "one": {"Combined", "Alpha", "Depth", "N", "albedo", "id", "detail", "motion", "denoised"},
    "parts": {"rgba", "depth", "N", "albedo", "id", "motion", "denoised"},
}
BLENDER = """
import sys, bpy
for path in sys.argv[1:]:
    tree = bpy.data.node_groups.new("c", "CompositorNodeTree")
    node = tree.nodes.new("CompositorNodeImage")
    node.image = bpy.data.images.load(path)
    print("layers", *(output.name for output in node.outputs))
"""


SHAPE = (6, 8)


def full_layers():
    generator, ids = np.random.default_rng(1), np.arange(48).reshape(SHAPE)
    colour = generator.random((*SHAPE, 3))
    Z = np.where(ids % 5 == 0, SKY_Z, 7e4 + ids)
    extras = {"motion": colour[..., :2], "denoised": colour / 2}
    return Layers(colour, Z, colour - 0.5, colour / 3, ids, 70_000 + ids, ids % 4, **extras)


LAYERS = full_layers()


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp("frames")
    camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0, 0, 60, SHAPE[::-1])
    header = frame_header(camera, 24.0, {"seed": 2**63 - 1}, 1)
    for name, form in FORMS.items():
        write_exr(folder / f"{name}.0001.exr", LAYERS, header, form)
    return folder


def same(found, layer, form):
    """Colour to the bit in float files and to half's rounding in half ones."""
    wanted = getattr(LAYERS, layer)
    if FORMS[form].colour == "half":
        wanted = wanted.astype(np.float16)
    return np.array_equal(found, wanted)


@pytest.mark.parametrize("form", FORMS)
def test_openexr_opens_it_by_its_default(files, form):
    parts = OpenEXR.File(str(files / f"{form}.0001.exr")).parts
    assert len(parts) == (7 if FORMS[form].multipart else 1)
    found = {name: each.pixels for part in parts for name, each in part.channels.items()}
    assert same(found["RGBA"][..., :3], "rgb", form) and (found["RGBA"][..., 3] == 1).all()
    assert same(found["albedo"], "albedo", form) and same(found["denoised"], "denoised", form)
    assert np.array_equal(found["Z"], LAYERS.Z)
    assert np.array_equal(found["id.part"], LAYERS.part)
    assert np.array_equal(found["detail.level"], LAYERS.level)


def split(path):
    """What Mitsuba makes of a file: channels by name, and the names of its layers."""
    mi.set_variant("scalar_rgb")
    layers = mi.Bitmap(str(path)).split()
    channels = {}
    for layer, bitmap in layers:
        pixels, before = np.atleast_3d(np.array(bitmap)), "" if layer == "<root>" else f"{layer}."
        channels |= {before + each.name: pixels[..., i] for i, each in enumerate(bitmap.struct_())}
    return channels, {name for name, _ in layers}


@pytest.mark.parametrize("form", FORMS)
def test_mitsuba_splits_it(files, form):
    """Of several parts it opens the first."""
    found, layers = split(files / f"{form}.0001.exr")
    assert same(np.dstack([found[name] for name in "RGB"]), "rgb", form)
    if FORMS[form].multipart:
        return
    assert layers == {"<root>", "N", "albedo", "detail", "id", "motion", "denoised"}
    assert same(np.dstack([found[f"albedo.{name}"] for name in "RGB"]), "albedo", form)
    normals = np.dstack([found[f"N.{name}"] for name in "XYZ"])
    assert np.array_equal(normals, LAYERS.N.astype(np.float16))
    if form == "half":  # as docs/exr.md says: every layer is taken for half
        assert np.isinf(found["Z"]).all() and np.isinf(found["id.part"]).all()
        return
    assert np.array_equal(found["Z"], LAYERS.Z)
    assert np.array_equal(found["id.part"], LAYERS.part)
    assert np.array_equal(found["detail.level"], LAYERS.level)


@pytest.mark.parametrize("form", FORMS)
def test_openimageio_reads_every_layer(files, form):
    found, number = {}, 0
    while True:
        part = oiio.ImageBuf(str(files / f"{form}.0001.exr"), number, 0)
        pixels = part.get_pixels(oiio.FLOAT)
        found |= {name: pixels[..., i] for i, name in enumerate(part.spec().channelnames)}
        number += 1
        if number == part.nsubimages:
            break
    assert same(np.dstack([found[name] for name in "RGB"]), "rgb", form)
    assert np.array_equal(found["Z"], LAYERS.Z)
    plain = oiio.ImageBuf(str(files / f"{form}.0001.exr"))
    types = dict(
        zip(plain.spec().channelnames, map(str, plain.spec().channelformats), strict=False)
    )
    assert plain.spec().channelnames[:3] == ("R", "G", "B")
    if form == "one":
        assert (types["R"], types["Z"], types["id.part"]) == ("float", "float", "uint")


@pytest.mark.parametrize("form", FORMS)
def test_opencv_reads_the_picture(files, form):
    found = cv2.imread(str(files / f"{form}.0001.exr"), cv2.IMREAD_UNCHANGED)
    assert found.dtype == np.float32 and same(found[..., 2::-1], "rgb", form)


def test_oiiotool_tells_every_layer_and_seed(files):
    tool = shutil.which("oiiotool", path=f"{Path(sys.executable).parent}{os.pathsep}{os.defpath}")
    if tool is None:
        pytest.skip("there is no oiiotool here")
    for name, parts in (("one", 1), ("parts", 7)):
        command = [tool, "--info", "-v", "-a", str(files / f"{name}.0001.exr")]
        said = subprocess.run(command, capture_output=True, text=True, check=True).stdout
        for layer in ("R", "Z", "N.X", "albedo.B", "id.object", "motion.Y", "denoised.G"):
            assert layer in said, (name, layer)
        assert said.count('lod:preset.seed: "9223372036854775807"') == parts


@pytest.mark.slow
@pytest.mark.skipif("LODBENCH_BPY" not in os.environ, reason="LODBENCH_BPY names no Python")
def test_blender_names_the_layers_as_documented(files):
    paths = [str(files / f"{name}.0001.exr") for name in IN_BLENDER]
    command = [os.environ["LODBENCH_BPY"], "-c", BLENDER, *paths]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("layers")]
    assert [set(line) for line in lines] == list(IN_BLENDER.values())
