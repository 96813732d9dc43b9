"""A pack in LuxCore (pyluxcore 2.11): a runner of `lodbench run methods`.

    python luxcore_runner.py PACK/scene.usda PACK/camera.json -o OUT.exr --knob 4 --seed 0

The knob k makes k² samples of a pixel: the picture is rendered k times as wide and high with one
sample of each pixel, hazed at each sample's distance, and averaged. LuxCore has no round cones: a
stick is a prism with round ends (``SHAPES``), as wide on average as the cone. It needs pyluxcore,
usd-core, NumPy and OpenEXR.
"""

import argparse
import json
import os
import pickle
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import pack_geometry as pack

FINE, COARSE = (-89, -72, -54, -36, -18, 0), (-89, -60, -30, 0)
SHAPES = (
    (0.0, 8, (0,), 1.0),
    (0.01, 8, COARSE, 1.023),
    (0.075, 24, FINE, 1.008),
)
"""How a stick is made by its radius: from which on [m]; sides; latitudes of the rings of its round
ends [°]; how much further out those beside the equator lie, so that an end has the surface, and on
average the silhouette (Cauchy), of half a ball. Sticks are flat: where normals lean from their
facets light is lost, 1.4 % of it on eight sides."""


def main():
    """Read, build, render, write; print the seconds of each stage."""
    parser = argparse.ArgumentParser()
    for name in ("scene", "camera"):
        parser.add_argument(name)
    parser.add_argument("-o", required=True)
    parser.add_argument("--knob", type=float, default=4)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    start = time.perf_counter()
    folder, k = Path(asked.scene).parent, max(1, round(asked.knob))
    numbers, camera = pack.read_numbers(folder)
    models = list(pack.read_models(asked.scene))
    read = time.perf_counter()
    width, height = (k * n for n in camera["size"])
    with tempfile.TemporaryDirectory() as place:
        # LuxCore's maps begin in the east and turn by north to the west.
        sky = pack.sky_from_north(folder, numbers)[:, ::-1]
        pack.write_exr(Path(place) / "sky.exr", np.roll(sky, sky.shape[1] // 4, axis=1))
        given = numbers, camera, models, width, height, asked.seed
        (Path(place) / "given").write_bytes(pickle.dumps(given))
        # A process of its own: pyluxcore's allocator does not bear libraries that came before it.
        subprocess.run([sys.executable, __file__, RENDER, place], check=True, stdout=sys.stderr)
        with np.load(Path(place) / "made.npz") as made:
            clear, Z, build_s = made["clear"], made["Z"], float(made["build_s"])
    Z = np.where(np.isfinite(Z) & (Z < 1e9), Z, 1e10)
    directions = pack.directions_of(camera, width, height)
    picture = pack.averaged(pack.hazed(clear, Z, directions, numbers, folder), k)
    pack.write_exr(asked.o, picture, pack.one_of_each(Z, k, asked.seed))
    rest = time.perf_counter() - read - build_s
    print(json.dumps({"stages": {"read": read - start, "build": build_s, "trace": rest}}))


RENDER = "--render"
"""The first word of the process that renders."""


def render(place):
    """Render what the folder ``place`` gives, and leave the samples there."""
    import pyluxcore

    pyluxcore.Init(lambda words: None)
    numbers, camera, models, width, height, seed = pickle.loads((place / "given").read_bytes())
    start = time.perf_counter()
    scene = build(numbers, camera, models, (width, height), place)
    config = pyluxcore.RenderConfig(settings(numbers, width, height, seed), scene)
    session = pyluxcore.RenderSession(config)
    build_s = time.perf_counter() - start
    session.Start()
    while not session.HasDone():
        time.sleep(0.05)
        session.UpdateStats()
    film = session.GetFilm()
    clear = output(film, pyluxcore.FilmOutputType.RGB, (height, width, 3))
    Z = output(film, pyluxcore.FilmOutputType.DEPTH, (height, width))
    session.Stop()
    np.savez(place / "made.npz", clear=clear, Z=Z, build_s=build_s)
    os._exit(0)  # the library may crash where it is taken down


def output(film, kind, shape):
    """Read a channel of the film, rows from the top."""
    found = np.zeros(shape, np.float32)
    film.GetOutputFloat(kind, found, 0)
    return found[::-1].astype(np.float64)


def settings(numbers, width, height, seed):
    """Return the renderer's settings: one sample of each pixel, nothing clamped or cut short."""
    import pyluxcore

    made = pyluxcore.Properties()
    rows = {
        # The sampler of tiles gives the same samples whatever the seed.
        "renderengine.type": "PATHCPU",
        "renderengine.seed": seed + 1,
        "sampler.type": "RANDOM",
        "sampler.random.adaptive.strength": 0.0,
        "batch.haltspp": 1,
        # Edges of a path, and not surfaces: a depth of 2 has the light of 1.
        "path.pathdepth.total": numbers["integrator"]["max_depth"],
        "path.pathdepth.diffuse": numbers["integrator"]["max_depth"],
        "path.russianroulette.depth": 1000,
        "path.clamping.variance.maxvalue": 0,
        "path.hybridbackforward.enable": 0,
        "lightstrategy.type": "UNIFORM",
        "film.width": width,
        "film.height": height,
        "film.filter.type": "NONE",
        "film.outputs.0.type": "RGB",
        "film.outputs.0.filename": "colour.exr",
        "film.outputs.1.type": "DEPTH",
        "film.outputs.1.filename": "depth.exr",
    }
    for name, value in rows.items():
        made.Set(pyluxcore.Property(name, value))
    return made


def build(numbers, camera, models, size, place):
    """Make the scene: camera, sun and sky, models and their copies."""
    import pyluxcore

    scene = pyluxcore.Scene()
    eye, forward, up = (np.array(camera[name], np.float64) for name in ("eye", "forward", "up"))
    light = numbers["light"]
    width, height = size
    high = height / width
    lower = 2 * high / height
    parse(
        scene,
        {
            "scene.camera.type": "perspective",
            "scene.camera.lookat.orig": eye.tolist(),
            "scene.camera.lookat.target": (eye + forward).tolist(),
            "scene.camera.up": up.tolist(),
            "scene.camera.fieldofview": camera["fov_deg"],
            # Its rows are counted from below, and stand one sample too low: look as much lower.
            "scene.camera.screenwindow": [-1.0, 1.0, -high - lower, high - lower],
            "scene.camera.cliphither": camera.get("near_m", 0.05),
            "scene.camera.clipyon": camera.get("far_m", 1e7),
            "scene.camera.autovolume.enable": 0,
            "scene.lights.sun.type": "sharpdistant",
            "scene.lights.sun.direction": (-np.array(light["to_sun"])).tolist(),
            "scene.lights.sun.color": list(light["sun_irradiance"]),
            "scene.lights.sky.type": "infinite",
            "scene.lights.sky.file": str(place / "sky.exr"),
            "scene.lights.sky.gamma": 1.0,
            "scene.lights.sky.colorspace": "nop",
            "scene.lights.sky.storage": "float",
            "scene.textures.albedo.type": "hitpointcolor",
            "scene.materials.matte.type": "matte",
            "scene.materials.matte.kd": "albedo",
        },
    )
    for number, (geometry, places, turn) in enumerate(models):
        meshes = [*geometry.meshes, *capsules(geometry)]
        for part, (vertices, faces, normals, colours) in enumerate(meshes):
            name = f"m{number}p{part}"
            rows = vertices, faces.astype(int), normals, None, np.asarray(colours, float), None
            columns = (None if each is None else list(map(tuple, each.tolist())) for each in rows)
            scene.DefineMesh(name, *columns)
            for copy, (at, (cos, sin)) in enumerate(zip(places, turn, strict=True)):
                # Columns of the matrix, one after another.
                matrix = [cos, sin, 0, 0, -sin, cos, 0, 0, 0, 0, 1, 0, *at, 1]
                lead = f"scene.objects.{name}c{copy}"
                rows = {f"{lead}.shape": name, f"{lead}.material": "matte"}
                if len(places) > 1 or np.any(at):
                    rows[f"{lead}.transformation"] = [float(each) for each in matrix]
                parse(scene, rows)
    return scene


def parse(scene, rows):
    """Hand properties to a scene."""
    import pyluxcore

    made = pyluxcore.Properties()
    for name, value in rows.items():
        made.Set(pyluxcore.Property(name, value))
    scene.Parse(made)


def capsules(geometry):
    """Yield sticks as a mesh of each shape: vertices, faces, no normals, albedos."""
    begins = np.cumsum(geometry.counts) - geometry.counts
    last = np.zeros(len(geometry.points), bool)
    last[begins + geometry.counts - 1] = True
    first = np.flatnonzero(~last)
    tints = np.repeat(geometry.tints, geometry.counts, axis=0)[first]
    one, two = geometry.points[first].astype(float), geometry.points[first + 1].astype(float)
    which = np.searchsorted([row[0] for row in SHAPES], np.maximum(one[:, 3], two[:, 3]), "right")
    for row, shape in enumerate(SHAPES, 1):
        if (mine := which == row).any():
            yield tubes(one[mine], two[mine], tints[mine], *shape[1:])


def tubes(one, two, tints, sides, latitudes, further):
    """Return sticks between ends (n, 4), with a ring of vertices for each latitude of each end."""
    axis = two[:, :3] - one[:, :3]
    length = np.linalg.norm(axis, axis=1, keepdims=True)
    axis = np.where(length > 1e-9, axis / np.maximum(length, 1e-9), [[0.0, 0.0, 1.0]])
    other = np.where(np.abs(axis[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    x = np.cross(axis, other)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(axis, x)
    turn = 2 * np.pi * np.arange(sides) / sides
    out = np.cos(turn)[:, None] * x[:, None] + np.sin(turn)[:, None] * y[:, None]  # (n, s, 3)
    wider = np.pi / sides / np.sin(np.pi / sides)  # the mean width of a prism is that of a cone
    vertices = []
    rings = [(one, a) for a in latitudes] + [(two, -a) for a in reversed(latitudes)]
    for ball, degrees in rings:
        latitude = np.radians(degrees)
        normal = np.cos(latitude) * out + np.sin(latitude) * axis[:, None]
        radius = ball[:, None, 3:] * wider * (further if degrees else 1.0)
        vertices.append(ball[:, None, :3] + radius * normal)
    vertices = np.stack(vertices, axis=1)  # (n, r, s, 3)
    n, r = vertices.shape[:2]
    s, after = np.arange(sides), (np.arange(sides) + 1) % sides
    quads = []
    for ring in range(r - 1):
        a, b = ring * sides, (ring + 1) * sides
        quads += [
            np.stack([a + s, a + after, b + after], 1),
            np.stack([a + s, b + after, b + s], 1),
        ]
    faces = np.concatenate(quads)[None] + (np.arange(n) * r * sides)[:, None, None]
    colours = np.repeat(tints, r * sides, axis=0)
    return vertices.reshape(-1, 3), faces.reshape(-1, 3), None, colours


if __name__ == "__main__":
    render(Path(sys.argv[2])) if sys.argv[1:2] == [RENDER] else main()
