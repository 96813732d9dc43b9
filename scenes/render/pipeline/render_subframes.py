"""Motion blur: a frame rendered as the mean of sub-frames spread evenly over the open shutter.

scenes/frame/subframes.py makes the inputs of the sub-frames; here they are rendered and averaged.
Taken in the middles of N equal times, they spread what moves by L over N places: the variance of
its profile grows by L²/12·(1 − 1/N²), that of a box where N → ∞. Sub-frame i of frame f is rendered
whole, haze included, with its share of the samples and the seed ``sampler_seed(seed, f, i)``.
Colour, albedo and coverage are means over all samples; Z, N, ids and motion are those of sub-frame
N // 2.
Where only the camera moves and haze is analytic, the scene is built once; otherwise once for each.
"""

from dataclasses import replace

import numpy as np

from lod.errors import InputError
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Coverage, Layers, add_coverage
from scenes.frame.quality import SampleWatch, sampler_seed
from scenes.render.pipeline.stages import (
    BuiltFrame,
    build_frame,
    ignore_samples,
    move_camera,
    trace,
)

_ADDED = ("clamped", "replaced")
"""Statistics of samples; the others are of a scene."""


def render_subframes(
    frame_input: FrameInput, frame: int = 0, watch: SampleWatch = ignore_samples
) -> Layers:
    """Render the sub-frames of ``frame``, one at a time, and average them: same input, same bytes.

    Raises InputError where there are more of them than samples a pixel.
    """
    quality, n = frame_input.quality, len(frame_input.subframes)
    if not 1 <= n <= quality.spp:
        rule = f"from 1 to {quality.spp}, the samples per pixel"
        raise InputError("subframes", n, rule, "raise --spp")
    rgb = albedo = np.zeros(3)
    covered: list[Coverage] = []
    seconds, added = dict[str, float](), dict.fromkeys(_ADDED, 0)
    built: BuiltFrame | None = None
    displayed: tuple[DisplayedRepresentation, ...] = ()
    for number, make_input in enumerate(frame_input.subframes):
        now = make_input()
        if built and now.displayed is displayed and quality.haze == "analytic":
            built = move_camera(built, now.camera, now.air, now.after)
        else:
            built = None  # freed first: a JIT variant would count its shapes, too
            built, displayed = build_frame(now, most_bytes=0), now.displayed
        share = quality.spp // n + (number < quality.spp % n)
        seed = sampler_seed(quality.seed, frame, number)
        layers = trace(built, replace(quality, spp=share, seed=seed), frame, watch)
        rgb = rgb + share / quality.spp * layers.rgb
        albedo = albedo + share / quality.spp * layers.albedo
        if layers.coverage:
            part = layers.coverage
            covered.append(replace(part, share=part.share * (share / quality.spp)))
        seconds = {k: seconds.get(k, 0.0) + each for k, each in layers.seconds.items()}
        added = {k: added[k] + layers.statistics[k] for k in _ADDED}
        if number == n // 2:
            middle = layers
    statistics = {**middle.statistics, **added, "subframes": n}
    if covered:
        columns = [(each.pixel, each.object, each.share) for each in covered]
        coverage = add_coverage(*map(np.concatenate, zip(*columns, strict=True)))
        middle = replace(middle, coverage=coverage)
    return replace(middle, rgb=rgb, albedo=albedo, seconds=seconds, statistics=statistics)
