"""Count what Blender imports of a USD stage. Run by a Python that has bpy."""

import json
import sys

import bpy
import numpy as np

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
found = {"instances": 0, "sticks": 0, "triangles": 0}
low, high, seen = np.full(3, np.inf), np.full(3, -np.inf), {}


def box(data, points, radius):
    if data.name not in seen:
        column = np.zeros(3 * len(points), np.float32)
        points.foreach_get("co" if radius is None else "position", column)
        widest = 0.0
        if radius is not None:
            radii = np.zeros(len(points), np.float32)
            radius.data.foreach_get("value", radii)
            widest = radii.max()
        column = column.reshape(-1, 3)
        seen[data.name] = np.array((column.min(axis=0) - widest, column.max(axis=0) + widest))
    return seen[data.name]


for each in bpy.context.evaluated_depsgraph_get().object_instances:
    data = each.object.data
    if each.object.type == "CURVES" and each.is_instance:
        found["instances"] += 1
        found["sticks"] += len(data.points) - len(data.curves)
        own = box(data, data.points, data.attributes["radius"])
    elif each.object.type == "MESH":
        found["triangles"] += len(data.polygons)
        own = box(data, data.vertices, None)
    else:
        continue
    corners, place = np.array(np.meshgrid(*own.T)).reshape(3, -1), np.array(each.matrix_world)
    corners = place[:3, :3] @ corners + place[:3, 3:]
    low, high = np.minimum(low, corners.min(axis=1)), np.maximum(high, corners.max(axis=1))
print(json.dumps({**found, "bounds_m": [low.tolist(), high.tolist()]}))
