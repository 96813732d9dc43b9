"""What frames cost: worlds of so many objects, and functions that are called in fresh processes.

Those import no more than rendering needs, for the memory of the process is among what is measured.
Every process's first frame compiles, or loads what was compiled.
"""

import hashlib
import math
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.children import run_in_child
from bench.records.records import Column, Point, columns
from lod.errors import InputError
from lod.law import max_ground_distance
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import peak_rss_bytes
from scenes.render.description import describe_frame
from scenes.render.exr.layer_file import write_exr
from scenes.render.render import build_frame, render_frame, trace
from scenes.scene import Scene

Kind = tuple[str | Preset, tuple[str, ...]]
"""A kind of world: its preset, and what is changed in it."""

_BARE = "species.sward.density=0"
"""Trees and people are compared; blades of grass would be nearly all parts there are."""

KINDS: dict[str, Kind] = {
    "meadow": ("meadow", (_BARE,)),
    "crowd": ("crowd", ("species.tree.density=0",)),
    "still crowd": ("crowd", ("species.tree.density=0", "species.figure.patrol=0")),
    "swaying": ("meadow", (_BARE, "wind.speed=6")),
    "forest": ("forest", (_BARE,)),
    "swaying forest": ("forest", (_BARE, "wind.speed=6")),
    "from above": ("meadow", (_BARE, "camera.height=60", "camera.pitch=-20")),
}
"""The kinds of world by their names: nothing moves in ``meadow``."""

AT_ORIGIN = "camera.position=[0, 0]", "camera.cell=[0, 0]", "camera.keys=[]"
"""Settings that put the eye in the middle of the world."""

SETTINGS = ("render.size=320x180", "render.spp=8", _BARE)
FRAMES = 4
"""Frames of ``meadow`` in each process, after the first, and what is changed in the preset."""

WORLD, SPECIES = "crowd", "figure"
WORLDS = (1e3, 1e5, 1e6, 1e9, 1e12, 1e15)
UNPRUNED = (1e2, 1e3, 3e3, 1e4)
"""The mean number of objects in an unpruned window; the last has some 10⁶ parts, the most."""

FIRST_SAMPLES = {"whole": 0, "pruned": 1000}
"""The frame number of the samples of each side's first picture: no two have the same."""


@dataclass(frozen=True)
class Picture:
    """Size in pixels, as ``320x180``, and samples of each pixel."""

    size: str
    spp: int


def own_kind(preset: Preset) -> Kind:
    """Return the kind of world of a user's preset: its eye in the middle, and no grass.

    Raises InputError where nothing else stands there.
    """
    grass = [name for name, each in preset.species.items() if each.model == "sward"]
    if not any(each.density > 0 for name, each in preset.species.items() if name not in grass):
        rule = "cost and methods measure windows of objects, in which grass is left out"
        raise InputError("--preset", ", ".join(grass), rule, "add a species, or run law or images")
    return preset, (*AT_ORIGIN, *(f"species.{name}.density=0" for name in grass))


def window_preset(
    name: str | Preset,
    settings: Sequence[str],
    objects: float,
    picture: Picture,
    detail: float | None,
) -> Preset:
    """Make a preset with a window of so many objects, on average, about the eye, on level ground.

    The ground ends with the window, so that it is the same few triangles in every frame of it: what
    differs is what stands on it. ``detail`` is τ [px]; None leaves the world unpruned.
    """
    plain = load_preset(name, settings)
    side = math.sqrt(objects / sum(each.density for each in plain.species.values()))
    keys = [f"world.extent={side!r}", f"render.size={picture.size}", f"render.spp={picture.spp}"]
    keys += [f"terrain.reach={min(plain.terrain.reach, side / math.sqrt(2))!r}"]
    keys += ["terrain.amplitude=0.0"]
    keys += ["view.metric=full"] if detail is None else [f"view.detail={detail!r}"]
    return load_preset(name, [*settings, *keys])


@dataclass(frozen=True)
class Size:
    """One field of one size of world; ``samples`` are those of the pictures that are compared.

    ``world`` is that of ``kind`` where it is none of KINDS.
    """

    kind: str
    objects: float
    field: int
    unseen: bool
    size: str
    spp: int
    frames: int
    samples: tuple[int, ...]
    variant: str
    world: Kind | None = None

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"


def preset_costs(overrides: list[str], variant: str, frames: int) -> dict[str, Any]:
    """Build the world of ``meadow`` and time its frames after the first, which compiles [µs]."""
    scene = Scene(load_preset("meadow", overrides))
    start = time.perf_counter()
    world = scene.world
    built, warm = _us(time.perf_counter() - start), []
    for frame in range(1, frames + 2):
        made = scene.input(frame, variant)
        layers = render_frame(made, frame)
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            write_exr(Path(folder) / "frame.exr", layers, {})
            write = time.perf_counter() - start
        if frame > 1:
            stages = {**made.seconds, **layers.seconds, "write": write}
            view = scene.view(frame)
            tests = sum(prune(each, view).examined_parts for each in world.representations)
            warm.append({k: _us(v) for k, v in stages.items()} | {"metric": _metric_us(tests)})
    return {"world": built, "warm": warm}


