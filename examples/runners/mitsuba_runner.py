"""A pack in plain Mitsuba 3, by its own path integrator: a runner of `lodbench run methods`.

    python mitsuba_runner.py PACK/scene.usda PACK/camera.json -o OUT.exr --knob 4 --seed 0

The knob k makes k² samples of a pixel: the picture is rendered k times as wide and high with one
sample of each pixel, hazed at each sample's distance, and averaged. It needs mitsuba, usd-core,
NumPy and OpenEXR.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import mitsuba as mi
import numpy as np
import pack_geometry as pack


def main():
    """Read, build, render, write; print the seconds of each stage."""
    parser = argparse.ArgumentParser()
    for name in ("scene", "camera"):
        parser.add_argument(name)
    parser.add_argument("-o", required=True)
    parser.add_argument("--knob", type=float, default=4)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--variant", default="llvm_ad_rgb")
    asked = parser.parse_args()
    mi.set_variant(asked.variant)
    start = time.perf_counter()
    folder, k = Path(asked.scene).parent, max(1, round(asked.knob))
    numbers, camera = pack.read_numbers(folder)
    geometry = pack.read_geometry(asked.scene)
    read = time.perf_counter()
    scene = build(numbers, camera, geometry, folder, k)
    built = time.perf_counter()
    size = camera["size"][0] * k, camera["size"][1] * k
    channels = np.array(mi.render(scene, spp=1, seed=asked.seed), np.float64)
    clear, Z = channels[..., :3], channels[..., -1]
    Z = np.where(Z > 0, Z, 1e10)
    directions = pack.directions_of(camera, *size)
    picture = pack.averaged(pack.hazed(clear, Z, directions, numbers, folder), k)
    pack.write_exr(asked.o, picture, pack.one_of_each(Z, k, asked.seed))
    seconds = {"read": read - start, "build": built - read, "trace": time.perf_counter() - built}
    print(json.dumps({"stages": seconds}))


def build(numbers, camera, geometry, folder, k):
    """Make the scene: sticks by colour, meshes, sun and sky, camera."""
    T = mi.ScalarTransform4f
    eye, forward, up = (np.array(camera[name], np.float64) for name in ("eye", "forward", "up"))
    light = numbers["light"]
    scene = {
        "type": "scene",
        "integrator": {
            "type": "aov",
            "aovs": "z:depth",
            "path": {
                "type": "path",
                "max_depth": numbers["integrator"]["max_depth"],
                "rr_depth": 100,
            },
        },
        "sensor": {
            "type": "perspective",
            "fov": camera["fov_deg"],
            "fov_axis": "x",
            "near_clip": camera.get("near_m", 0.05),
            "far_clip": camera.get("far_m", 1e7),
            "to_world": T().look_at(
                origin=eye.tolist(), target=(eye + forward).tolist(), up=up.tolist()
            ),
            "film": {
                "type": "hdrfilm",
                "width": camera["size"][0] * k,
                "height": camera["size"][1] * k,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        },
        "sun": {
            "type": "directional",
            "direction": (-np.array(light["to_sun"])).tolist(),
            "irradiance": {"type": "rgb", "value": light["sun_irradiance"]},
        },
        # A y-up map, laid on its side: its first column is north, and columns turn clockwise.
        "sky": {
            "type": "envmap",
            "bitmap": mi.Bitmap(pack.sky_from_north(folder, numbers).astype(np.float32)),
            "to_world": T().rotate([1, 0, 0], 90),
        },
    }
    for number, (vertices, faces, normals, colours) in enumerate(geometry.meshes):
        scene[f"mesh{number}"] = mesh(f"mesh{number}", vertices, faces, normals, colours)
    begins = np.concatenate([[0], np.cumsum(geometry.counts)])
    colours, which = np.unique(geometry.tints.round(6), axis=0, return_inverse=True)
    with tempfile.TemporaryDirectory() as place:
        stub = Path(place) / "stub.txt"
        stub.write_text("0 0 0 1\n0 0 1 1\n")
        for row, colour in enumerate(colours):
            scene[f"sticks{row}"] = {
                "type": "linearcurve",
                "filename": str(stub),
                "bsdf": matte({"type": "rgb", "value": colour.tolist()}),
            }
        made = mi.load_dict(scene)
    parameters = mi.traverse(made)
    which = which.reshape(-1)
    for row in range(len(colours)):
        chains = np.flatnonzero(which == row)
        counts = geometry.counts[chains]
        first = np.repeat(begins[chains] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts)
        points = geometry.points[first + np.arange(counts.sum())]
        last = np.zeros(len(points), bool)
        last[np.cumsum(counts) - 1] = True
        name = f"sticks{row}"
        parameters[f"{name}.control_point_count"] = len(points)
        parameters[f"{name}.control_points"] = mi.Float(points.ravel())
        parameters[f"{name}.segment_indices"] = mi.UInt32(np.flatnonzero(~last).astype(np.uint32))
    parameters.update()
    return made


def matte(reflectance):
    """Return a diffuse surface with two sides."""
    return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": reflectance}}


def mesh(name, vertices, faces, normals, colours):
    """Return a mesh of a matte of its vertices' albedos."""
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(matte({"type": "mesh_attribute", "name": "vertex_albedo"}))
    made = mi.Mesh(name, len(vertices), len(faces), has_vertex_normals=True, props=properties)
    made.add_attribute("vertex_albedo", 3, np.ascontiguousarray(colours, np.float32).ravel())
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = mi.Float(vertices.ravel())
    parameters["vertex_normals"] = mi.Float(normals.ravel())
    parameters["faces"] = mi.UInt32(faces.ravel())
    parameters["vertex_albedo"] = mi.Float(np.ascontiguousarray(colours, np.float32).ravel())
    parameters.update()
    return made


if __name__ == "__main__":
    main()
