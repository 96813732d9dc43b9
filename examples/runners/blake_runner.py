"""A pack in lodbench itself, pruned by `blake`: the baseline of scores, through the same door.

    python blake_runner.py PACK -o OUT.exr --knob 1 --seed 0

The knob is the detail threshold τ [px]. It needs lodbench; PACK is a pack with its recipe, and not
the copy without references that other runners get: the world is made anew from its preset.
"""

import argparse
import json
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.packs.content import load_content
from lod.pruner import prune
from scenes.frame.frame_input import display
from scenes.render.exr.layer_file import write_channels
from scenes.render.render import build_frame, trace

SAMPLES = 16


def main():
    """Make the world, prune, build, trace, write; print the seconds of each stage."""
    parser = argparse.ArgumentParser()
    parser.add_argument("pack")
    parser.add_argument("-o", required=True)
    parser.add_argument("--knob", type=float, default=1)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    start = time.perf_counter()
    recipe = json.loads((Path(asked.pack) / "recipe.json").read_text())
    content = load_content(recipe["preset"], tuple(recipe["settings"]), tuple(recipe["size"]))
    made = time.perf_counter()
    view = replace(content.view, detail=asked.knob)
    shown = tuple(display(f, prune(f, view), view) for f in content.scene.world.fields)
    quality = replace(content.made.quality, spp=SAMPLES, seed=asked.seed)
    displayed = (content.made.displayed[0], *shown)
    pruned = replace(content.made, displayed=displayed, quality=quality)
    updated = time.perf_counter()
    stage = build_frame(pruned)
    built = time.perf_counter()
    layers = trace(stage, quality, 50_000)
    channels = {name: layers.rgb[..., k] for k, name in enumerate("RGB")} | {"Z": layers.Z}
    write_channels(asked.o, {k: np.asarray(v, np.float32) for k, v in channels.items()})
    ends = start, made, updated, built, time.perf_counter()
    seconds = dict(zip(("make", "update", "build", "trace"), np.diff(ends).tolist(), strict=True))
    print(json.dumps({"stages": seconds}))


if __name__ == "__main__":
    main()
