"""What the cost experiment claims, judged from its points alone (§4.2)."""

from collections.abc import Sequence

import numpy as np

from bench.images.compare import errors
from bench.images.equal_error import EQUAL_ERROR
from bench.records.claims import Claim
from bench.records.old_claims import claim
from bench.records.records import Point, grouped, where
from bench.statistics.estimates import LEAST_REPEATS, Estimate, two_sided_factor, two_sided_median
from bench.statistics.fits import one_sided_mean
from lod.arrays import Reals

SET_UP = "prune", "appearance", "describe", "build"
"""The stages of a frame before its trace."""

STILL = {"meadow"}
"""Kinds of world in which nothing moves: the whole scene is built once, and then only traced."""

TRACE_TOLERANCE = 0.25
"""How far a pruned trace may be from a whole one in time, as a share, to be called as long."""

_SOURCE = "§4.1, §4.2"


def judge_sizes(points: Sequence[Point]) -> list[Claim]:
    """Claim time, memory and error of every size of world."""
    made = []
    for (kind, objects), both in grouped(points, "kind", "objects").items():
        sides = {p.case["side"]: p for p in both}
        whole, pruned = sides["whole"], sides["pruned"]
        name, where = f"sizes/{kind}/{objects:g}", f"{objects:g} objects of {kind}"
        about = f"Pruned, the rays of a frame take as long to trace as whole: {where}."
        words = about, "trace, pruned ÷ whole", _SOURCE
        found = ratio(trace_us(pruned), trace_us(whole))
        made.append(claim(f"{name}/trace", words, 1.0, TRACE_TOLERANCE, found))
        later = "whole built once" if kind in STILL else "both made anew"
        about = f"Pruned, a later frame takes no longer than whole, {later}: {where}."
        words = about, "frame by the clock, pruned ÷ whole", _SOURCE
        found = ratio(frame_us(pruned), later_us(whole))
        made.append(claim(f"{name}/frame", words, 1.0, 0, found, "at most"))
        for quantity, each in (("set-up", set_up_us), ("memory", peak_bytes)):
            found = ratio(each(pruned), each(whole))
            about = f"Pruned, a frame needs no more {quantity} than whole: {where}."
            words = about, f"{quantity} of a first frame, pruned ÷ whole", _SOURCE
            which = f"{name}/{quantity.replace('-', '_')}"
            made.append(claim(which, words, 1.0, 0, found, "at most"))
        about = f"As good as whole by blake at one pixel: {where}."
        words = about, "mean FLIP without noise, over fields (one-sided)", _SOURCE
        found = one_sided_mean(errors(pruned))
        made.append(claim(f"{name}/error", words, EQUAL_ERROR, 0, found, "at most"))
    return made


def ratio(pruned: Reals, whole: Reals) -> Estimate:
    """Estimate pruned ÷ whole, one by one."""
    return two_sided_factor(np.maximum(pruned, 1) / np.maximum(whole, 1))


def trace_us(point: Point) -> Reals:
    """Return the time of every frame's trace, (frames,) [µs]."""
    return point.values("us", stage="trace")


def set_up_us(point: Point) -> Reals:
    """Return the time of every frame before its trace, (frames,) [µs]."""
    return np.asarray(np.sum([point.values("us", stage=stage) for stage in SET_UP], axis=0))


def frame_us(point: Point) -> Reals:
    """Return the time of every frame, all its stages, (frames,) [µs]."""
    return np.asarray(set_up_us(point) + trace_us(point))


def later_us(point: Point) -> Reals:
    """Return the time of a later frame, (frames,) [µs]: what stands still is not set up again.

    That is so of a whole scene. What a walking eye has pruned changes with every step.
    """
    still = point.case["kind"] in STILL and point.case["side"] == "whole"
    return trace_us(point) if still else frame_us(point)


def peak_bytes(point: Point) -> Reals:
    """Return the most memory of a process that made one frame, (fields,) [bytes]."""
    return point.values("peak_bytes")


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
    whole, world = own_frame_us(frames), processes.values("world")
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


def own_frame_us(frames: Point) -> Reals:
    """Return the time of every warm frame, all its stages, (frames,) [µs]."""
    return np.asarray(np.sum([stage_us(frames, stage) for stage in STAGES], axis=0))
