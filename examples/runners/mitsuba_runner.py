"""A pack in plain Mitsuba 3, by its own path integrator: a runner of `lodbench run methods`.

    python mitsuba_runner.py PACK/scene.usda PACK/camera.json -o OUT.exr --knob 16 --seed 0

The knob is the number of samples of a pixel. An integrator around Mitsuba's hazes each sample at
its own distance. It needs mitsuba, usd-core, NumPy and OpenEXR.
"""

import argparse
import json
import tempfile
import time
from pathlib import Path

import drjit as dr
import mitsuba as mi
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
    parser.add_argument("--variant", default="llvm_ad_rgb")
    asked = parser.parse_args()
    mi.set_variant(asked.variant)
    start = time.perf_counter()
    folder, samples = Path(asked.scene).parent, max(1, round(asked.knob))
    numbers, camera = pack.read_numbers(folder)
    geometry = pack.read_geometry(asked.scene)
    read = time.perf_counter()
    scene = build(numbers, camera, geometry, folder)
    hazed = hazed_integrator(numbers, folder)
    built = time.perf_counter()
    passes = -(-samples // MOST_AT_ONCE)
    seeds = range(asked.seed * passes, (asked.seed + 1) * passes)
    spp = -(-samples // passes)
    picture = sum(np.array(mi.render(scene, integrator=hazed, spp=spp, seed=k)) for k in seeds)
    depth = mi.load_dict({"type": "aov", "aovs": "z:depth"})
    Z = np.array(mi.render(scene, integrator=depth, spp=1, seed=asked.seed))[..., -1]
    pack.write_exr(asked.o, picture / passes, np.where(Z > 0, Z, 1e10))
    seconds = {"read": read - start, "build": built - read, "trace": time.perf_counter() - built}
    print(json.dumps({"stages": seconds}))


MOST_AT_ONCE = 16
"""More samples of a pixel than these take turns, for their memory."""


def hazed_integrator(numbers, folder):
    """Make an integrator that lays the pack's haze over each sample of Mitsuba's path tracer."""
    depth = numbers["integrator"]["max_depth"]
    path = mi.load_dict({"type": "path", "max_depth": depth, "rr_depth": 100})
    beta = mi.Color3f(numbers["haze"]["beta"])
    horizon = float(np.sin(np.radians(numbers["haze"]["horizon_deg"])))
    airlight = pack.read_exr(folder / numbers["light"]["sky"]["airlight"])[0]
    columns, rows = len(airlight), mi.Float(airlight.ravel())

    class Hazed(mi.SamplingIntegrator):
        def sample(self, scene, sampler, ray, medium=None, active=True):
            clear, _, _ = path.sample(scene, sampler, ray, medium, active)
            hit = scene.ray_intersect_preliminary(ray)
            low_sky = ray.d.z < horizon
            T = dr.exp(-beta * dr.select(hit.is_valid(), hit.t, dr.select(low_sky, dr.inf, 0)))
            turn = dr.atan2(ray.d.x, ray.d.y) / dr.two_pi
            at = (turn - dr.floor(turn)) * columns
            low = mi.UInt32(at)
            one, two = (dr.gather(mi.Color3f, rows, each % columns) for each in (low, low + 1))
            A = dr.lerp(one, two, at - low)
            return clear * T + A * (1 - T), True, []

    return Hazed(mi.Properties())


def build(numbers, camera, geometry, folder):
    """Make the scene: sticks by colour, meshes, sun and sky, camera."""
    T = mi.ScalarTransform4f
    eye, forward, up = (np.array(camera[name], np.float64) for name in ("eye", "forward", "up"))
    light = numbers["light"]
    scene = {
        "type": "scene",
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
                "width": camera["size"][0],
                "height": camera["size"][1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "multijitter"},
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
