"""Inputs of the sub-frames of a frame whose shutter is open: cameras and poses at instants.

scenes/render/pipeline/render_subframes.py renders and averages them.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np

from lod.camera import Camera
from lod.motion import subframe_offsets
from scenes.frame.frame_input import FrameInput
from scenes.preset.tables import Preset
from scenes.world.view import camera_between, frame_time
from scenes.world.world import World


def subframe_inputs(
    world: World, preset: Preset, frame: int, frame_input: FrameInput
) -> tuple[Callable[[], FrameInput], ...]:
    """Make the inputs of the sub-frames, all of one cut; there are none where all is still.

    There are as many as ``render.subframes`` says, or as there are samples a pixel if those are
    fewer. Where only the camera moves they all hold the same tuple of what is displayed.
    """
    here, displayed = frame_input.camera, frame_input.displayed
    count = min(preset.render.subframes, preset.render.spp)
    frames = (frame + preset.view.shutter / 360 * subframe_offsets(count)).tolist()
    cameras = [camera_between(world, preset, at, here.corner) for at in frames]
    moves = any(each.moves(frame_time(preset, at)) for at in frames for each in displayed)
    if not moves and all(_same_place(here, each) for each in cameras):
        return ()

    def at_one(number: int) -> FrameInput:
        at, now, after = frames[number], displayed, None
        later = frame_time(preset, at + 1) if preset.output.motion else None
        if later is not None:
            after = camera_between(world, preset, at + 1, here.corner)
        if moves or later is not None:
            now = tuple(each.at(frame_time(preset, at), later) for each in displayed)
        return replace(frame_input, camera=cameras[number], displayed=now, after=after)

    return tuple(partial(at_one, number) for number in range(count))


def _same_place(a: Camera, b: Camera) -> bool:
    pairs = ((a.eye, b.eye), (a.forward, b.forward), (a.up, b.up))
    return all(np.array_equal(one, other) for one, other in pairs)
