"""One frame from its input to its layers."""

import time
from dataclasses import replace

from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import SampleWatch
from scenes.render.description.scene_description import Description
from scenes.render.pictures.denoise import check_denoiser, denoise
from scenes.render.pipeline.memory_limit import check_memory
from scenes.render.pipeline.render_subframes import render_subframes
from scenes.render.pipeline.stages import build, build_frame, ignore_samples, trace


def render_frame(
    frame_input: FrameInput,
    frame: int = 0,
    watch: SampleWatch = ignore_samples,
    description: Description | None = None,
    most_bytes: int | None = None,
) -> Layers:
    """Render ``frame``: same arguments, same bytes, within a variant and on any thread count.

    description  the frame's description, where the caller made it in order to free
                 ``frame_input.displayed`` before the scene is built; its arrays are taken over, so
                 that it cannot be used again, and who has seen to its memory. None: it is made here
    most_bytes   that it may need, as of ``memory_limit``
    Raises InputError for numbers that the renderer would accept silently (NaN, albedo above 1), and
    for what is foretold to need more memory than it may.
    """
    if frame_input.denoise:
        check_denoiser()
    if frame_input.subframes:
        check_memory(frame_input, most_bytes, "the picture")
        layers = render_subframes(frame_input, frame, watch)
    elif description is None:
        layers = trace(build_frame(frame_input, most_bytes), frame_input.quality, frame, watch)
    else:
        built = build(description, frame_input.air, frame_input.quality)
        layers = trace(built, frame_input.quality, frame, watch)
    if not frame_input.denoise:
        return layers
    start = time.perf_counter()
    layers = denoise(layers)
    return replace(layers, seconds={**layers.seconds, "denoise": time.perf_counter() - start})
