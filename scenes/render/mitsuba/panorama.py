"""A camera that sees all round, equirectangular; the renderer has none of its own."""

import math
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from scenes.render.description.scene_description import Description


class PanoramaSensor:
    """Rays of a panorama, by the calls that drivers make of the renderer's sensors."""

    def __init__(self, camera: Description) -> None:
        self._camera = camera

    def needs_aperture_sample(self) -> bool:
        """Tell that rays start in one point."""
        return False

    def sample_ray_differential(
        self, time: Any, wavelength: Any, film: Any, aperture: Any
    ) -> tuple[Any, float]:
        """Make rays through points of the film, from (0, 0) in the upper left to (1, 1)."""
        eye, forward, up = (self._camera[name] for name in ("eye", "forward", "up"))
        axes = [_opaque(axis) for axis in (np.cross(forward, up), forward, up)]
        turn, rise = (film.x - 0.5) * (2 * math.pi), (0.5 - film.y) * math.pi
        (sine, cosine), (high, level) = dr.sincos(turn), dr.sincos(rise)
        ahead = axes[0] * (level * sine) + axes[1] * (level * cosine)
        direction = dr.normalize(ahead + axes[2] * high)
        near, far = self._camera["clip"]
        start = mi.Point3f(_opaque(eye)) + direction * near
        ray = mi.Ray3f(start, direction, time)
        ray.maxt = far - near
        return mi.RayDifferential3f(ray), 1.0


def _opaque(values: np.ndarray) -> Any:
    """Make a vector an input of the kernel, which is so not compiled anew for another one."""
    return mi.Vector3f([dr.opaque(mi.Float, float(value)) for value in values])
