"""A thin lens: how wide it spreads the image of a point that is not in focus."""

import math
from dataclasses import dataclass

from lod.errors import InputError


@dataclass(frozen=True)
class ThinLens:
    """An ideal lens with a round opening.

    diameter_m  of the opening: focal length over f-number [m]
    focus_m     distance along the camera's axis at which things are sharp [m]; may be infinite

    A point at distance z along the axis covers a disc of the angle A·|1/z − 1/s|, A the diameter
    and s the focus (Potmesil & Chakravarty, "A lens and aperture camera model for synthetic image
    generation", SIGGRAPH 1981, with the angle taken at the lens and the field of view that of the
    picture in focus).
    """

    diameter_m: float
    focus_m: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.diameter_m) and self.diameter_m > 0):
            raise InputError("lens diameter", self.diameter_m, "finite and above 0 m")
        if not self.focus_m > 0:
            raise InputError("camera.focus", self.focus_m, "above 0 m", "focus before the camera")
