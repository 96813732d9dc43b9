"""Render a frame in Cycles, for another program. Run by the Python of an environment that has bpy.

The first argument is an archive of arrays (``scene_arrays``), the second the archive to write: the
pictures, linear, rows from the top. What was asked for is read as JSON from standard input; the
last line of standard output is JSON: ``seconds`` by stage and ``peak_bytes``, before and after.
"""

import json
import math
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import bpy
import numpy as np


def main(source: str, target: str) -> None:
    """Read, set up, and render: twice at one sample, of which one starts Cycles; then all seeds."""
    asked = json.load(sys.stdin)
    arrays = dict(np.load(source))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    before, start = peak_bytes(), time.perf_counter()
    _add_light(scene, arrays)
    _add_camera(scene, arrays)
    _add_meshes(scene, arrays)
    _add_curves(scene, arrays)
    seconds = {"synchronise": [time.perf_counter() - start]}
    _set_sampling(scene, asked)
    pictures = []
    ones = [("first", 1, 0), ("one", 1, 0)]
    for name, spp, seed in [*ones, *(("all", asked["spp"], s) for s in asked["seeds"])]:
        scene.cycles.samples, scene.cycles.seed = spp, seed
        start = time.perf_counter()
        picture = rendered(scene)
        seconds.setdefault(name, []).append(time.perf_counter() - start)
        if name == "all":
            pictures.append(picture)
    np.savez(target, pictures=np.array(pictures))
    print(json.dumps({"seconds": seconds, "peak_bytes": [before, peak_bytes()]}))


def peak_bytes() -> int:
    """Return the most that this process has held [bytes]; ``ru_maxrss`` counts its parent's."""
    rows = Path("/proc/self/status").read_text().splitlines()
    return next(1024 * int(row.split()[1]) for row in rows if row.startswith("VmHWM"))


