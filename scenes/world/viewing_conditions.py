"""From a preset to its air, and to what this air and a viewer's eye let through."""

import math

from lod.atmosphere.air import Air, least_extinction
from lod.atmosphere.mist import Mist
from lod.camera import Camera
from lod.vision.blur_cascade import blur_widths
from lod.vision.eye import Display, Eye
from lod.vision.viewer import ViewingConditions
from scenes.preset.load import Preset

_ARCSECOND = math.radians(1 / 3600)


def air_of(preset: Preset) -> Air:
    """The air that frames are rendered in, and that the same frames are pruned by."""
    keys = preset.air
    mist = None if keys.mist is None else Mist(keys.mist, keys.mist_base, keys.mist_scale)
    return Air(keys.visibility, mist)


def sight_of(preset: Preset, camera: Camera, highest_m: float) -> ViewingConditions | None:
    """What counts beyond the pixel; None where the air is clear, or ignored, and no eye is given.

    ``highest_m``: height above the datum that neither the eye nor anything it sees is above, for β
    there is the least of any path. A table [display] or [eye] says that somebody will look.
    """
    air, keys = air_of(preset), preset.air
    hazy = preset.view.haze_aware and air != Air()
    watched = preset.display is not None or preset.eye is not None
    if not (hazy or watched or keys.seeing):
        return None
    display = Display(**preset.display.model_dump()) if preset.display else Display()
    eye = Eye(**preset.eye.model_dump()) if preset.eye else Eye()
    seeing = keys.seeing * _ARCSECOND
    widths = blur_widths(camera.pixel_angle, display, eye if watched else None, seeing)
    beta = least_extinction(air, highest_m) if hazy else 0.0
    return ViewingConditions(widths, beta, display, eye, acuity=watched)
