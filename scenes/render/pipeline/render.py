"""One frame from its input to its layers."""

import time
from dataclasses import replace

from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.render.description.scene_description import Description
from scenes.render.pictures.denoise import check_denoiser, denoise
from scenes.render.pipeline.stages import Watch, build, build_frame, ignore, trace
from scenes.render.pipeline.subframes import render_subframes


def render_frame(
    frame_input: FrameInput,
    frame: int = 0,
    watch: Watch = ignore,
    description: Description | None = None,
) -> Layers:
    """Render ``frame``: same arguments, same bytes, within a variant and on any thread count.

    description  of the frame, from who has let go of what is displayed; None: it is made here.
                 It is used up
    Raises InputError for numbers that the renderer would accept silently (NaN, albedo above 1).
    """
    if frame_input.denoise:
        check_denoiser()
    if frame_input.subframes:
        layers = render_subframes(frame_input, frame, watch)
    elif description is None:
        layers = trace(build_frame(frame_input), frame_input.quality, frame, watch)
    else:
        built = build(description, frame_input.air, frame_input.quality)
        layers = trace(built, frame_input.quality, frame, watch)
    if not frame_input.denoise:
        return layers
    start = time.perf_counter()
    layers = denoise(layers)
    return replace(layers, seconds={**layers.seconds, "denoise": time.perf_counter() - start})
