"""What a frame is rendered from; nothing here knows the renderer."""

from collections.abc import Callable
from dataclasses import dataclass, field

from lod.atmosphere.air import Air
from lod.camera import Camera
from scenes.frame.displayed import Visible
from scenes.frame.quality import Quality
from scenes.world.light import Light


@dataclass(frozen=True, eq=False)
class Extras:
    """Layers beside the usual ones.

    after    the next frame's camera, where motion is asked for
    denoise  whether a denoised picture is
    """

    after: Camera | None = None
    denoise: bool = False


USUAL = Extras()
"""No other layers."""


@dataclass(frozen=True)
class FileForm:
    """How a frame's file is laid out; none of it loses anything but half's rounding.

    compression  zip, zips, piz, rle or none. Only zip and zips notice a flipped bit by themselves
    multipart    a part for each group of layers instead of one part with all
    colour       "half" or "float" pixels in R G B, albedo and denoised
    """

    compression: str = "zip"
    multipart: bool = False
    colour: str = "half"


PLAIN = FileForm()
"""One part, ZIP, half."""


@dataclass(frozen=True, eq=False)
class Instant:
    """One moment of a frame while the shutter is open, in the frame's own coordinates.

    after  the camera a frame's time later, where motion is asked for
    """

    camera: Camera
    visible: tuple[Visible, ...]
    after: Camera | None = None


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that one frame of a sequence is made from.

    instants   of the sub-frames, made when called; none where nothing moves, or no shutter is open
    fps        frames a second, for the header
    form       of the file
    extras     layers beside the usual ones
    seconds    of the stages that made this input, such as pruning
    counts     worth keeping beside those of the scene
    """

    camera: Camera
    visible: tuple[Visible, ...]
    air: Air
    light: Light
    quality: Quality
    fps: float = 24.0
    form: FileForm = PLAIN
    extras: Extras = USUAL
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    instants: tuple[Callable[[], Instant], ...] = ()
