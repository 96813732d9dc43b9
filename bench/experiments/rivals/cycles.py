"""Is what pruning gains the renderer's or the metric's? The same frames in Cycles.

Both renderers draw the same sticks, meshes, sun and sky in clear air, with a box filter and paths
of the same length: whole, and cut by the metric. Each has noise and errors of its own, against its
own whole picture.
"""

import json
import os
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from bench.arms.registry import OURS
from bench.experiments.rivals.noise import noise
from bench.experiments.rivals.turns import Runner, prepared_runner
from bench.experiments.rivals.windows import Window
from bench.outside.child_process import answer_of
from bench.outside.environments import CYCLES
from bench.outside.scene_arrays import scene_arrays
from bench.records.points import Column, Point
from bench.statistics.excess_flip import mean_flip
from scenes.render.description.describe import describe_frame
from scenes.render.pictures.tone_map import auto_exposure, to_srgb
from scenes.render.pipeline.stages import build_frame
from scenes.world.world import build_world

TRIED = (("full", 0.0), ("blake", 1.0), ("blake", 4.0))
"""Arms and settings that are rendered, the whole first."""

SEEDS = 0, 1

Pictures = Sequence[np.ndarray]


def measure_cycles(case: Window, seed: int) -> list[Point]:
    """Render one window in both renderers, whole and cut; needs the environment ``CYCLES``."""
    preset = case.preset(seed, "air.visibility=clear")
    world = build_world(preset)
    where = {"part": "cycles", "kind": case.kind, "objects": case.objects, "field": case.field}
    whole: dict[str, Pictures] = {}
    points = []
    for name, setting in TRIED:
        runner = prepared_runner(OURS[name], setting, world, preset)
        found = {"mitsuba": _mitsuba(runner, case), "cycles": _cycles(runner, case)}
        runner.forget()
        for renderer, (pictures, samples) in found.items():
            compared = _errors(pictures, whole.setdefault(renderer, pictures))
            grain = Column("noise", noise(pictures, case.picture.spp))
            light = Column("light", [round(1e6 * float(each.mean())) for each in pictures])
            named = {**where, "arm": name, "setting": setting, "renderer": renderer}
            points.append(Point(named, samples=(*samples, grain, light, *compared)))
    return points


def _mitsuba(runner: Runner, case: Window) -> tuple[Pictures, list[Column]]:
    """Build and trace by Mitsuba twice; the first time compiles, and is not counted."""
    runner.made = runner.updater(1, case.variant)
    for _ in range(2):
        runner.built = build_frame(runner.made)
    layers = [runner.picture(each) for each in (*SEEDS, *SEEDS)][len(SEEDS) :]
    times = {stage: [layers[0].seconds[stage]] for stage in ("describe", "build")}
    times["trace"] = [each.seconds["trace"] for each in layers]
    sticks = Column("sticks", [runner.statistics["sticks"]])
    return [each.rgb.astype(np.float64) for each in layers], [sticks, *_times(times)]


def _cycles(runner: Runner, case: Window) -> tuple[Pictures, list[Column]]:
    """Render by Cycles; what one sample takes is read from a picture of one and those of many."""
    made = runner.updater(1, case.variant)
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
    return list(pictures), [held, *_times({**times, "trace": traced})]


def _times(seconds: dict[str, list[float]]) -> list[Column]:
    return [
        Column("us", [round(1e6 * each) for each in row], {"stage": stage})
        for stage, row in seconds.items()
    ]


def _errors(tested: Pictures, whole: Pictures) -> list[Column]:
    """Return FLIP to the whole picture of another seed, and that of the whole one itself."""
    exposure = auto_exposure(whole[1])
    one, two, other = (
        to_srgb(np.maximum(each, 0.0), exposure).astype(np.float32)
        for each in (tested[0], whole[0], whole[1])
    )
    return [
        Column("flip", [round(1e6 * mean_flip(one, other))]),
        Column("flip_floor", [round(1e6 * mean_flip(two, other))]),
    ]
