"""What does pruning do to the picture, and what does it save? (§1.2, §2.4)

Excess FLIP over pairs of independent seeds, relMSE free of noise, SSIM and mean luminance by
distance, against parts, memory and time, as τ sweeps ⅛ to 8 pixels by every metric in three views.
"""

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from bench.experiments.fidelity import timing as fidelity_times
from bench.experiments.fidelity.claims import judge
from bench.experiments.fidelity.image_errors import BAND_EDGES_M, Reference, measured, reference_of
from bench.experiments.fidelity.pictures import pictures_of
from bench.experiments.fidelity.scene import (
    GROUND_DETAIL,
    MOST_PARTS,
    VIEWS,
    WORLD,
    Case,
    cases,
    displayed,
    parts_in,
    preset_of,
    reference,
    tried,
    view_of,
)
from bench.records.embedded_pictures import NOTE
from bench.records.provenance import provenance
from bench.records.records import Point, Record
from bench.runner import run_cases as conduct
from bench.runner.dask_cases import CaseExecutor, serial_executor
from bench.runner.experiment import Progress, silent
from bench.statistics.excess_flip import LEAST_PAIRS, PIXELS_PER_DEGREE
from scenes.frame.assemble import frame_quality
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import Quality
from scenes.render.mitsuba.variants import choose
from scenes.render.pipeline.memory_model import predict_bytes
from scenes.render.pipeline.stages import build_frame, trace
from scenes.world.light import sun_and_sky
from scenes.world.view import preset_air

NAME, VERSION = "fidelity", 3
_SPP = {"eye level": 225, "aerial": 441, "hazy": 64}
"""Samples a pixel with which the noise floor of each view is below that of an excess to quote."""

_QUICK_SPP = 25


def run(
    quick: bool = False,
    progress: Progress = silent,
    seed: int = 0,
    each: CaseExecutor = serial_executor,
    metric: str | None = None,
) -> Record:
    """Render every case with every seed, time some, and judge the claims; ``metric`` is tried, too.

    Quick has fewer details and samples a pixel.
    """
    start, variant, grid = time.perf_counter(), choose(), cases(quick, metric)
    spp = dict.fromkeys(VIEWS, _QUICK_SPP) if quick else _SPP
    seeds = tuple(seed + k for k in range(2 * LEAST_PAIRS))
    jobs = [
        (f"{c.view}, {c.metric}, {c.detail:g} px, {c.pruned}", (c, variant, spp[c.view], seeds))
        for c in grid
    ]
    details = fidelity_times.QUICK_DETAILS if quick else fidelity_times.DETAILS
    timed = [(f"{v}, timed", (v, tried(metric), details, variant, seed)) for v in VIEWS]
    timing = fidelity_times.measure_times, timed
    points = conduct.run_cases(progress, each, (measure, jobs), timing)
    return conduct.make_record(
        NAME,
        VERSION,
        quick=quick,
        provenance=provenance(_scene_hash(grid), seed, variant=variant),
        points=points,
        claims=judge(points),
        notes={
            "samples_per_pixel": spp,
            "samples_per_pixel_timed": fidelity_times.SPP,
            "pairs_of_seeds": LEAST_PAIRS,
            "pixels_per_degree": PIXELS_PER_DEGREE,
            "ceiling_of_parts": MOST_PARTS,
            NOTE: pictures_of(variant, quick, seed),
        },
        start=start,
    )


@lru_cache(maxsize=len(VIEWS))
def _whole(view: str, variant: str, spp: int, seeds: tuple[int, ...]) -> Reference:
    """The unpruned view; every second seed is one that pruned pictures have as well."""
    pictures = _pictures(view, reference(view), variant, spp, seeds)
    return reference_of(pictures[0::2], pictures[1::2])


def _pictures(
    view: str,
    visible: Sequence[DisplayedRepresentation],
    variant: str,
    spp: int,
    seeds: Sequence[int],
) -> list[Layers]:
    """One picture for each seed, of a scene that is built once."""
    preset = preset_of(view)
    quality = replace(frame_quality(preset, variant), spp=spp)
    camera = view_of(Case(view, "blake", 1.0)).camera
    stage = build_frame(
        FrameInput(camera, tuple(visible), preset_air(preset), sun_and_sky(preset), quality)
    )
    return [trace(stage, replace(quality, seed=each)) for each in seeds]


def measure(case: Case, variant: str, spp: int, seeds: tuple[int, ...]) -> Point:
    """Pictures of a case with every second seed, against those of the unpruned view."""
    whole = _whole(case.view, variant, spp, seeds)
    visible = displayed(case)
    pictures = _pictures(case.view, visible, variant, spp, seeds[0::2])
    counts = pictures[0].statistics
    size = preset_of(case.view).render.size
    needed = predict_bytes(counts["sticks"], counts["triangles"], size, Quality(variant, spp))
    samples = {
        **measured([each.rgb.astype(np.float64) for each in pictures], whole),
        "parts": [parts_in(visible)],
        "parts_of_reference": [parts_in(reference(case.view))],
        "exposure_ppm": [round(1e6 * whole.exposure)],
        "sticks": [counts["sticks"]],
        "triangles": [counts["triangles"]],
        "foretold_bytes": [needed],
    }
    case_ = {k: getattr(case, k) for k in ("view", "metric", "detail", "pruned")}
    return Point(case_, {}, samples)


def _scene_hash(grid: list[Case]) -> str:
    presets = [preset_of(view).model_dump(mode="json") for view in VIEWS]
    words = [presets, WORLD, [str(case) for case in grid], GROUND_DETAIL, BAND_EDGES_M]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()
