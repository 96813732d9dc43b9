"""How long does a frame of the fidelity experiment take as τ grows, against the unpruned one?

Prune, build and trace of every metric and detail take turns, round after round, in one process that
has made each of them once before. Differences between them are therefore not due to when they were
timed.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.experiments.fidelity.scene import Case, displayed, parts_in, preset_of, view_of
from bench.records.points import Column, Point, columns, where
from bench.statistics.estimates import LEAST_REPEATS, Estimate, two_sided_median
from lod.arrays import Reals
from scenes.frame.assemble import frame_quality
from scenes.frame.frame_input import FrameInput
from scenes.render.pipeline.memory_model import predict_bytes
from scenes.render.pipeline.stages import build_frame, trace
from scenes.world.light import sun_and_sky
from scenes.world.view import preset_air

TIMED = "species, timed"
"""The value of ``pruned`` in points of timed frames: species are pruned on whole ground."""

UNPRUNED = "full"
SPP = 16
STAGES = ("prune", "build", "trace")


@dataclass(frozen=True)
class Timing:
    """A view whose frames are timed, pruned by every metric at every detail [px]."""

    view: str
    metrics: tuple[str, ...]
    details: tuple[float, ...]
    variant: str


def measure_times(job: Timing, seed: int) -> list[Point]:
    """Time every metric and detail, and the unpruned frame: µs of each stage in each round."""
    cases = [Case(job.view, metric, detail) for metric in job.metrics for detail in job.details]
    cases.append(Case(job.view, UNPRUNED, 1.0))
    rounds = [[_frame(case, job.variant, seed) for case in cases] for _ in range(LEAST_REPEATS + 1)]
    return [_point(case, column) for case, column in zip(cases, _columns(rounds[1:]), strict=True)]


def seconds(point: Point) -> Reals:
    """Return a frame's time in every round, all its stages [s]."""
    return np.asarray(np.sum([point.values("us", stage=stage) for stage in STAGES], axis=0) / 1e6)


def megabytes(point: Point) -> float:
    """Return the memory [MB] that the model of memory predicts for the frame's process."""
    return float(point.column("foretold_bytes")[0]) / 1e6


def timed(points: Sequence[Point], metric: str = "blake") -> list[Point]:
    """Return the timed points of a metric, from the finest detail to the coarsest."""
    mine = where(points, pruned=TIMED, metric=metric)
    return sorted(mine, key=lambda p: p.case["detail"])


def over_unpruned(points: Sequence[Point], point: Point) -> Estimate | None:
    """Estimate the median of time ÷ the unpruned frame's in each round; None without one."""
    whole = timed(points, UNPRUNED)
    return two_sided_median(seconds(point) / seconds(whole[0])) if whole else None


def _frame(case: Case, variant: str, seed: int) -> dict[str, int]:
    preset = preset_of(case.view)
    quality = replace(frame_quality(preset, variant), spp=SPP, seed=seed)
    start = time.perf_counter()
    visible = displayed(case)
    pruned = time.perf_counter()
    stage = build_frame(
        FrameInput(
            view_of(case).camera, tuple(visible), preset_air(preset), sun_and_sky(preset), quality
        )
    )
    built = time.perf_counter()
    layers = trace(stage, quality)
    ends = start, pruned, built, time.perf_counter()
    took = {f"{k}_us": round(1e6 * t) for k, t in zip(STAGES, np.diff(ends), strict=True)}
    drawn = layers.statistics["sticks"], layers.statistics["triangles"]
    needed = predict_bytes(*drawn, preset.render.size, quality)
    return took | {"parts": parts_in(visible), "foretold_bytes": needed}


def _columns(rounds: list[list[dict[str, int]]]) -> list[list[dict[str, int]]]:
    return [list(column) for column in zip(*rounds, strict=True)]


def _point(case: Case, rows: list[dict[str, int]]) -> Point:
    times = (Column("us", [row[f"{k}_us"] for row in rows], {"stage": k}) for k in STAGES)
    counted = columns({k: [rows[0][k]] for k in ("parts", "foretold_bytes")})
    named = {"view": case.view, "metric": case.metric, "detail": case.detail, "pruned": TIMED}
    return Point(named, samples=(*times, *counted))
