"""A pack in Cycles, Blender's renderer (bpy): a runner of `lodbench run methods`.

    python cycles_runner.py PACK/scene.usda PACK/camera.json -o OUT.exr --knob 16 --seed 0

The knob is the number of samples of a pixel. The haze is in the materials and the world, for rays
of the camera alone: each sample is hazed at its own distance. It needs bpy, usd-core and NumPy;
Blender's own OpenEXR reads and writes.
"""

import argparse
import json
import os
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
import pack_geometry as pack


def main():
    """Read, build, render, write; print the seconds of each stage."""
    parser = argparse.ArgumentParser()
    for name in ("scene", "camera"):
        parser.add_argument(name)
    parser.add_argument("-o", required=True)
    parser.add_argument("--knob", type=float, default=16)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    start = time.perf_counter()
    folder = Path(asked.scene).parent
    numbers, camera = pack.read_numbers(folder)
    models = list(pack.read_models(asked.scene))
    read = time.perf_counter()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    haze = Haze(numbers, pack.read_exr(folder / numbers["light"]["sky"]["airlight"]))
    add_light(scene, numbers, pack.sky_from_north(folder, numbers), haze)
    add_camera(scene, camera)
    material = hazy_matte(haze)
    for geometry, places, turn in models:
        made = [mesh_of(*mesh) for mesh in geometry.meshes]
        if len(geometry.counts):
            made.append(hair_of(geometry))
        for data in made:
            data.materials.append(material)
            show(scene, data, places, turn)
    set_sampling(scene, numbers, max(1, round(asked.knob)), asked.seed)
    built = time.perf_counter()
    picture, depth = rendered(scene)
    traced = time.perf_counter()
    h, w = depth.shape
    forward = np.array(camera["forward"]) / np.linalg.norm(camera["forward"])
    along = pack.directions_of(camera, w, h) @ forward  # Blender's depth is along the axis
    Z = np.where(depth < 1e9, depth / along, 1e10)
    pack.write_exr(asked.o, picture, Z)
    seconds = {"read": read - start, "build": built - read, "trace": traced - built}
    print(json.dumps({"stages": seconds}))


class Haze:
    """The pack's haze as shader nodes: transmittance and airlight of a ray of the camera."""

    def __init__(self, numbers, airlight):
        self.beta = numbers["haze"]["beta"]
        self.horizon = float(np.sin(np.radians(numbers["haze"]["horizon_deg"])))
        self.image = image_of("airlight", airlight)

    def airlight(self, tree, direction):
        """Return the socket of the airlight in a direction, a socket of a vector."""
        apart = node(tree, "ShaderNodeSeparateXYZ", direction)
        turn = maths(tree, "ARCTAN2", apart.outputs["X"], apart.outputs["Y"])
        # A column's middle is its own angle: half a column further.
        half = 0.5 / self.image.size[0]
        along = maths(tree, "MULTIPLY_ADD", turn, 1 / (2 * np.pi), half)
        place = node(tree, "ShaderNodeCombineXYZ", along, 0.5, 0.0)
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image, texture.interpolation, texture.extension = self.image, "Linear", "REPEAT"
        tree.links.new(place.outputs[0], texture.inputs["Vector"])
        return texture.outputs["Color"]

    def transmittance(self, tree, length):
        """Return the socket of a colour: exp(-beta d)."""
        channels = [maths(tree, "EXPONENT", maths(tree, "MULTIPLY", length, -b)) for b in self.beta]
        return node(tree, "ShaderNodeCombineColor", *channels).outputs[0]


def node(tree, kind, *inputs):
    """Make a node, and link or set its inputs in order."""
    made = tree.nodes.new(kind)
    for socket, value in zip(made.inputs, inputs, strict=False):
        put(tree, socket, value)
    return made


def put(tree, socket, value):
    """Link a socket to another, or set it to a number."""
    if hasattr(value, "is_output"):
        tree.links.new(value, socket)
    else:
        socket.default_value = value


def maths(tree, operation, *inputs):
    """Return the socket of a number that is made of others."""
    made = tree.nodes.new("ShaderNodeMath")
    made.operation = operation
    for socket, value in zip(made.inputs, inputs, strict=False):
        put(tree, socket, value)
    return made.outputs[0]


def vectors(tree, operation, *inputs):
    """Return the socket of a vector that is made of others."""
    made = tree.nodes.new("ShaderNodeVectorMath")
    made.operation = operation
    for socket, value in zip(made.inputs, inputs, strict=False):
        put(tree, socket, value)
    return made.outputs[0]