def _set_sampling(scene: Any, asked: dict[str, Any]) -> None:
    """Take every sample alike: no adaptive sampling, no clamping, no denoising, a box filter."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles_curves.shape = "THICK_LINEAR"
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    # A path of k edges has k - 2 bounces: one edge from the eye and one to the light.
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = asked["max_depth"] - 2
    scene.render.threads_mode, scene.render.threads = "FIXED", asked["threads"]
    scene.render.film_transparent = False
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.exr_codec = "NONE"


def _add_light(scene: Any, arrays: dict[str, np.ndarray]) -> None:
    sky = arrays["sky"]
    height, width = sky.shape[:2]
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    opaque = np.concatenate([sky, np.ones((height, width, 1), np.float32)], axis=2)
    image.pixels.foreach_set(np.ascontiguousarray(opaque[::-1], np.float32).ravel())
    image.pack()
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    nodes = scene.world.node_tree.nodes
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    background = next(node for node in nodes if node.type == "BACKGROUND")
    scene.world.node_tree.links.new(texture.outputs["Color"], background.inputs["Color"])
    light_from_above_alone(scene.world.node_tree, background)
    sun = bpy.data.lights.new("sun", "SUN")
    strength = float(arrays["sun"].max())
    sun.energy, sun.color, sun.angle = strength, (arrays["sun"] / strength).tolist(), 0.0
    placed = bpy.data.objects.new("sun", sun)
    placed.matrix_world = turned(arrays["to_sun"], np.zeros(3))
    scene.collection.objects.link(placed)


def light_from_above_alone(tree: Any, background: Any) -> None:
    """Show what is below the horizon to the camera, and let it light nothing."""
    path, place = (tree.nodes.new(f"ShaderNode{name}") for name in ("LightPath", "TexCoord"))
    apart = tree.nodes.new("ShaderNodeSeparateXYZ")
    above, either = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeMath")
    above.operation, either.operation = "GREATER_THAN", "MAXIMUM"
    above.inputs[1].default_value = 0.0
    tree.links.new(place.outputs["Generated"], apart.inputs[0])
    tree.links.new(apart.outputs["Z"], above.inputs[0])
    tree.links.new(path.outputs["Is Camera Ray"], either.inputs[0])
    tree.links.new(above.outputs[0], either.inputs[1])
    tree.links.new(either.outputs[0], background.inputs["Strength"])


def _add_camera(scene: Any, arrays: dict[str, np.ndarray]) -> None:
    width, height, fov = arrays["lens"]
    camera = bpy.data.cameras.new("camera")
    camera.sensor_fit, camera.angle = "HORIZONTAL", float(fov)
    camera.clip_start, camera.clip_end = 0.05, 1e7
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.matrix_world = turned(-arrays["forward"], arrays["eye"], arrays["up"])
    scene.collection.objects.link(scene.camera)
    render = scene.render
    render.resolution_x, render.resolution_y = int(width), int(height)
    render.resolution_percentage = 100


def turned(z: np.ndarray, place: np.ndarray, up: np.ndarray | None = None) -> Any:
    """Return the matrix of something whose z axis is ``z``, column by column for Blender."""
    from mathutils import Matrix

    if up is None:
        up = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(up, z)
    x = x / np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :] = np.stack([x, np.cross(z, x), z, place], axis=1)
    return Matrix(matrix.tolist())


def _add_meshes(scene: Any, arrays: dict[str, np.ndarray]) -> None:
    for number in range(int(arrays["meshes"])):
        vertices, faces, normals, colours = (
            arrays[f"mesh{number}.{name}"] for name in ("vertices", "faces", "normals", "colours")
        )
        mesh = bpy.data.meshes.new(f"mesh{number}")
        mesh.vertices.add(len(vertices))
        mesh.vertices.foreach_set("co", vertices.ravel())
        mesh.loops.add(faces.size)
        mesh.loops.foreach_set("vertex_index", faces.ravel())
        mesh.polygons.add(len(faces))
        mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
        _set_colour(mesh, "POINT", colours)
        mesh.update(calc_edges=True)
        mesh.validate()
        mesh.normals_split_custom_set_from_vertices(normals)
        show(scene, mesh)


def _add_curves(scene: Any, arrays: dict[str, np.ndarray]) -> None:
    points, counts = arrays["points"], arrays["counts"]
    if not len(counts):
        return
    hair = bpy.data.hair_curves.new("sticks")
    hair.add_curves(counts.tolist())
    hair.set_types(type="POLY")
    hair.position_data.foreach_set("vector", np.ascontiguousarray(points[:, :3]).ravel())
    radius = hair.attributes.get("radius") or hair.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.ascontiguousarray(points[:, 3]))
    _set_colour(hair, "CURVE", arrays["tints"])
    show(scene, hair)


def _set_colour(data: Any, domain: str, colours: np.ndarray) -> None:
    attribute = data.attributes.new("albedo", "FLOAT_COLOR", domain)
    opaque = np.concatenate([colours, np.ones((len(colours), 1))], axis=1)
    attribute.data.foreach_set("color", opaque.astype(np.float32).ravel())


def show(scene: Any, data: Any) -> None:
    """Link an object of these data, which reflects diffusely by its own albedo."""
    material = bpy.data.materials.get("matte") or matte()
    data.materials.append(material)
    scene.collection.objects.link(bpy.data.objects.new(data.name, data))


def matte() -> Any:
    """Make the one material: a diffuse surface of the albedo that the geometry carries."""
    material = bpy.data.materials.new("matte")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    albedo = tree.nodes.new("ShaderNodeAttribute")
    albedo.attribute_type, albedo.attribute_name = "GEOMETRY", "albedo"
    diffuse = tree.nodes.new("ShaderNodeBsdfDiffuse")
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(albedo.outputs["Color"], diffuse.inputs["Color"])
    tree.links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    return material


def rendered(scene: Any) -> np.ndarray:
    """Render, and read the picture back, (h, w, 3) from the top."""
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        image.colorspace_settings.name = "Non-Color"
        width, height = image.size
        pixels = np.empty(width * height * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    if not math.isfinite(float(pixels.sum())):
        raise ValueError("the picture has numbers that are not finite")
    return pixels.reshape(height, width, 4)[::-1, :, :3].copy()


if __name__ == "__main__":
    main(*sys.argv[1:])
