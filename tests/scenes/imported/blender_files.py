"""Make some fifty scenes in Blender, each as USD and as glTF, in FOLDER, or those of some NAMES.

Run by a Python that has bpy. Trees of curves, textures, modifiers, instances, collections, cameras,
lights and animation: as people model them, and not as it would suit the readers. `found.json` has
what Blender shows of each: triangles, and bounds [m].
"""

import json
import math
import random
import sys
from pathlib import Path

import bpy
import numpy as np

FOLDER = Path(sys.argv[1])
SCENES = {}


def scene(make):
    SCENES[make.__name__] = make
    return make


def add(name, data, parent=None, at=(0, 0, 0), turn=(0, 0, 0), size=(1, 1, 1)):
    found = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(found)
    found.location, found.rotation_euler, found.scale, found.parent = at, turn, size, parent
    return found


def mesh(name, points, faces):
    data = bpy.data.meshes.new(name)
    data.from_pydata(points, [], faces)
    return data


def primitive(kind, name, at=(0, 0, 0), **how):
    getattr(bpy.ops.mesh, f"primitive_{kind}_add")(location=at, **how)
    bpy.context.object.name = name
    return bpy.context.object


def box():
    return primitive("cube", "box")


def paint(thing, colour=(0.2, 0.4, 0.1), **inputs):
    """A material; gives its nodes, links and the Principled BSDF."""
    made = bpy.data.materials.new("paint")
    made.use_nodes = True
    shader = made.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*colour, 1)
    for key, value in inputs.items():
        shader.inputs[key].default_value = value
    thing.data.materials.append(made)
    return made.node_tree.nodes, made.node_tree.links, shader


def picture(name, width=64, height=64, **how):
    """A smooth picture, packed: what is averaged of it does not depend on a texel's edge."""
    image = bpy.data.images.new(name, width, height, **how)
    x, y = np.meshgrid(np.linspace(0, 1, width), np.linspace(0, 1, height))
    rgba = np.stack((0.2 + 0.6 * x, 0.3 + 0.4 * y, 0.5 - 0.3 * x * y, np.ones_like(x)), axis=-1)
    image.pixels.foreach_set(rgba.astype(np.float32).reshape(-1))
    image.pack()
    return image


def textured(thing, image, **how):
    nodes, links, shader = paint(thing)
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = image
    for key, value in how.items():
        setattr(texture, key, value)
    links.new(texture.outputs["Color"], shader.inputs["Base Color"])
    return nodes, links, shader, texture


def tree(seed=1, bevel=0.05, levels=3, kind="POLY"):
    """A curve of branches: each ends in two thinner ones."""
    dice = random.Random(seed)
    data = bpy.data.curves.new("branches", "CURVE")
    data.dimensions, data.bevel_depth, data.bevel_resolution, data.use_fill_caps = (
        "3D",
        bevel,
        2,
        True,
    )

    def grow(start, ahead, length, radius, left):
        spline = data.splines.new(kind)
        many = spline.bezier_points if kind == "BEZIER" else spline.points
        many.add(2)
        end = [a + length * b for a, b in zip(start, ahead, strict=True)]
        for k, point in enumerate(many):
            at = [a + (b - a) * k / 2 for a, b in zip(start, end, strict=True)]
            point.co = at if kind == "BEZIER" else (*at, 1)
            point.radius = radius * (1 - 0.2 * k)
            if kind == "BEZIER":
                point.handle_left_type = point.handle_right_type = "AUTO"
        if kind == "NURBS":
            spline.use_endpoint_u, spline.order_u = True, 3
        for _ in range(2 if left else 0):
            side = [a + dice.uniform(-0.7, 0.7) for a in ahead]
            norm = math.hypot(*side)
            grow(end, [a / norm for a in side], length * 0.7, radius * 0.6, left - 1)

    grow((0, 0, 0), (0, 0, 1), 1.5, 1.0, levels)
    return add("tree", data)


def real(thing):
    """Convert to a mesh, modifiers and all."""
    bpy.ops.object.select_all(action="DESELECT")
    thing.select_set(True)
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.convert(target="MESH")
    return bpy.context.object


def leaf():
    return mesh(
        "leaf", [(0, 0, 0), (0.1, 0.15, 0), (0, 0.4, 0.05), (-0.1, 0.15, 0)], [(0, 1, 2, 3)]
    )