def mixed(tree, factor, one, two):
    """Return the socket of a colour between two."""
    made = tree.nodes.new("ShaderNodeMix")
    made.data_type = "RGBA"
    put(tree, made.inputs[0], factor)
    put(tree, made.inputs[6], one)
    put(tree, made.inputs[7], two)
    return made.outputs[2]


def hazy_matte(haze):
    """Make the one material: for the camera albedo T / pi and light A (1 - T), else albedo."""
    material = bpy.data.materials.new("matte")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    albedo = tree.nodes.new("ShaderNodeAttribute")
    albedo.attribute_type, albedo.attribute_name = "GEOMETRY", "albedo"
    path = tree.nodes.new("ShaderNodeLightPath")
    seen = path.outputs["Is Camera Ray"]
    T = haze.transmittance(tree, path.outputs["Ray Length"])
    # Factors are clamped, which T and albedo are in any case.
    dimmed = vectors(tree, "MULTIPLY", albedo.outputs["Color"], T)
    diffuse = node(
        tree, "ShaderNodeBsdfDiffuse", mixed(tree, seen, albedo.outputs["Color"], dimmed)
    )
    incoming = tree.nodes.new("ShaderNodeNewGeometry").outputs["Incoming"]
    A = haze.airlight(tree, vectors(tree, "SCALE", incoming))
    away = next(n for n in tree.nodes if n.type == "VECT_MATH" and n.operation == "SCALE")
    away.inputs["Scale"].default_value = -1.0
    hidden = vectors(tree, "SUBTRACT", (1.0, 1.0, 1.0), T)
    glow = node(tree, "ShaderNodeEmission", vectors(tree, "MULTIPLY", A, hidden), seen)
    both = tree.nodes.new("ShaderNodeAddShader")
    tree.links.new(diffuse.outputs[0], both.inputs[0])
    tree.links.new(glow.outputs[0], both.inputs[1])
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(both.outputs[0], output.inputs["Surface"])
    material.cycles.emission_sampling = "NONE"  # it lights nothing
    return material


