"""What the cost experiment claims, judged from its points alone (§4.2)."""

from collections.abc import Sequence

import numpy as np

from bench.experiments.cost.size_claims import judge_sizes
from bench.records.claims import Claim, claim
from bench.records.points import Point, where
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
    frames, processes = own_frames(points)
    whole, world = frame_us(frames), processes.values("world")
    share, setup = "share of a frame's time", "set-up ÷ time of the frames"
    metric = "Distance, root and comparison of every part examined cost next to nothing."
    prune = "Finding and pruning, all of it, is small beside rendering."
    made = [
        _at_most("metric_share", metric, share, 0.01, stage_us(frames, "metric") / whole),
        _at_most("prune_share", prune, share, 0.1, stage_us(frames, "prune") / whole),
    ]
    if len(world) >= LEAST_REPEATS:
        about = f"Setting up the hierarchies vanishes over {SEQUENCE} frames."
        spread = world / (SEQUENCE * np.median(whole))
        made.append(_at_most("setup_share", about, setup, 0.01, spread))
    return (*made, *judge_sizes(where(points, what="size")))


def own_frames(points: Sequence[Point]) -> tuple[Point, Point]:
    """Return the points of the preset's frames, and of the processes that made them."""
    return where(points, what="frames")[0], where(points, what="processes")[0]


def _at_most(name: str, about: str, quantity: str, most: float, shares: Reals) -> Claim:
    words = about, quantity, "§4.2"
    return claim(name, words, most, 0.0, two_sided_median(shares), "at most")


def stage_us(frames: Point, stage: str) -> Reals:
    """Return the time of a stage of every warm frame, (frames,) [µs]."""
    return frames.values("us", stage=stage)


def frame_us(frames: Point) -> Reals:
    """Return the time of every warm frame, all its stages, (frames,) [µs]."""
    return np.asarray(np.sum([stage_us(frames, stage) for stage in STAGES], axis=0))
