"""Scenes made in Blender, in USD and in glTF: both are one model, or refused by name.

LODBENCH_BPY names a Python that has bpy, where `lodbench environments cycles` has not made one.
"""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.methods.environments import CYCLES
from lod.errors import InputError
from lod.shapes import triangle_areas
from scenes.imported.library import read_model

BPY = os.environ.get("LODBENCH_BPY") or CYCLES.python()
needs_bpy = pytest.mark.skipif(BPY is None, reason="`lodbench environments cycles` makes it")

BOUNDS, COLOURS = 1e-5, 4e-3
"""Of the longest side; and of albedo, weighed by area: JPEG, and 8 bits."""

REFUSED = {
    "tree_left_as_curves": ("BasisCurves", None),
    "leaves_cut_out_by_alpha": ("opacity by a network", "BLEND"),
    "texture_of_16_bits": ("save it as RGB PNG", None),  # USD: as .exr
    "texture_as_data": ("sourceColorSpace raw", None),  # glTF cannot say it
    "texture_clipped": ("beyond its texture", "beyond its texture"),
    "texture_by_a_second_map": (None, "TEXCOORD_1"),
    "texture_moved_by_a_mapping": ("UsdTransform2d", "KHR_texture_transform"),
    "texture_of_noise": (None, "no colour"),
    "colours_of_corners": ("primvars:Col", None),
    "colours_of_points_without_a_material": ("no colour", None),
    "no_material": ("no colour", "no colour"),
    "materials_and_a_bare_slot": (None, "no colour"),
    "material_that_is_white": (None, "no colour"),  # which Blender leaves out, as glTF's default
    "material_of_glass": (None, "KHR_materials_transmission"),
    "material_half_there": ("opacity", "BLEND"),
    "material_of_a_diffuse_node": (None, "no colour"),
    "subdivided_as_a_cage": ("subdivision surface", None),
    "instances_by_geometry_nodes": ("no triangles", "no meshes"),
    "light_of_an_area": (None, "empty"),
    "faces_of_many_corners": ("not convex", None),
    "bones_and_skin": ("SkelRoot", "a skin"),
    "shape_keys": ("SkelRoot", "morph targets"),
}
"""What the message of each reader says; None: of this file it cannot know, and it reads it."""

TWO_MODELS = {
    "texture_times_a_colour": "in USD Blender leaves the colour out",
    "subdivided_more_in_the_render": "USD has levels of the render, glTF those of the viewport",
    "instances_on_faces": "USD has the original beside its copies",
    "surface_left_as_nurbs": "USD has no surface",
}
"""Blender's two files say different things, each as its format has it: no reader can know."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("blender")
    script = Path(__file__).parent / "blender_files.py"
    subprocess.run([str(BPY), str(script), str(made)], check=True, capture_output=True)
    return made


def facts(path: Path) -> str | dict[str, Any]:
    """What is compared of a model, or why it is refused."""
    try:
        tree = read_model(path)
    except InputError as error:
        return str(error)
    meshes = tree.meshes
    area = triangle_areas(meshes.vertices, meshes.faces)
    middle = meshes.vertices[meshes.faces].mean(axis=1) / np.ptp(meshes.vertices, axis=0).max()
    weights = np.column_stack((np.ones(len(area)), middle)) * area[:, None] / area.sum()
    return {
        "parts": len(tree),
        "triangles": len(meshes),
        "bounds": np.stack((meshes.vertices.min(axis=0), meshes.vertices.max(axis=0))),
        "colours": weights.T @ meshes.face_colours,  # means, and where each colour is
    }


@needs_bpy
@pytest.mark.slow
def test_both_files_are_one_model_or_are_refused_by_name(folder: Path) -> None:
    told, alike, lost = json.loads((folder / "found.json").read_text()), [], []
    assert len(told) >= 50 and REFUSED.keys() | TWO_MODELS.keys() <= told.keys()
    for name, shown in told.items():
        usd, gltf = facts(folder / f"{name}.usdc"), facts(folder / f"{name}.glb")
        words = REFUSED.get(name, (None, None))
        for found, says in ((usd, words[0]), (gltf, words[1])):
            assert isinstance(found, dict) if says is None else says in str(found), (name, found)
        if isinstance(usd, dict) and isinstance(gltf, dict):
            x, y, z = np.array((shown["low"], shown["high"])).T
            blenders = np.stack((-y[::-1], x, z), axis=1)  # ahead is −y there
            size = np.ptp(gltf["bounds"], axis=0).max()
            same = usd["parts"] == gltf["parts"]
            same &= usd["triangles"] == gltf["triangles"] == shown["triangles"]
            same &= bool(abs(usd["bounds"] - gltf["bounds"]).max() < BOUNDS * size)
            same &= bool(abs(usd["bounds"] - blenders).max() < BOUNDS * size)
            same &= bool(abs(usd["colours"] - gltf["colours"]).max() < COLOURS)
            (alike if same else lost).append(name)
    assert lost == [name for name in told if name in TWO_MODELS]
    assert len(alike) + len(lost) + len(REFUSED) == len(told)
