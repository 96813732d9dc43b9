"""Is what pruning gains the renderer's or the metric's? The same frames in Cycles.

Both renderers draw the same sticks, meshes, sun and sky in clear air, with a box filter and paths
of the same length: unpruned, and cut by the metric. Each has noise and errors of its own, against
its own unpruned picture.
"""

import json
import os
import tempfile
import time
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from bench.images.differences import EPSILON, mean_flip
from bench.methods.environments import CYCLES, answer_of
from bench.methods.known_methods import METHODS
from bench.methods.runner import Runner, Window
from bench.records.records import Column, Point
from scenes.render import variants
from scenes.render.description import Description, chains, describe_frame
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import build_frame

TRIED = (("full", 0.0), ("blake", 1.0), ("blake", 4.0))
"""Methods and settings that are rendered, the unpruned first."""

SEEDS = 0, 1

SKY_ROWS = 256
"""Rows of the picture of the sky: it has no sun, and changes slowly."""

_MESH = "vertices", "faces", "normals", "colours"

Pictures = Sequence[np.ndarray]


def measure_cycles(case: Window, seed: int) -> list[Point]:
    """Render one window in both renderers, unpruned and cut; needs the environment ``CYCLES``."""
    scene = case.scene(seed, "air.visibility=clear")
    named: dict[str, Any] = {"topic": "rivals", "part": "cycles", "kind": case.kind}
    named |= {"objects": case.objects, "field": case.field}
    reference: dict[str, Pictures] = {}
    points = []
    for name, setting in TRIED:
        runner = Runner(METHODS[name], setting, scene)
        found = {"mitsuba": _mitsuba(runner, case)}
        runner.forget()
        found["cycles"] = _cycles(Runner(METHODS[name], setting, scene), case)
        for renderer, (pictures, samples, seconds) in found.items():
            first, other = reference.setdefault(renderer, pictures)
            exposure = auto_exposure(other)
            shown = [
                to_srgb(np.maximum(each, 0.0), exposure).astype(np.float32)
                for each in (pictures[0], first, other)
            ]
            columns = {
                "noise": noise(pictures, case.picture.spp),
                "light": [round(1e6 * float(each.mean())) for each in pictures],
                "flip": [round(1e6 * mean_flip(shown[0], shown[2]))],
                "flip_floor": [round(1e6 * mean_flip(shown[1], shown[2]))],
            }
            times = (
                Column("us", [round(1e6 * each) for each in row], {"stage": stage})
                for stage, row in seconds.items()
            )
            where = {**named, "arm": name, "setting": setting, "renderer": renderer}
            errors = (Column(quantity, row) for quantity, row in columns.items())
            points.append(Point(where, samples=(samples, *times, *errors)))
    return points


def _mitsuba(runner: Runner, case: Window) -> tuple[Pictures, Column, dict[str, list[float]]]:
    runner.made = runner.update(1, case.variant)
    for _ in range(2):
        runner.built = build_frame(runner.made)
    layers = [runner.picture(each) for each in (*SEEDS, *SEEDS)][len(SEEDS) :]
    times = {stage: [layers[0].seconds[stage]] for stage in ("describe", "build")}
    times["trace"] = [each.seconds["trace"] for each in layers]
    sticks = Column("sticks", [runner.statistics["sticks"]])
    return [each.rgb.astype(np.float64) for each in layers], sticks, times


