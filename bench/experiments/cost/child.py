"""How long does every stage of a preset's frames take in a fresh process? Run as a module.

It prints one JSON object in microseconds and bytes: ``cold`` for the process, with the first frame,
which compiles, and ``warm`` for each further frame.
"""

import json
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from lod.air import CLEAR
from lod.pruner import prune
from lod.view import View
from scenes.frame.assemble import assemble_frame
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.preset.load import load_preset
from scenes.render.files.exr import write_exr
from scenes.render.pipeline.peak_memory import peak_rss_bytes
from scenes.render.pipeline.render import render_frame
from scenes.world.view import view_at
from scenes.world.world import World, build_world

Row = dict[str, int]


def measure(overrides: list[str], variant: str, frames: int) -> dict[str, Any]:
    """Build the world and time its frames: one that compiles, and ``frames`` that do not."""
    preset = load_preset("meadow", overrides)
    start = time.perf_counter()
    world = build_world(preset)
    cold = {"world": _us(time.perf_counter() - start), "world_bytes": peak_rss_bytes()}
    warm = []
    for frame in range(1, frames + 2):
        made = assemble_frame(world, preset, frame, variant)
        shot_bytes = peak_rss_bytes()
        layers, row = _timed(made, frame)
        if frame == 1:
            bytes_ = {"shoot_bytes": shot_bytes, "render_bytes": peak_rss_bytes()}
            cold |= {"first_trace": row["trace"], **bytes_}
        else:
            warm.append({**row, **_metric(world, view_at(world, preset, frame))})
            warm[-1]["haze"] = row["trace"] - _clear(made, frame)
    return {"cold": cold, "warm": warm, "statistics": layers.statistics}


def _timed(made: FrameInput, frame: int) -> tuple[Layers, Row]:
    layers = render_frame(made, frame)
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        write_exr(Path(folder) / "frame.exr", layers, {})
        write = time.perf_counter() - start
    stages = {**made.seconds, **layers.seconds, "write": write}
    return layers, {name: _us(spent) for name, spent in stages.items()}


def _clear(made: FrameInput, frame: int) -> int:
    """Time the trace of the scene without haze [µs]."""
    layers = render_frame(replace(made, air=CLEAR), frame)
    return _us(layers.seconds["trace"])


def _metric(world: World, view: View) -> Row:
    """Time the metric alone on as many parts as were examined."""
    tests = sum(prune(each, view).examined_parts for each in world.representations)
    x, y, z, D = np.random.default_rng(0).random((4, tests))
    return {"metric": _us(_best(lambda: np.sqrt(x * x + y * y + z * z) < D)), "tests": tests}


def _best(task: Callable[[], object]) -> float:
    task()
    start = time.perf_counter()
    task()
    return time.perf_counter() - start


def _us(seconds: float) -> int:
    return round(1e6 * seconds)


if __name__ == "__main__":
    variant, frames, *overrides = sys.argv[1:]
    print(json.dumps(measure(overrides, variant, int(frames))))