def leaves(parent, count=40, seed=3):
    dice, data = random.Random(seed), leaf()
    for k in range(count):
        at = [dice.uniform(-1, 1), dice.uniform(-1, 1), dice.uniform(1.5, 3)]
        turn = [dice.uniform(0, 6.28) for _ in range(3)]
        found = add(f"leaf.{k:03}", data, parent, at, turn)
        if not data.materials:
            paint(found, (0.05, 0.3, 0.02))


@scene
def tree_with_leaves():
    trunk = real(tree(5))
    paint(trunk, (0.15, 0.08, 0.04))
    leaves(trunk)


@scene
def tree_in_empties():
    top = add("oak", None)
    for k in range(5):
        bough = add(f"bough.{k}", None, top, (0, 0, 1 + 0.3 * k), (0.6, 0, 1.26 * k))
        wood = primitive("cylinder", f"wood.{k}", radius=0.05, depth=1)
        wood.parent, wood.location = bough, (0, 0, 0.5)
        paint(wood, (0.2, 0.1, 0.05))
        leaves(bough, 8, k)


@scene
def tree_with_its_inverses():
    """Children keep where they were as they were parented."""
    trunk = primitive("cylinder", "trunk", (1, 2, 1), radius=0.2, depth=2)
    trunk.rotation_euler = (0.2, 0.1, 0.5)
    paint(trunk, (0.2, 0.1, 0.05))
    for k in range(6):
        ball = primitive("ico_sphere", f"crown.{k}", (1 + 0.5 * k, 2, 3), radius=0.4)
        paint(ball, (0.1, 0.1 + 0.1 * k, 0.05))
        bpy.context.view_layer.update()
        ball.parent, ball.matrix_parent_inverse = trunk, trunk.matrix_world.inverted()


@scene
def leaves_cut_out_by_alpha():
    plane = primitive("plane", "leaf")
    _, links, shader, texture = textured(plane, picture("cutout", alpha=True))
    links.new(texture.outputs["Alpha"], shader.inputs["Alpha"])


def on_a_ball(image, **how):
    return textured(primitive("uv_sphere", "ball", segments=24, ring_count=12), image, **how)


@scene
def texture_jpeg():
    image = picture("bark")
    image.filepath_raw, image.file_format = str(FOLDER / "bark.jpg"), "JPEG"
    image.save()
    on_a_ball(bpy.data.images.load(image.filepath_raw))


@scene
def texture_as_data():
    image = picture("data")
    image.colorspace_settings.name = "Non-Color"
    on_a_ball(image)


@scene
def texture_in_grey():
    image = picture("grey")
    image.file_format, image.filepath_raw = "PNG", str(FOLDER / "grey.png")
    bpy.context.scene.render.image_settings.color_mode = "BW"
    image.save_render(image.filepath_raw)
    on_a_ball(bpy.data.images.load(image.filepath_raw))


def wall(**how):
    plane = primitive("plane", "wall")
    for each in plane.data.uv_layers[0].data:
        each.uv = (each.uv[0] * 3, each.uv[1] * 2)
    textured(plane, picture("tiles"), **how)


@scene
def texture_by_a_second_map():
    nodes, links, _, texture = on_a_ball(picture("bark"))
    layers = bpy.context.object.data.uv_layers
    layers.new(name="second")
    for one, two in zip(layers[0].data, layers[1].data, strict=True):
        two.uv = (one.uv[1], one.uv[0])
    reader = nodes.new("ShaderNodeUVMap")
    reader.uv_map = "second"
    links.new(reader.outputs["UV"], texture.inputs["Vector"])


@scene
def texture_moved_by_a_mapping():
    nodes, links, _, texture = on_a_ball(picture("bark"))
    reader, moved = nodes.new("ShaderNodeUVMap"), nodes.new("ShaderNodeMapping")
    moved.inputs["Scale"].default_value = (2, 3, 1)
    links.new(reader.outputs["UV"], moved.inputs["Vector"])
    links.new(moved.outputs["Vector"], texture.inputs["Vector"])


