"""Sun and sky that light a world, and the air that its light passes through."""

import math
from dataclasses import dataclass

import numpy as np

from lod.air import Air
from scenes.presets.schema import Preset


@dataclass(frozen=True)
class Light:
    """Sun and sky that light a world.

    sun_azimuth_deg    clockwise from north (+y) [degrees]
    sun_elevation_deg  above the horizon [degrees]
    """

    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float = 3.0

    @property
    def to_sun(self) -> np.ndarray:
        """Return the unit vector to the sun, (3,)."""
        a, e = math.radians(self.sun_azimuth_deg), math.radians(self.sun_elevation_deg)
        return np.array((math.sin(a) * math.cos(e), math.cos(a) * math.cos(e), math.sin(e)))


def sun_and_sky(preset: Preset) -> Light:
    """Return the sun and sky of a preset."""
    light = preset.light
    return Light(light.sun_azimuth, light.sun_elevation, light.turbidity)


def preset_air(preset: Preset) -> Air:
    """Return the air that frames are rendered in, and that the same frames are pruned by."""
    return Air(preset.air.visibility)
