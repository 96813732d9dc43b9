"""What do a frame's stages take in one world, pruned or whole, and what is seen? Run as a module.

It reads one JSON object, and prints another: microseconds of every stage of each frame after the
first, which compiles, the most memory that one frame takes, and counts. Pictures of the first frame
with several counts of samples go to a file.
"""

import json
import sys
from dataclasses import replace
from typing import Any

import numpy as np

from bench.experiments.fidelity.shipped.pictures import REFERENCE, TESTED
from bench.fields.windows import Picture, window_preset
from scenes.frame.assemble import assemble_frame
from scenes.render.pipeline.peak_memory import peak_rss_bytes
from scenes.render.pipeline.render import render_frame
from scenes.render.pipeline.stages import build_frame, trace
from scenes.world.world import build_world

KINDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "meadow": ("meadow", ("species.sward.density=0",)),
    "crowd": ("crowd", ("species.tree.density=0",)),
}
"""For each kind of world its preset and what is changed in it: nothing moves in ``meadow``."""


def measure(words: dict[str, Any]) -> dict[str, Any]:
    """Build one world, time its frames, and keep pictures of the first."""
    name, settings = KINDS[words["kind"]]
    picture = Picture(words["size"], words["spp"])
    detail = None if words["side"] == "whole" else 1.0
    settings = (*settings, f"seed={words['seed']}")
    preset = window_preset(name, settings, words["objects"], picture, detail)
    world, rows, peak = build_world(preset), [], 0
    for frame in range(1, words["frames"] + 2):
        made = assemble_frame(world, preset, frame, words["variant"])
        layers = render_frame(made, frame)
        if frame == 1:
            peak = peak_rss_bytes()
        else:
            spent = {**made.seconds, **layers.seconds}
            rows.append({stage: round(1e6 * seconds) for stage, seconds in spent.items()})
    made = assemble_frame(world, preset, 1, words["variant"])
    stage, first = build_frame(made), REFERENCE if detail is None else TESTED
    pictures = [
        trace(stage, replace(made.quality, spp=spp), first + k).rgb
        for k, spp in enumerate(words["samples"])
    ]
    np.savez(words["pictures"], *pictures)
    return {"rows": rows, "peak_bytes": peak, "statistics": layers.statistics}


if __name__ == "__main__":
    print(json.dumps(measure(json.loads(sys.stdin.read()))))