@scene
def texture_times_a_colour():
    nodes, links, shader, texture = on_a_ball(picture("bark"))
    mix = nodes.new("ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    mix.inputs["Factor"].default_value = 1
    mix.inputs["B"].default_value = (0.5, 0.25, 1, 1)
    links.new(texture.outputs["Color"], mix.inputs["A"])
    links.new(mix.outputs["Result"], shader.inputs["Base Color"])


@scene
def texture_of_noise():
    ball = primitive("uv_sphere", "ball")
    nodes, links, shader = paint(ball)
    noise = nodes.new("ShaderNodeTexNoise")
    links.new(noise.outputs["Color"], shader.inputs["Base Color"])


@scene
def colours_of_corners():
    """Painted corners, by a node of the material."""
    ball = primitive("ico_sphere", "ball")
    layer = ball.data.color_attributes.new("Col", "FLOAT_COLOR", "CORNER")
    for k, each in enumerate(layer.data):
        each.color = (0.1 + 0.05 * (k % 7), 0.4, 0.2, 1)
    nodes, links, shader = paint(ball)
    reader = nodes.new("ShaderNodeVertexColor")
    reader.layer_name = "Col"
    links.new(reader.outputs["Color"], shader.inputs["Base Color"])


@scene
def colours_of_points_without_a_material():
    ball = primitive("ico_sphere", "ball")
    layer = ball.data.color_attributes.new("Col", "BYTE_COLOR", "POINT")
    for k, each in enumerate(layer.data):
        each.color = (0.1 + 0.05 * (k % 7), 0.4, 0.2, 1)


@scene
def several_materials():
    """Faces with materials of their own, one of which nobody uses."""
    cube = box()
    for colour in ((0.8, 0.1, 0.1), (0.1, 0.8, 0.1), (0.1, 0.1, 0.8), (1, 1, 1)):
        paint(cube, colour)
    for k, face in enumerate(cube.data.polygons):
        face.material_index = k % 3


@scene
def materials_and_a_bare_slot():
    cube = box()
    paint(cube, (0.8, 0.1, 0.1))
    cube.data.materials.append(None)
    cube.data.polygons[0].material_index = 1


@scene
def material_of_the_object():
    """One mesh, and a material for each object."""
    data = primitive("cube", "one").data
    data.materials.append(None)
    for k, thing in enumerate((bpy.context.object, add("two", data, at=(3, 0, 0)))):
        paint(add("lender", leaf(), at=(0, 0, 5 + k)), (0.2 + 0.5 * k, 0.3, 0.1))
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = bpy.data.materials[-1]


@scene
def material_of_a_diffuse_node():
    nodes, links, _ = paint(box())
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.3, 0.1, 0.6, 1)
    links.new(diffuse.outputs[0], nodes["Material Output"].inputs["Surface"])


@scene
def material_mixed_of_two():
    nodes, links, shader = paint(box())
    mix, other = nodes.new("ShaderNodeMixShader"), nodes.new("ShaderNodeBsdfTranslucent")
    links.new(shader.outputs[0], mix.inputs[1])
    links.new(other.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], nodes["Material Output"].inputs["Surface"])


def modified(kind, thing, **how):
    found = thing.modifiers.new(kind.lower(), kind)
    for key, value in how.items():
        setattr(found, key, value)
    return thing


def fence():
    post = primitive("cube", "post", size=0.4)
    modified("ARRAY", post, count=5)
    modified("BEVEL", post, width=0.03)
    modified("MIRROR", post, use_axis=(True, False, False))
    paint(post)
    return post


@scene
def modifier_solidify_and_decimate():
    ball = primitive("uv_sphere", "ball")
    modified("SOLIDIFY", ball, thickness=0.1)
    modified("DECIMATE", ball, ratio=0.4)
    paint(ball)


@scene
def instances_of_a_collection():
    store = bpy.data.collections.new("store")
    for name, kind in (("wood", "cylinder"), ("crown", "ico_sphere")):
        thing = primitive(kind, name, (0, 0, 1 if name == "wood" else 2))
        paint(thing, (0.1, 0.3, 0.1) if name == "crown" else (0.2, 0.1, 0.05))
        bpy.context.scene.collection.objects.unlink(thing)
        store.objects.link(thing)
    for k in range(4):
        found = add(f"tree.{k}", None, at=(4 * k, 0, 0), turn=(0, 0, k), size=(1, 1, 1 + 0.2 * k))
        found.instance_type, found.instance_collection = "COLLECTION", store


@scene
def instances_of_the_card():
    thing = box()
    paint(thing)
    for k in range(6):
        add(f"box.{k}", thing.data, at=(3 * k, 3, 0))


@scene
def instances_on_faces():
    ground, thing = (
        primitive("grid", "ground", x_subdivisions=3, y_subdivisions=3),
        add("leaf", leaf()),
    )
    paint(ground)
    paint(thing, (0.3, 0.4, 0.1))
    thing.parent, ground.instance_type = ground, "FACES"