def _cycles(runner: Runner, case: Window) -> tuple[Pictures, Column, dict[str, list[float]]]:
    """Render by Cycles; what one sample takes is read from a picture of one and those of many."""
    made = runner.update(1, variants.SCALAR_VARIANT)  # in which nothing is a copy of a model
    start = time.perf_counter()
    arrays = scene_arrays(describe_frame(made), case.variant)
    describe = time.perf_counter() - start
    spp = case.picture.spp
    asked = {"spp": spp, "seeds": SEEDS, "max_depth": made.quality.max_depth}
    with tempfile.TemporaryDirectory() as folder:
        source, target = (str(Path(folder) / name) for name in ("scene.npz", "pictures.npz"))
        np.savez(source, **arrays)
        words = json.dumps({**asked, "threads": os.cpu_count() or 1})
        found = answer_of(CYCLES, "cycles_child.py", words, source, target)
        pictures = np.load(target)["pictures"].astype(np.float64)
    seconds: dict[str, Any] = found["seconds"]
    (one,), most = seconds["one"], seconds["all"]
    traced = [max(each - one, 0.0) * spp / (spp - 1) for each in most]
    build = [max(one - each / spp, 0.0) for each in traced]
    times = {"describe": [describe], "synchronise": seconds["synchronise"], "build": build}
    held = Column("peak_bytes", [found["peak_bytes"][1]])
    return list(pictures), held, {**times, "trace": traced}


def noise(pictures: Pictures, spp: int) -> list[int]:
    """Return the relative variance of a sample, from each picture and the next [millionths].

    It is the variance of a pixel times its samples, ÷ squared light; a
    stratified sampler has less than independent samples would have.
    """
    mean = np.mean(pictures, axis=0)
    exposure = auto_exposure(mean)
    over = (mean * exposure) ** 2 + EPSILON
    squares = (((a - b) * exposure) ** 2 / over for a, b in pairwise(pictures))
    found = (spp * np.mean(each) / 2 for each in squares)
    return [round(1e6 * float(each)) for each in found]


def scene_arrays(description: Description, variant: str) -> dict[str, Any]:
    """Return the frame's arrays: camera, sun and sky, chains of sticks, and meshes.

    points     (p, 4) ends of sticks and their radii, chain by chain [m]
    counts     (c,) how many points each chain has
    tints      (c, 3) albedo of each chain
    sun        (3,) irradiance of what faces the sun; ``sky`` (rows, 2·rows, 3) radiance from all
               directions, rows from the zenith down, of azimuths that fall from +π to −π, east is
               0. Below the horizon it is the airlight, which the eye sees and nothing is lit by
    meshes     how many there are; ``meshN.vertices`` and so on of each
    """
    camera, shapes = description["camera"], description["shapes"].values()
    chained = [chains(each) for each in shapes if each["type"] == "linearcurve"]
    meshes = [each for each in shapes if each["type"] == "mesh"]
    empty = np.zeros((0, 4), np.float32), np.zeros(0, np.int64), np.zeros((0, 3))
    columns = zip(*chained, strict=True) if chained else ([each] for each in empty)
    points, counts, tints = (np.concatenate(list(column)) for column in columns)
    return {
        **{name: camera[name] for name in ("eye", "forward", "up")},
        "lens": np.array([*camera["size"], np.radians(camera["fov_x_deg"])]),
        **dict(zip(("points", "counts", "tints"), (points, counts, tints), strict=True)),
        **light_arrays(description["light"], variant),
        "meshes": len(meshes),
        **{f"mesh{k}.{name}": m[name] for k, m in enumerate(meshes) for name in _MESH},
    }


def light_arrays(light: Description, variant: str) -> dict[str, np.ndarray]:
    """Return the sun's irradiance and direction, and the sky's radiance from all directions."""
    variants.use(variant)
    from scenes.render.light import HORIZON_DEG, sky_radiance, sun_irradiance

    elevation = np.pi * (0.5 - (np.arange(SKY_ROWS) + 0.5) / SKY_ROWS)
    turn = 2 * np.pi * (0.5 - (np.arange(2 * SKY_ROWS) + 0.5) / (2 * SKY_ROWS))
    seen_up = np.maximum(elevation, np.radians(HORIZON_DEG))
    e, a = np.meshgrid(seen_up, turn, indexing="ij")
    towards = np.stack([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)], axis=-1)
    seen = sky_radiance(light, towards.reshape(-1, 3)).reshape(towards.shape)
    return {
        "sky": seen.astype(np.float32),
        "to_sun": light["to_sun"],
        "sun": sun_irradiance(light),
    }
