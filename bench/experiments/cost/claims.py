"""What the cost experiment claims, judged from its points alone (§4.2)."""

import numpy as np

from bench.records.claims import Claim, claim
from bench.records.points import Point
from bench.statistics.estimates import LEAST_REPEATS, two_sided_median
from lod.arrays import Reals

STAGES = {
    "prune": "examine and prune",
    "appearance": "pose and look",
    "describe": "describe",
    "build": "build, with its BVH",
    "trace": "render, haze included",
    "write": "write and read back",
}
"""The stages that make up a frame, in their order, with their names in words."""

SEQUENCE = 240
"""The number of frames over which setting up is spread: ten seconds of film."""


def judge(points: tuple[Point, ...]) -> tuple[Claim, ...]:
    """Return every claim that these points decide."""
    frames, processes = points
    whole = frame_us(frames)
    metric = stage_us(frames, "metric") / whole
    prune = stage_us(frames, "prune") / whole
    made = [
        claim(
            "metric_share",
            (
                "Distance, root and comparison of every part examined cost next to nothing.",
                "share of a frame's time",
                "§4.2",
            ),
            *(0.01, 0.0, two_sided_median(metric), "at most"),
        ),
        claim(
            "prune_share",
            (
                "Finding and pruning, all of it, is small beside rendering.",
                "share of a frame's time",
                "§4.2",
            ),
            *(0.1, 0.0, two_sided_median(prune), "at most"),
        ),
    ]
    world = processes.values("world")
    if len(world) >= LEAST_REPEATS:
        made.append(
            claim(
                "setup_share",
                (
                    f"Setting up the hierarchies vanishes over {SEQUENCE} frames.",
                    "set-up ÷ time of the frames",
                    "§4.2",
                ),
                *(0.01, 0.0, two_sided_median(world / (SEQUENCE * np.median(whole))), "at most"),
            )
        )
    return tuple(made)


def stage_us(frames: Point, stage: str) -> Reals:
    """Return the time of a stage of every warm frame, (frames,) [µs]."""
    return frames.values("us", stage=stage)


def frame_us(frames: Point) -> Reals:
    """Return the time of every warm frame, all its stages, (frames,) [µs]."""
    return np.asarray(np.sum([stage_us(frames, stage) for stage in STAGES], axis=0))
