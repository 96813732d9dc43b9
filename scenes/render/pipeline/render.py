"""One frame from its input to its layers."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import Layers
from scenes.frame.quality import SampleWatch
from scenes.render.description import Description
from scenes.render.pictures import check_denoiser, denoise_layers
from scenes.render.pipeline.memory_limit import check_memory
from scenes.render.pipeline.render_subframes import render_subframes
from scenes.render.pipeline.stages import (
    build,
    build_frame,
    ignore_samples,
    move_camera,
    trace,
)

LEFT, RIGHT = 0, 1


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
        eyes = (None,) if not frame_input.camera.baseline_m else (LEFT, RIGHT)
        pair = [render_subframes(_seen_by(frame_input, eye), frame, watch) for eye in eyes]
    else:
        pair = _still(frame_input, frame, watch, description, most_bytes)
    pair = [_denoised(each) if frame_input.denoise else each for each in pair]
    left, *right = pair
    return replace(left, right=right[0]) if right else left


def _still(
    frame_input: FrameInput,
    frame: int,
    watch: SampleWatch,
    description: Description | None,
    most_bytes: int | None,
) -> list[Layers]:
    """One picture of a scene, or one for each eye: both see one scene, built once."""
    quality, air = frame_input.quality, frame_input.air
    if description is None:
        built = build_frame(frame_input, most_bytes)
    else:
        built = build(description, air, quality)
    if not frame_input.camera.baseline_m:
        return [trace(built, quality, frame, watch)]
    seen = [_seen_by(frame_input, eye) for eye in (LEFT, RIGHT)]
    moved = (move_camera(built, each.camera, air, each.after) for each in seen)
    return [trace(each, quality, frame, watch) for each in moved]


def _seen_by(frame_input: FrameInput, eye: int | None) -> FrameInput:
    """The same frame as one eye of a pair sees it, and so its sub-frames."""
    if eye is None:
        return frame_input

    def at(make: Callable[[], FrameInput]) -> FrameInput:
        return _seen_by(make(), eye)

    return replace(
        frame_input,
        camera=frame_input.camera.pair[eye],
        after=frame_input.after.pair[eye] if frame_input.after else None,
        subframes=tuple(partial(at, make) for make in frame_input.subframes),
    )


def _denoised(layers: Layers) -> Layers:
    start = time.perf_counter()
    layers = denoise_layers(layers)
    return replace(layers, seconds={**layers.seconds, "denoise": time.perf_counter() - start})