@scene
def instances_by_geometry_nodes():
    thing = primitive("plane", "ground")
    paint(thing)
    group = bpy.data.node_groups.new("scatter", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    first, last = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    places, put = (
        group.nodes.new("GeometryNodeMeshToPoints"),
        group.nodes.new("GeometryNodeInstanceOnPoints"),
    )
    box = group.nodes.new("GeometryNodeMeshCube")
    for a, b in ((first, places), (places, put), (put, last)):
        group.links.new(a.outputs[0], b.inputs[0])
    group.links.new(box.outputs[0], put.inputs["Instance"])
    modified("NODES", thing, node_group=group)


@scene
def hidden_objects():
    paint(primitive("cube", "seen"))
    hidden = primitive("cube", "hidden", (5, 0, 0))
    hidden.hide_viewport = hidden.hide_render = True
    shut = primitive("cube", "shut away", (0, 9, 0))
    bpy.context.scene.collection.objects.unlink(shut)
    bpy.context.scene.collection.children.link(bpy.data.collections.new("shut"))
    bpy.data.collections["shut"].objects.link(shut)
    bpy.context.view_layer.layer_collection.children["shut"].exclude = True


@scene
def mirrored_and_sheared():
    top = add("top", None, turn=(0.3, 0.2, 0.1), size=(-1, 2, 0.5))
    cube = add(
        "box", primitive("cube", "own", (5, 5, 5)).data, top, (1, 2, 3), (0.5, 0.4, 0.3), (1, -2, 3)
    )
    paint(cube)


@scene
def units_of_centimetres():
    bpy.context.scene.unit_settings.scale_length = 0.01
    paint(primitive("cube", "box", (0, 0, 100), size=200))


@scene
def cameras_and_lights():
    top = add("rig", None, at=(0, 0, 2))
    add("eye", bpy.data.cameras.new("eye"), top, (0, -8, 0))
    bpy.context.scene.camera = bpy.data.objects["eye"]
    for kind in ("SUN", "POINT", "SPOT"):
        add(kind.lower(), bpy.data.lights.new(kind.lower(), kind), top, (2, 0, 0))
    paint(box())
    bpy.context.scene.world = bpy.data.worlds.new("sky")


@scene
def light_of_an_area():
    add("area", bpy.data.lights.new("area", "AREA"))
    paint(box())


@scene
def text_left_as_text():
    bpy.ops.object.text_add()
    paint(bpy.context.object)


@scene
def surface_left_as_nurbs():
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(location=(3, 0, 0))
    paint(bpy.context.object)
    paint(box())


@scene
def faces_of_many_corners():
    """A star of one face, bent, and an L of another: not convex."""
    star = [
        (r * math.cos(0.628 * k), r * math.sin(0.628 * k), 0)
        for k in range(10)
        for r in (1 - 0.6 * (k % 2),)
    ]
    paint(add("star", mesh("star", star, [range(10)])))
    ell = [(0, 0, 0), (2, 0, 0), (2, 1, 0), (1, 1, 0), (1, 2, 0), (0, 2, 0)]
    paint(add("ell", mesh("ell", ell, [(3, 4, 5, 0, 1, 2)]), at=(3, 0, 0)), (0.4, 0.1, 0.1))


@scene
def animated_places():
    cube = box()
    paint(cube)
    bpy.context.scene.frame_start, bpy.context.scene.frame_end = 3, 9
    for frame, x in ((3, 2), (9, 20)):
        cube.location.x = x
        cube.keyframe_insert("location", frame=frame)
    bpy.context.scene.frame_set(3)


@scene
def animated_and_left_in_the_middle():
    animated_places()
    bpy.context.scene.frame_set(7)


@scene
def bones_and_skin():
    data = bpy.data.armatures.new("bones")
    bones = add("bones", data)
    bpy.context.view_layer.objects.active = bones
    bpy.ops.object.mode_set(mode="EDIT")
    bone = data.edit_bones.new("bone")
    bone.head, bone.tail = (0, 0, 0), (0, 0, 1)
    bpy.ops.object.mode_set(mode="OBJECT")
    cube = box()
    paint(cube)
    cube.parent = bones
    modified("ARMATURE", cube, object=bones)
    cube.vertex_groups.new(name="bone").add(range(8), 1.0, "ADD")


@scene
def shape_keys():
    cube = box()
    paint(cube)
    cube.shape_key_add(name="Basis")
    cube.shape_key_add(name="up").data[0].co.z += 2


def subdivided(levels):
    return modified("SUBSURF", box(), levels=levels, render_levels=2)


SHINING = {"Emission Strength": 5.0, "Coat Weight": 1, "Metallic": 0.5}
SCENES |= {
    "tree_of_polylines": lambda: paint(real(tree()), (0.15, 0.08, 0.04)),
    "tree_of_beziers": lambda: paint(real(tree(2, kind="BEZIER")), (0.15, 0.08, 0.04)),
    "tree_of_nurbs": lambda: paint(real(tree(3, kind="NURBS")), (0.15, 0.08, 0.04)),
    "tree_left_as_curves": lambda: paint(tree(4)),
    "texture_png": lambda: on_a_ball(picture("bark")),
    "texture_of_16_bits": lambda: on_a_ball(picture("deep", float_buffer=True)),
    "texture_repeated": wall,
    "texture_clipped": lambda: wall(extension="EXTEND"),
    "no_material": lambda: primitive("cone", "cone"),
    "material_that_is_white": lambda: paint(box(), (1, 1, 1)),
    "material_of_glass": lambda: paint(box(), **{"Transmission Weight": 1.0}),
    "material_half_there": lambda: paint(box(), Alpha=0.5),
    "material_that_shines": lambda: paint(box(), **SHINING),
    "modifiers_on_the_stack": fence,
    "modifiers_made_real": lambda: real(fence()),
    "subdivided_and_tessellated": lambda: paint(subdivided(2)),
    "subdivided_as_a_cage": lambda: paint(subdivided(2)),
    "subdivided_more_in_the_render": lambda: paint(subdivided(1)),
    "instances_that_stay_instances": SCENES["instances_of_a_collection"],
    "y_up": lambda: paint(primitive("cone", "cone", (1, 2, 3))),
}
HOW = {
    "subdivided_and_tessellated": {"usd": {"export_subdivision": "TESSELLATE"}},
    "subdivided_more_in_the_render": {"usd": {"export_subdivision": "TESSELLATE"}},
    "instances_that_stay_instances": {"usd": {"use_instancing": True}},
    "instances_of_the_card": {"gltf": {"export_gpu_instances": True}},
    "hidden_objects": {"gltf": {"use_visible": True}},
    "y_up": {"usd": {"convert_orientation": True}},
    "cameras_and_lights": {"gltf": {"export_lights": True, "export_cameras": True}},
    "light_of_an_area": {"gltf": {"export_lights": True}},
    "animated_places": {"usd": {"export_animation": True}},
    "animated_and_left_in_the_middle": {"usd": {"export_animation": True}},
}
"""What exporters are told beyond the usual."""


def shown():
    """Triangles and bounds [m] of the meshes as they are rendered."""
    count, low, high = 0, np.full(3, np.inf), np.full(3, -np.inf)
    for each in bpy.context.evaluated_depsgraph_get().object_instances:
        thing = each.object
        data = thing.data
        if thing.type != "MESH" or not each.show_self or not data.vertices:
            continue
        data.calc_loop_triangles()
        count += sum(each.area > 1e-12 for each in data.loop_triangles)
        points = np.zeros(3 * len(data.vertices), np.float32)
        data.vertices.foreach_get("co", points)
        place = np.array(each.matrix_world)
        points = points.reshape(-1, 3) @ place[:3, :3].T + place[:3, 3]
        low, high = np.minimum(low, points.min(axis=0)), np.maximum(high, points.max(axis=0))
    return {"triangles": count, "low": low.tolist(), "high": high.tolist()}


found = {}
for name in sys.argv[2:] or SCENES:
    make, how = SCENES[name], HOW.get(name, {})
    bpy.ops.wm.read_factory_settings(use_empty=True)
    make()
    here = bpy.context.scene.frame_current
    bpy.context.scene.frame_set(bpy.context.scene.frame_start)
    found[name] = shown()
    bpy.context.scene.frame_set(here)
    bpy.ops.wm.usd_export(filepath=str(FOLDER / f"{name}.usdc"), **how.get("usd", {}))
    gltf = {"export_format": "GLB", "export_apply": True, **how.get("gltf", {})}
    bpy.ops.export_scene.gltf(filepath=str(FOLDER / f"{name}.glb"), **gltf)
(FOLDER / "found.json").write_text(json.dumps(found, indent=1))
