"""What is the most memory that a process holds which makes one frame by one arm? Run as a module.

It reads a window, a seed, an arm and a setting as JSON, and prints a number of bytes.
"""

import json
import sys

from bench.arms.registry import arms
from bench.experiments.rivals.windows import Window
from bench.fields.windows import Picture
from scenes.render.pipeline.peak_memory import peak_rss_bytes
from scenes.render.pipeline.render import render_frame
from scenes.world.world import build_world


def peak_bytes(window: Window, seed: int, arm: str, setting: float) -> int:
    """Make and trace the first frame, and return the most that this process has held [bytes]."""
    preset = window.preset(seed)
    updater = arms()[arm].prepare(build_world(preset), preset, setting)
    render_frame(updater(1, window.variant), 1)
    return peak_rss_bytes()


if __name__ == "__main__":
    asked = json.load(sys.stdin)
    asked["window"]["picture"] = Picture(**asked["window"]["picture"])
    print(peak_bytes(Window(**asked.pop("window")), **asked))
