"""Frames of `meadow` with grass and without, in turns, each in a process of its own."""

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import Any

import numpy as np

from bench.cli.output import counted
from scenes.presets.load import load_preset
from scenes.render.exr.header import frame_settings
from scenes.render.worker import Worker

PRESET = "meadow"
WITHOUT, WITH = "without grass", "with grass"
SIDES = {WITHOUT: ("species.sward.density=0",), WITH: ()}
"""What is changed in the preset on each side."""

COUNTED = "cpu_s", "wall_s", "frame_s", "peak_gb"

WARM = "64x36", 1
"""Size and samples of the frames whose only use is that what is kept is made."""

Frame = dict[str, Any]
"""Seconds of the processor and by the clock, of a process from its start to its end; ``frame_s``:
those of the frame's stages, by the clock; the most memory that it held; sticks and triangles."""


def render(side: str, size: str, spp: int, variant: str) -> Frame:
    """Render the first frame of a side in a fresh process, and time it."""
    preset = load_preset(PRESET, (*SIDES[side], f"render.size={size}", f"render.spp={spp}"))
    settings = frame_settings(preset, variant)
    before, start = getrusage(RUSAGE_CHILDREN), time.perf_counter()
    with tempfile.TemporaryDirectory() as folder, Worker() as worker:
        record = worker(settings, 1, Path(folder) / "1.exr")
    wall, after = time.perf_counter() - start, getrusage(RUSAGE_CHILDREN)
    return {
        "cpu_s": after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime,
        "wall_s": wall,
        "frame_s": sum(record["seconds"].values()),
        "peak_gb": record["peak_rss_bytes"] / 1e9,
        "sticks": record["statistics"]["sticks"],
        "triangles": record["statistics"]["triangles"],
    }


def turns_of_frames(size: str, spp: int, turns: int, variant: str) -> dict[str, list[Frame]]:
    """Render both sides in every turn, each of them first in every other turn."""
    found: dict[str, list[Frame]] = {side: [] for side in SIDES}
    order = [(side, k) for k in range(turns) for side in (list(SIDES), list(SIDES)[::-1])[k % 2]]
    for side, k in counted([(side, -1) for side in SIDES] + order, "frame", lambda each: each[0]):
        if k < 0:
            render(side, *WARM, variant)
        else:
            found[side].append(render(side, size, spp, variant))
    return found


def frame_figures(found: dict[str, list[Frame]]) -> dict[str, Any]:
    """Give medians with the least and the greatest, and those of the ratios of each turn."""
    figures: dict[str, Any] = {
        side: {name: _spread([each[name] for each in rows]) for name in COUNTED}
        | {name: rows[0][name] for name in ("sticks", "triangles")}
        for side, rows in found.items()
    }
    pairs = list(zip(found[WITH], found[WITHOUT], strict=True))
    ratios = {name: _spread([a[name] / b[name] for a, b in pairs]) for name in COUNTED}
    return figures | {"ratio": ratios}


def _spread(values: Sequence[float]) -> dict[str, float]:
    return {
        "median": float(np.median(values)),
        "least": float(min(values)),
        "greatest": float(max(values)),
    }
