"""What one frame is rendered from, passed whole to the renderer; nothing here knows it."""

from collections.abc import Callable
from dataclasses import dataclass, field

from lod.air import Air
from lod.camera import Camera
from scenes.frame.displayed import DisplayedRepresentation
from scenes.frame.quality import Quality
from scenes.world.light import Light


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that one frame is rendered from.

    displayed  what each representation displays, in the coordinates of the camera's corner
    after      the next frame's camera, where motion vectors are asked for
    denoise    whether a denoised picture is asked for
    subframes  inputs of the sub-frames while the shutter is open, made when called; none where
               nothing moves, or the shutter is open for no time
    seconds    of the stages that made this input, such as pruning
    counts     worth keeping beside those of the scene
    """

    camera: Camera
    displayed: tuple[DisplayedRepresentation, ...]
    air: Air
    light: Light
    quality: Quality
    after: Camera | None = None
    denoise: bool = False
    subframes: tuple[Callable[[], "FrameInput"], ...] = ()
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
