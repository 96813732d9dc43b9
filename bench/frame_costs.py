"""What frames cost, stage by stage: functions that are called in fresh processes.

They import no more than rendering needs, for the memory of the process is among what is measured.
Every process's first frame compiles, or loads what was compiled.
"""

import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from bench.windows import Picture, window_preset
from lod.air import CLEAR
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.processes.memory import peak_rss_bytes
from scenes.render.exr.layers import write_exr
from scenes.render.render import build_frame, render_frame, trace
from scenes.scene import Scene

KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "meadow": ("meadow", ("species.sward.density=0",)),
    "crowd": ("crowd", ("species.tree.density=0",)),
}
"""For each kind of world its preset and what is changed in it: nothing moves in ``meadow``."""

FIRST_SAMPLES = {"whole": 0, "pruned": 1000}
"""The frame number of the samples of each side's first picture: no two have the same."""


@dataclass(frozen=True)
class Size:
    """One field of one size of world; ``samples`` are those of the pictures that are compared."""

    kind: str
    objects: float
    field: int
    unseen: bool
    size: str
    spp: int
    frames: int
    samples: tuple[int, ...]
    variant: str

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.kind}, {self.objects:g} objects, field {self.field + 1}"


def preset_costs(overrides: list[str], variant: str, frames: int) -> dict[str, Any]:
    """Build the world of ``meadow`` and time its frames, in microseconds and bytes.

    cold   of the process, with the first frame, which compiles
    warm   of each further frame
    """
    preset = load_preset("meadow", overrides)
    start = time.perf_counter()
    scene = Scene(preset)
    world = scene.world
    cold = {"world": _us(time.perf_counter() - start), "world_bytes": peak_rss_bytes()}
    warm = []
    for frame in range(1, frames + 2):
        made = scene.input(frame, variant)
        shot_bytes = peak_rss_bytes()
        layers = render_frame(made, frame)
        with tempfile.TemporaryDirectory() as folder:
            start = time.perf_counter()
            write_exr(Path(folder) / "frame.exr", layers, {})
            write = time.perf_counter() - start
        stages = {**made.seconds, **layers.seconds, "write": write}
        row = {name: _us(spent) for name, spent in stages.items()}
        if frame == 1:
            bytes_ = {"shoot_bytes": shot_bytes, "render_bytes": peak_rss_bytes()}
            cold |= {"first_trace": row["trace"], **bytes_}
            continue
        view = scene.view(frame)
        row["tests"] = sum(prune(each, view).examined_parts for each in world.representations)
        row["metric"] = _metric_us(row["tests"])
        clear = render_frame(replace(made, air=CLEAR), frame)
        warm.append(row | {"haze": row["trace"] - _us(clear.seconds["trace"])})
    return {"cold": cold, "warm": warm, "statistics": layers.statistics}


def _metric_us(tests: int) -> int:
    """Time the metric alone on so many parts, the second time [µs]."""
    x, y, z, D = np.random.default_rng(0).random((4, tests))
    for _ in range(2):
        start = time.perf_counter()
        np.sqrt(x * x + y * y + z * z) < D  # noqa: B015
        spent = time.perf_counter() - start
    return _us(spent)


def window_costs(case: Size, side: str, seed: int) -> dict[str, Any]:
    """Build one world, whole or pruned at one pixel, and time its frames.

    rows         microseconds of every stage of each frame after the first
    peak_bytes   the most memory that one frame takes
    statistics   counts of the last frame
    pictures     of the first frame, one for each of the case's counts of samples
    """
    name, settings = KINDS[case.kind]
    picture = Picture(case.size, case.spp)
    detail = None if side == "whole" else 1.0
    preset = window_preset(name, (*settings, f"seed={seed}"), case.objects, picture, detail)
    scene, rows, peak = Scene(preset), [], 0
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


def _us(seconds: float) -> int:
    return round(1e6 * seconds)
