"""Frames open in other programs, with the layers named as documented.

Blender comes as a module, ``bpy``, for an environment of its own: LODBENCH_BPY names its Python
(python3.11 -m venv bpy && bpy/bin/pip install bpy; then LODBENCH_BPY=bpy/bin/python make slow).
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from scenes.frame.layers import Layers
from scenes.preset.tables import OutputPreset
from scenes.render.files.exr import write_exr
from scenes.render.files.header import frame_header

FORMS = {"one": OutputPreset(), "parts": OutputPreset(multipart=True, colour="float")}
IN_BLENDER = {
    "one": {"Combined", "Alpha", "Depth", "N", "albedo", "id", "motion", "denoised"},
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


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    folder, generator = tmp_path_factory.mktemp("frames"), np.random.default_rng(1)
    shape = (6, 8)
    colour, ids = generator.random((*shape, 3)), np.arange(48).reshape(shape)
    layers = Layers(colour, ids + 0.5, colour, colour, ids, ids, ids)
    camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0, 0, 60, shape[::-1])
    header = frame_header(camera, 24.0, {"seed": 2**63 - 1}, 1)
    full = Layers(
        *(getattr(layers, k) for k in ("rgb", "Z", "N", "albedo", "object", "part", "level")),
        motion=colour[..., :2],
        denoised=colour,
    )
    for name, form in FORMS.items():
        write_exr(folder / f"{name}.0001.exr", full, header, form)
    return folder


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
    paths = [str(files / f"{name}.0001.exr") for name in FORMS]
    command = [os.environ["LODBENCH_BPY"], "-c", BLENDER, *paths]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    lines = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("layers")]
    assert [set(line) for line in lines] == [IN_BLENDER[name] for name in FORMS]
