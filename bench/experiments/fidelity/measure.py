"""What does pruning do to the picture, and what does it save? (§1.2, §2.4)

Excess FLIP over pairs of independent seeds, relMSE without noise, SSIM and mean luminance by
distance are measured against parts, memory and time, as τ goes from ⅛ to 8 pixels by every metric
in three views.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from bench.experiments.fidelity.image_errors import (
    BAND_EDGES_M,
    Reference,
    picture_errors,
    reference_of,
)
from bench.experiments.fidelity.pictures import pictures_of
from bench.experiments.fidelity.scene import (
    GROUND_DETAIL,
    MOST_PARTS,
    VIEWS,
    WORLD,
    Case,
    displayed,
    grid_cases,
    parts_in,
    preset_of,
    reference,
    tried_metrics,
    view_of,
)
from bench.experiments.fidelity.timing import SPP, TIMED, Timing, measure_times
from bench.records.embedded_pictures import NOTE
from bench.records.points import Point, columns
from bench.runner.experiment import Effort
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


@dataclass(frozen=True)
class Pictures:
    """A case that is rendered, the variant that renders it, and the samples of a pixel."""

    case: Case
    variant: str
    spp: int

    @property
    def label(self) -> str:
        """The name of the case, in short."""
        return f"{self.case.view}, {self.case.metric}, {self.case.detail:g} px, {self.case.pruned}"


def cases(effort: Effort, metric: str | None = None) -> list[Pictures | Timing]:
    """Return every case of the grid, with ``metric`` in it; then the frames that are timed."""
    variant, spp = choose(), effort["samples_per_pixel"]
    grid = grid_cases(effort["details"], effort["ground_details"], metric)
    tried = tried_metrics(metric)
    return [
        *(Pictures(each, variant, spp[each.view]) for each in grid),
        *(Timing(view, tried, tuple(effort["timed_details"]), variant) for view in VIEWS),
    ]


def notes(effort: Effort, seed: int, points: tuple[Point, ...]) -> dict[str, Any]:
    """Return how pictures were rendered, and pictures to look at."""
    return {
        "samples_per_pixel": effort["samples_per_pixel"],
        "samples_per_pixel_timed": SPP,
        "pairs_of_seeds": LEAST_PAIRS,
        "pixels_per_degree": PIXELS_PER_DEGREE,
        "ceiling_of_parts": MOST_PARTS,
        NOTE: pictures_of(choose(), effort["picture_spp"], seed),
    }


@lru_cache(maxsize=len(VIEWS))
def _whole(view: str, variant: str, spp: int, seeds: tuple[int, ...]) -> Reference:
    """Render the unpruned view; every second of its seeds is also one of pruned pictures."""
    pictures = _pictures(view, reference(view), variant, spp, seeds)
    return reference_of(pictures[0::2], pictures[1::2])


def _pictures(
    view: str,
    visible: Sequence[DisplayedRepresentation],
    variant: str,
    spp: int,
    seeds: Sequence[int],
) -> list[Layers]:
    """Render one picture for each seed, of a scene that is built once."""
    preset = preset_of(view)
    quality = replace(frame_quality(preset, variant), spp=spp)
    camera = view_of(Case(view, "blake", 1.0)).camera
    stage = build_frame(
        FrameInput(camera, tuple(visible), preset_air(preset), sun_and_sky(preset), quality)
    )
    return [trace(stage, replace(quality, seed=each)) for each in seeds]


def measure(job: Pictures | Timing, seed: int) -> Point | list[Point]:
    """Measure the errors of the pictures of a case, or the times of a view's frames."""
    return measure_times(job, seed) if isinstance(job, Timing) else measure_errors(job, seed)


def measure_errors(job: Pictures, seed: int) -> Point:
    """Compare pictures of a case, one for every second seed, with those of the unpruned view."""
    case, variant, spp = job.case, job.variant, job.spp
    seeds = tuple(seed + k for k in range(2 * LEAST_PAIRS))
    whole = _whole(case.view, variant, spp, seeds)
    visible = displayed(case)
    pictures = _pictures(case.view, visible, variant, spp, seeds[0::2])
    counts = pictures[0].statistics
    size = preset_of(case.view).render.size
    needed = predict_bytes(counts["sticks"], counts["triangles"], size, Quality(variant, spp))
    counted = {
        "parts": [parts_in(visible)],
        "parts_of_reference": [parts_in(reference(case.view))],
        "exposure_ppm": [round(1e6 * whole.exposure)],
        "sticks": [counts["sticks"]],
        "triangles": [counts["triangles"]],
        "foretold_bytes": [needed],
    }
    wrong = picture_errors([each.rgb.astype(np.float64) for each in pictures], whole)
    named = {k: getattr(case, k) for k in ("view", "metric", "detail", "pruned")}
    return Point(named, samples=(*wrong, *columns(counted)))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of every view and every case that is not timed."""
    grid = [Case(**p.case) for p in points if p.case["pruned"] != TIMED]
    presets = [preset_of(view).model_dump(mode="json") for view in VIEWS]
    words = [presets, WORLD, [str(case) for case in grid], GROUND_DETAIL, BAND_EDGES_M]
    return hashlib.sha256(json.dumps(words, sort_keys=True).encode()).hexdigest()