def image_of(name, picture):
    """Make an image of linear radiance, (h, w, 3) from the top."""
    h, w = picture.shape[:2]
    image = bpy.data.images.new(name, w, h, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    opaque = np.concatenate([picture, np.ones((h, w, 1))], axis=2)
    image.pixels.foreach_set(np.ascontiguousarray(opaque[::-1], np.float32).ravel())
    image.pack()
    return image


def add_light(scene, numbers, sky, haze):
    """Add the sun, and the sky; the camera sees the airlight below the horizon."""
    light = numbers["light"]
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    tree = scene.world.node_tree
    background = next(each for each in tree.nodes if each.type == "BACKGROUND")
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    # Blender's maps begin in the west and turn by north to the east.
    texture.image = image_of("sky", np.roll(sky, sky.shape[1] // 4, axis=1))
    direction = tree.nodes.new("ShaderNodeTexCoord").outputs["Generated"]
    apart = node(tree, "ShaderNodeSeparateXYZ", direction)
    low = maths(tree, "LESS_THAN", apart.outputs["Z"], haze.horizon)
    path = tree.nodes.new("ShaderNodeLightPath")
    seen = maths(tree, "MULTIPLY", low, path.outputs["Is Camera Ray"])
    shown = mixed(tree, seen, texture.outputs["Color"], haze.airlight(tree, direction))
    tree.links.new(shown, background.inputs["Color"])
    sun = bpy.data.lights.new("sun", "SUN")
    irradiance = np.array(light["sun_irradiance"])
    strength = float(irradiance.max())
    sun.energy, sun.color, sun.angle = strength, (irradiance / strength).tolist(), 0.0
    placed = bpy.data.objects.new("sun", sun)
    placed.matrix_world = turned(np.array(light["to_sun"]), np.zeros(3))
    scene.collection.objects.link(placed)


def add_camera(scene, camera):
    """Add the still's camera."""
    width, height = camera["size"]
    made = bpy.data.cameras.new("camera")
    made.sensor_fit, made.angle = "HORIZONTAL", float(np.radians(camera["fov_deg"]))
    made.clip_start, made.clip_end = camera.get("near_m", 0.05), camera.get("far_m", 1e7)
    scene.camera = bpy.data.objects.new("camera", made)
    eye, forward, up = (np.array(camera[name], np.float64) for name in ("eye", "forward", "up"))
    scene.camera.matrix_world = turned(-forward, eye, up)
    scene.collection.objects.link(scene.camera)
    scene.render.resolution_x, scene.render.resolution_y = int(width), int(height)
    scene.render.resolution_percentage = 100


def turned(z, place, up=None):
    """Return the matrix of something whose z axis is ``z``."""
    from mathutils import Matrix

    if up is None:
        up = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(up, z)
    x = x / np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, :] = np.stack([x, np.cross(z, x), z, place], axis=1)
    return Matrix(matrix.tolist())


def mesh_of(vertices, faces, normals, colours):
    """Make triangles with smooth normals and an albedo of each vertex."""
    mesh = bpy.data.meshes.new("mesh")
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    set_colour(mesh, "POINT", colours)
    mesh.update(calc_edges=True)
    mesh.validate()
    mesh.normals_split_custom_set_from_vertices(normals)
    return mesh


def hair_of(geometry):
    """Make sticks as hair: round cones with an albedo of each chain."""
    hair = bpy.data.hair_curves.new("sticks")
    hair.add_curves(geometry.counts.tolist())
    hair.set_types(type="POLY")
    points = np.ascontiguousarray(geometry.points[:, :3])
    hair.position_data.foreach_set("vector", points.ravel())
    radius = hair.attributes.get("radius") or hair.attributes.new("radius", "FLOAT", "POINT")
    radius.data.foreach_set("value", np.ascontiguousarray(geometry.points[:, 3]))
    set_colour(hair, "CURVE", geometry.tints)
    return hair


def set_colour(data, domain, colours):
    """Give geometry its albedo."""
    attribute = data.attributes.new("albedo", "FLOAT_COLOR", domain)
    opaque = np.concatenate([colours, np.ones((len(colours), 1))], axis=1)
    attribute.data.foreach_set("color", opaque.astype(np.float32).ravel())


def show(scene, data, places, turn):
    """Link an object of these data for each copy, moved and turned about the vertical."""
    from mathutils import Matrix

    for (x, y, z), (cos, sin) in zip(places.tolist(), turn.tolist(), strict=True):
        made = bpy.data.objects.new(data.name, data)
        made.matrix_world = Matrix(
            ((cos, -sin, 0, x), (sin, cos, 0, y), (0, 0, 1, z), (0, 0, 0, 1))
        )
        made.shadow_terminator_geometry_offset = 0.0  # it lights slopes that face away from the sun
        scene.collection.objects.link(made)


def set_sampling(scene, numbers, samples, seed):
    """Take every sample alike: no adaptive sampling, no clamping, no denoising, a box filter."""
    scene.render.engine = "CYCLES"
    scene.cycles.device = "CPU"
    scene.cycles_curves.shape = "THICK_LINEAR"
    scene.cycles.pixel_filter_type = "BOX"
    scene.cycles.use_adaptive_sampling = scene.cycles.use_denoising = False
    scene.cycles.sample_clamp_direct = scene.cycles.sample_clamp_indirect = 0.0
    # A path of k edges has k - 2 bounces: one edge from the eye and one to the light.
    bounces = numbers["integrator"]["max_depth"] - 2
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = bounces
    scene.cycles.samples, scene.cycles.seed = samples, seed
    scene.render.threads_mode, scene.render.threads = "FIXED", os.cpu_count() or 1
    scene.view_layers[0].use_pass_z = True


def rendered(scene):
    """Render, and read the picture and its depth back, (h, w, 3) and (h, w) from the top."""
    import OpenEXR

    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "frame.exr")
        settings = scene.render.image_settings
        if hasattr(settings, "media_type"):
            settings.media_type = "MULTI_LAYER_IMAGE"
        settings.file_format = "OPEN_EXR_MULTILAYER"
        settings.color_depth, settings.exr_codec = "32", "NONE"
        with open(os.devnull, "w") as quiet:
            out = os.dup(1)
            os.dup2(quiet.fileno(), 1)
            bpy.ops.render.render(write_still=True)
            sys.stdout.flush()
            os.dup2(out, 1)
        with OpenEXR.File(scene.render.filepath, separate_channels=True) as file:
            found = {
                name.rpartition(".")[2] + ("z" if "Depth" in name else ""): each.pixels.copy()
                for part in range(len(file.parts))
                for name, each in file.channels(part).items()
                if "Combined" in name or "Depth" in name
            }
    depth = next(each for name, each in found.items() if name.endswith("z"))
    return np.stack([found[c] for c in "RGB"], axis=2).astype(np.float64), depth.astype(float)


if __name__ == "__main__":
    main()
