"""Airlight from the horizon: the sky's own radiance there, so that land fades into the sky."""

import numpy as np

from scenes.render.description.scene_description import Description
from scenes.render.mitsuba.emitters import radiance, sky
from scenes.render.mitsuba.plugin import load_plugin

HORIZON_DEG = 0.5
"""Elevation of the airlight: the sky model darkens towards 0°, within its last half degree."""

AZIMUTHS = 1440
"""Rows of a table of airlight, evenly spaced clockwise from north."""


def horizon(light: Description) -> np.ndarray:
    """Radiance at the horizon by azimuth, (AZIMUTHS, bands); never negative."""
    angles, up = np.arange(AZIMUTHS) / AZIMUTHS * 2 * np.pi, np.radians(HORIZON_DEG)
    east, north = np.cos(up) * np.sin(angles), np.cos(up) * np.cos(angles)
    return sky_radiance(light, np.stack((east, north, np.full(AZIMUTHS, np.sin(up))), axis=1))


def sky_radiance(light: Description, directions: np.ndarray) -> np.ndarray:
    """Radiance of the sky without its sun, (n, 3) → (n, bands); the model's negatives become 0."""
    return np.maximum(radiance(load_plugin(sky(light, sun_scale=0.0)), directions), 0.0)
