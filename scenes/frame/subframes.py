"""The sub-frames of a frame whose shutter is open."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from lod.camera import Camera
from lod.motion.shutter import subframe_offsets
from scenes.frame.displayed import Shown, Visible, visible_at
from scenes.frame.types import Instant
from scenes.preset.load import Preset
from scenes.world.view import camera_between, frame_time
from scenes.world.world import World


def subframes(
    world: World,
    preset: Preset,
    frame: int,
    shown: Sequence[Shown],
    visible: tuple[Visible, ...],
) -> tuple[Callable[[], Instant], ...]:
    """The sub-frames while the shutter is open, of one and the same cut; none where all is still.

    As many as ``render.subframes``, or as there are samples a pixel if those are fewer.
    """
    count = min(preset.render.subframes, preset.render.spp)
    frames = (frame + preset.view.shutter / 360 * subframe_offsets(count)).tolist()
    cameras = [camera_between(world, preset, at, shown[0].view) for at in frames]
    moves = [any(each.moves(frame_time(preset, at)) for each in shown) for at in frames]
    here = shown[0].view.camera
    if not any(moves) and all(_stand_together(here, each) for each in cameras):
        return ()

    def at_one(number: int) -> Instant:
        at, after = frames[number], None
        later = frame_time(preset, at + 1) if preset.output.motion else None
        if later is not None:
            after = camera_between(world, preset, at + 1, shown[0].view)
        now = visible
        if any(moves) or later is not None:
            now = tuple(visible_at(each, frame_time(preset, at), later) for each in shown)
        return Instant(cameras[number], now, after)

    return tuple(partial(at_one, number) for number in range(count))


def _stand_together(a: Camera, b: Camera) -> bool:
    pairs = ((a.eye, b.eye), (a.forward, b.forward), (a.up, b.up))
    return all(np.array_equal(one, other) for one, other in pairs)
