"""What do grass's parts cost at a density, by a metric? Run as a module, for its memory.

It reads one JSON object and prints another. What is foretold to need more memory than there is is
not tried, and said to be so, as is what was killed for it.
"""

import json
import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from bench.studies.grass.frames import PRESET

from bench.frame_counts import count
from lod.errors import InputError
from lod.pruner import prune
from scenes.frame.frame_input import display
from scenes.presets.load import load_preset, preset_from
from scenes.presets.schema import Preset
from scenes.processes.memory_limit import memory_limit, peak_rss_bytes
from scenes.render.memory import forecast, frame_bytes, preflight
from scenes.scene import Scene, view_at
from scenes.world.world import build_world

METRICS = "blake", "bounded", "solid_angle"
DENSITIES = 0.0125, 0.125, 1.25, 12.5, 50.0
"""Tufts a square metre; presets have 12.5, and no key takes more than 100."""

REPEATS = 3
"""Prunes and poses of which the median is taken."""

_COARSE = 30.0
"""The factor on detail of a prune whose only use is that everything is loaded."""

_ROOT = Path(__file__).resolve().parents[3]


def grass_alone(density: float, metric: str | None, *settings: str) -> Preset:
    """Load `meadow` where nothing grows but its grass, so dense and by this metric."""
    meadow = load_preset(PRESET).model_dump(mode="json")
    sward = meadow["species"]["sward"] | {"density": density}
    if metric:
        sward |= {"metric": metric}
    return preset_from(meadow | {"species": {"sward": sward}}, settings, PRESET)


def measure(density: float, metric: str, settings: tuple[str, ...], variant: str) -> dict[str, Any]:
    """Count what the first frame displays, then time its prune and its pose.

    parts, objects, peak_bytes   displayed, and the most memory by then
    prune_s, pose_s              seconds of the processor, all threads; None for a pose not tried
    frame_bytes                  what a frame is foretold to hold, tracing included
    refused                      why nothing was counted, in place of all others
    """
    preset = grass_alone(density, metric, *settings)
    world = build_world(preset)
    view = view_at(world, preset, 1)
    foretold = forecast(world, view)
    held = frame_bytes(foretold, preset, variant)
    try:
        preflight(Scene(preset), (1,))
    except InputError as error:
        return {"refused": str(error.rule), "frame_bytes": held}
    (field,) = world.fields
    prune(field, replace(view, detail=view.detail * _COARSE))
    counts = count(world, view, foretold.ground)
    peak, limit, pruned, posed = peak_rss_bytes(), memory_limit().bytes, [], []
    for _ in range(REPEATS):
        start = time.process_time()
        cut = prune(field, view)
        pruned.append(time.process_time() - start)
        if limit is None or held <= limit:
            start = time.process_time()
            display(field, cut, view)
            posed.append(time.process_time() - start)
    return {
        "parts": counts.parts.displayed,
        "objects": counts.objects.displayed,
        "peak_bytes": peak,
        "prune_s": float(np.median(pruned)),
        "pose_s": float(np.median(posed)) if posed else None,
        "frame_bytes": held,
    }


def measure_apart(words: dict[str, Any]) -> dict[str, Any]:
    """Measure in a fresh process what ``measure`` is asked by these words."""
    paths = os.pathsep.join([str(_ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-P", "-m", "bench.studies.grass.counts"],
        input=json.dumps(words),
        env={**os.environ, "PYTHONPATH": paths},
        stdout=subprocess.PIPE,
        text=True,
    )
    if done.returncode == -signal.SIGKILL:
        return {"refused": "killed, as processes are that take all memory"}
    done.check_returncode()
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


if __name__ == "__main__":
    asked = json.loads(sys.stdin.read())
    print(json.dumps(measure(**asked | {"settings": tuple(asked["settings"])})))
