"""At which detail does a pruned frame differ from the whole one by an excess FLIP of 0.01?

The error is that of ``lodbench run fidelity``: pairs of seeds, the noise floor subtracted, straight
lines between details. Here it is of whole frames as they are rendered, far cover, fading and all.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from bench.experiments.fidelity.equal_error import EQUAL_ERROR, column, equal_error, excesses
from bench.experiments.fidelity.image_errors import picture_errors, reference_of
from bench.fields.windows import Picture
from bench.records.points import Column, Point
from bench.statistics.estimates import Estimate
from bench.statistics.excess_flip import ExcessFlip, one_sided_excess
from bench.studies.full.worlds import Kind, world_preset
from lod.errors import InputError
from scenes.frame.assemble import assemble_frame
from scenes.frame.layers import Layers
from scenes.preset.tables import Preset
from scenes.render.pipeline.stages import build_frame, trace
from scenes.render.sequence.detail_budget import parts_displayed
from scenes.world.view import view_at
from scenes.world.world import World, build_world

FINEST_PX, COARSEST_PX = 1 / 16, 32.0
_METRIC = "blake"


@dataclass(frozen=True)
class DetailSearch:
    """What is rendered to find the detail of equal error in one world.

    kind, objects   the world
    picture         size, and samples of each pixel
    pairs           pairs of sampler seeds
    variant         of the renderer
    """

    kind: Kind
    objects: float
    picture: Picture
    pairs: int
    variant: str

    def measure(self) -> Callable[[float], Point]:
        """Render the whole pictures, and give a function that measures a detail against them."""
        world = build_world(self._preset(1.0))
        seeds = range(2 * self.pairs)
        whole = render_pictures(world, self._preset(None), self.variant, seeds)
        reference = reference_of(whole[0::2], whole[1::2])

        def at(detail: float) -> Point:
            preset = self._preset(detail)
            tested = render_pictures(world, preset, self.variant, seeds[0::2])
            errors = picture_errors([each.rgb.astype(np.float64) for each in tested], reference)
            parts = parts_displayed(world, view_at(world, preset, 1))
            case = {"metric": _METRIC, "detail": detail}
            return Point(case, samples=(*errors, Column("parts", [parts])))

        return at

    def _preset(self, detail: float | None) -> Preset:
        return world_preset(self.kind, self.objects, self.picture, detail)


def render_pictures(
    world: World, preset: Preset, variant: str, seeds: Sequence[int]
) -> list[Layers]:
    """Render the first frame of a world, once with each seed of the sampler."""
    made = assemble_frame(world, preset, 1, variant)
    stage = build_frame(made)
    return [trace(stage, replace(made.quality, seed=each)) for each in seeds]


def search_detail(at: Callable[[float], Point], start: float, halvings: int) -> list[Point]:
    """Measure details around the one of equal error.

    One of them is below the error in every pair of seeds and one above it; the gap between is then
    halved ``halvings`` times. Raises InputError where no detail has that error.
    """
    points = [at(start)]
    while (wider := _next_detail(points)) is not None:
        if not FINEST_PX <= wider <= COARSEST_PX:
            rule = f"an excess FLIP of {EQUAL_ERROR} from {FINEST_PX} to {COARSEST_PX:g} px"
            raise InputError("detail", wider, rule, "more samples, or give --detail")
        points.append(at(wider))
    for _ in range(halvings):
        value = detail_at_equal_error(points).value
        details = sorted(point.case["detail"] for point in points)
        above = next(number for number, each in enumerate(details) if each > value)
        points.append(at(math.sqrt(details[above - 1] * details[above])))
    return points


def _next_detail(points: list[Point]) -> float | None:
    """Give the detail to try next, until the error lies between two that were tried; then None."""
    ordered = sorted(points, key=lambda point: point.case["detail"])
    if excesses(ordered[0]).max() > EQUAL_ERROR:
        return float(ordered[0].case["detail"] / 2)
    if excesses(ordered[-1]).min() <= EQUAL_ERROR:
        return float(ordered[-1].case["detail"] * 2)
    return None


def detail_at_equal_error(points: list[Point]) -> Estimate:
    """Interpolate the detail τ [px] of equal error between the details that were measured."""
    return equal_error(points, excesses)[_METRIC].detail


def excess_flip(point: Point) -> ExcessFlip:
    """Give the excess FLIP that a detail leaves, with its interval and noise floor."""
    return one_sided_excess(column(point, "flip"), column(point, "flip_floor"))
