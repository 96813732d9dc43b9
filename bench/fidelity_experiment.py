"""What does pruning do to the picture, and what does it save? (§1.2, §2.4)

Excess FLIP over pairs of independent seeds, relMSE free of noise, SSIM and mean luminance by
distance, against parts, memory and time, as τ sweeps ⅛ to 8 pixels by every metric in three views.
"""

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np

from bench.excess_flip import LEAST_PAIRS
from bench.experiments import Progress, silent
from bench.fidelity_claims import judge
from bench.fidelity_measure import BAND_EDGES_M, Reference, displayed_as, measured, reference_of
from bench.fidelity_scene import (
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
    view_of,
)
from bench.provenance import provenance
from bench.records import Point, Record
from scenes.render.frame import Layers, Visible
from scenes.render.memory import foretell
from scenes.render.render import staged, taken
from scenes.render.variants import choose
from scenes.shot import light_of, quality_of
from scenes.sight import air_of

NAME, VERSION = "fidelity", 1
_SPP, _QUICK_SPP = 324, 25


def run(quick: bool = False, progress: Progress = silent, seed: int = 0) -> Record:
    """Render every case with every seed and judge the claims; quick has fewer details and spp."""
    start, variant, points = time.perf_counter(), choose(), []
    spp = _QUICK_SPP if quick else _SPP
    seeds = [seed + k for k in range(2 * LEAST_PAIRS)]
    grid, shown = cases(quick), {}
    whole: dict[str, Reference] = {}
    for number, case in enumerate(grid):
        progress(
            number, len(grid), f"{case.view}, {case.metric}, {case.detail:g} px, {case.pruned}"
        )
        if case.view not in whole:
            unpruned = reference(case.view)
            pictures = _pictures(case.view, unpruned, variant, spp, seeds)
            whole[case.view] = reference_of(pictures[0::2], pictures[1::2])
            shown[case.view] = {**displayed_as(whole[case.view]), "parts": parts_in(unpruned)}
        points.append(_point(case, whole[case.view], variant, spp, seeds[0::2]))
    progress(len(grid), len(grid), "judged")
    return Record(
        experiment=NAME,
        version=VERSION,
        quick=quick,
        made=datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ"),
        provenance=provenance(_scene_hash(grid), seed, variant=variant),
        points=tuple(points),
        claims=judge(tuple(points)),
        notes={
            "samples_per_pixel": spp,
            "pairs_of_seeds": LEAST_PAIRS,
            "references": shown,
            "ceiling_of_parts": MOST_PARTS,
            "seconds": round(time.perf_counter() - start, 1),
        },
    )


def _pictures(
    view: str, visible: Sequence[Visible], variant: str, spp: int, seeds: list[int]
) -> list[Layers]:
    """One picture for each seed, of a scene that is built once."""
    preset = preset_of(view)
    quality = replace(quality_of(preset, variant), spp=spp)
    camera = view_of(Case(view, "blake", 1.0)).camera
    stage = staged(camera, visible, air_of(preset), light_of(preset), quality)
    return [taken(stage, replace(quality, seed=each)) for each in seeds]


def _point(case: Case, whole: Reference, variant: str, spp: int, seeds: list[int]) -> Point:
    start = time.perf_counter()
    visible = displayed(case)
    pruned = time.perf_counter() - start
    pictures = _pictures(case.view, visible, variant, spp, seeds)
    counts = pictures[0].statistics
    size = preset_of(case.view).render.size
    needed = foretell(counts["sticks"], counts["triangles"], size, spp, variant)
    samples = {
        **measured([each.rgb.astype(np.float64) for each in pictures], whole),
        "parts": [parts_in(visible)],
        "sticks": [counts["sticks"]],
        "triangles": [counts["triangles"]],
        "foretold_bytes": [needed],
        "prune_us": [round(1e6 * pruned)],
        "build_us": [round(1e6 * pictures[0].seconds["build"])],
        "trace_us": [round(1e6 * each.seconds["trace"]) for each in pictures],
    }
    case_ = {k: getattr(case, k) for k in ("view", "metric", "detail", "pruned")}
    return Point(case_, {}, samples)


def _scene_hash(grid: list[Case]) -> str:
    presets = [preset_of(view).model_dump(mode="json") for view in VIEWS]
    words = [presets, WORLD, [str(case) for case in grid], GROUND_DETAIL, BAND_EDGES_M]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()