def _metric_us(tests: int) -> int:
    x, y, z, D = np.random.default_rng(0).random((4, tests))
    for _ in range(2):
        start = time.perf_counter()
        np.sqrt(x * x + y * y + z * z) < D  # noqa: B015
        spent = time.perf_counter() - start
    return _us(spent)


def measure_process(number: int, variant: str, seed: int) -> list[Point]:
    """Time the frames of a preset in a fresh process, and how long its world takes before them."""
    words = [*SETTINGS, f"seed={seed + number}"]
    found = run_in_child(preset_costs, words, variant, FRAMES, variant=variant).result
    rows = found["warm"]
    times = (Column("us", [row[stage] for row in rows], {"stage": stage}) for stage in rows[0])
    return [
        Point({"topic": "cost", "what": "frames"}, samples=tuple(times)),
        Point({"topic": "cost", "what": "processes"}, samples=columns({"world": [found["world"]]})),
    ]


def window_costs(case: Size, side: str, seed: int) -> dict[str, Any]:
    """Build one world, whole or pruned at one pixel, and time its frames.

    rows         microseconds of every stage of each frame after the first
    peak_bytes   the most memory that one frame takes
    statistics   counts of the last frame
    pictures     of the first frame, one for each of the case's counts of samples
    """
    name, settings = case.world or KINDS[case.kind]
    picture = Picture(case.size, case.spp)
    detail = None if side == "whole" else 1.0
    scene = Scene(window_preset(name, (*settings, f"seed={seed}"), case.objects, picture, detail))
    rows, peak = [], 0
    for frame in range(1, case.frames + 2):
        made = scene.input(frame, case.variant)
        layers = render_frame(made, frame)
        if frame == 1:
            peak = peak_rss_bytes()
        else:
            spent = {**made.seconds, **layers.seconds}
            rows.append({stage: _us(seconds) for stage, seconds in spent.items()})
    made = scene.input(1, case.variant)
    built, first = build_frame(made), FIRST_SAMPLES[side]
    pictures = [
        trace(built, replace(made.quality, spp=spp), first + k).rgb
        for k, spp in enumerate(case.samples)
    ]
    counts = layers.statistics
    return {"rows": rows, "peak_bytes": peak, "statistics": counts, "pictures": pictures}


def plain_frame(scene: Scene) -> dict[str, Any]:
    """Prune the first frame of a scene, and describe it as plain arrays, before any renderer."""
    return describe_frame(scene.input(1, "scalar_rgb"))


def frame_digest(plain: dict[str, Any]) -> str:
    """Hash everything in a plain frame that determines the picture: 16 hexadecimal digits."""
    sha = hashlib.sha256()
    for name, shape in sorted(plain["shapes"].items()):
        sha.update(name.encode())
        for key in ("control_points", "segment_indices", "albedo", "vertices", "faces", "colours"):
            sha.update(np.ascontiguousarray(shape.get(key, ())).tobytes())
        sha.update(plain["ids"][plain["owners"][name]].tobytes())
    return sha.hexdigest()[:16]


def measure_worlds(repeats: int, seed: int) -> list[Point]:
    """Make the first frame of every world again and again, all in turns: counts, and times."""
    grid = [("blake", n) for n in WORLDS] + [("full", n) for n in UNPRUNED]
    density = load_preset(WORLD).species[SPECIES].density
    points, scenes = [], []
    for metric, objects in grid:
        side = min(math.sqrt(objects / density), 1e15)
        keys = f"world.extent={side!r}", f"view.metric={metric}", f"seed={seed}"
        scene = Scene(load_preset(WORLD, ["render.size=96x54", *keys]))
        view, plain = scene.view(1), plain_frame(scene)  # compiles, and is not timed
        fields = scene.world.fields
        limits = [
            max_ground_distance(each.prototypes.part_tables.hierarchies, view)
            for each in fields
            if metric != "full"
        ]
        case_of = {
            "topic": "world",
            "metric": metric,
            "objects": objects,
            "side_m": side,
            "limit_m": max(limits, default=0.0),
            "scene": frame_digest(plain),
        }
        parts = sum(prune(each, view).displayed_parts for each in fields)
        points.append(Point(case_of, samples=(Column("parts", [parts]),)))
        scenes.append(scene)
    times: list[list[int]] = [[] for _ in scenes]
    for _ in range(repeats):  # in turns, so that drift meets all of them
        for scene, row in zip(scenes, times, strict=True):
            start = time.thread_time()
            plain_frame(scene)
            row.append(_us(time.thread_time() - start))
    return [
        replace(point, samples=(*point.samples, Column("cpu_us", row)))
        for point, row in zip(points, times, strict=True)
    ]


def _us(seconds: float) -> int:
    return round(1e6 * seconds)
