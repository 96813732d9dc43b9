"""The compiled test of the metric, d < D, for every compiled traversal (§2.4).

The arithmetic and its order are those of ``lod.pruning.pruner.displayed``, in float64, so that both
agree to the last bit. Whether a part is in view is computed only where that decides.
"""

import math
from typing import NamedTuple

from numba import njit

from lod.pruning.view import View

ENTRY_SHARE = 0.25
"""Share of its diameter with which a sphere has entered the view: what it holds fills little of it,
and would be seen thin along the picture's edges if that took longer."""


class CompiledView(NamedTuple):
    """A view as compiled traversals read it: the eye, the camera's axes, and the view frustum.

    ``tan`` is the tangent of half the field of view on each axis, ``length`` is √(1 + tan²), and
    ``aside`` how far either of two eyes is from the middle.
    """

    eye_x: float
    eye_y: float
    eye_z: float
    forward_x: float
    forward_y: float
    forward_z: float
    right_x: float
    right_y: float
    right_z: float
    up_x: float
    up_y: float
    up_z: float
    tan_x: float
    tan_y: float
    length_x: float
    length_y: float
    along_axis: bool
    look_around: bool
    aside: float


def compile_view(view: View) -> CompiledView:
    """Return what compiled traversals need of a view."""
    camera = view.camera
    x, y, z = camera.eye.tolist()
    axes = camera.forward.tolist(), camera.right.tolist(), camera.up.tolist()
    (fx, fy, fz), (rx, ry, rz), (ux, uy, uz) = axes
    tan_x, tan_y = camera.tan_half
    sides = tan_x, tan_y, math.hypot(1.0, tan_x), math.hypot(1.0, tan_y)
    rules = view.metric.along_axis, view.look_around
    aside = camera.baseline_m / 2
    return CompiledView(x, y, z, fx, fy, fz, rx, ry, rz, ux, uy, uz, *sides, *rules, aside)


@njit(cache=True)
def distance_to(s, x, y, z):  # type: ignore[no-untyped-def]
    """Return ``view_geometry.distance`` of one point [m]."""
    x, y, z = x - s.eye_x, y - s.eye_y, z - s.eye_z
    if s.along_axis:
        return max(x * s.forward_x + y * s.forward_y + z * s.forward_z, 0.0)
    return math.sqrt(x * x + y * y + z * z)


@njit(cache=True)
def sphere_in_frustum(s, x, y, z, radius):  # type: ignore[no-untyped-def]
    """Return ``view_geometry.in_view`` of one sphere."""
    if s.look_around:
        return True
    radius += s.aside
    x, y, z = x - s.eye_x, y - s.eye_y, z - s.eye_z
    ahead = x * s.forward_x + y * s.forward_y + z * s.forward_z
    if not ahead > -radius:
        return False
    aside = abs(x * s.right_x + y * s.right_y + z * s.right_z)
    if not (ahead * s.tan_x - aside) / s.length_x > -radius:
        return False
    above = abs(x * s.up_x + y * s.up_y + z * s.up_z)
    return (ahead * s.tan_y - above) / s.length_y > -radius


@njit(cache=True)
def frustum_margin(s, x, y, z):  # type: ignore[no-untyped-def]
    """Compute how far a point is from the nearest plane of the frustum, above 0 inside [m].

    Plane by plane as ``sphere_in_frustum``: a sphere is seen while this is above minus its radius.
    """
    if s.look_around:
        return math.inf
    x, y, z = x - s.eye_x, y - s.eye_y, z - s.eye_z
    ahead = x * s.forward_x + y * s.forward_y + z * s.forward_z
    aside = abs(x * s.right_x + y * s.right_y + z * s.right_z)
    above = abs(x * s.up_x + y * s.up_y + z * s.up_z)
    across = (ahead * s.tan_x - aside) / s.length_x
    return min(ahead, across, (ahead * s.tan_y - above) / s.length_y)


@njit(cache=True)
def entry_fraction(s, x, y, z, radius):  # type: ignore[no-untyped-def]
    """Compute the share of its entry that a sphere in the frustum has made, 0 to 1.

    The entry is complete once ENTRY_SHARE of the sphere's diameter is inside the pyramid of view.
    """
    if s.look_around or radius <= 0.0:
        return 1.0
    return min((frustum_margin(s, x, y, z) + s.aside + radius) / (2.0 * ENTRY_SHARE * radius), 1.0)


@njit(cache=True)
def is_displayed(s, x, y, z, bound, limit, limit_offscreen):  # type: ignore[no-untyped-def]
    """Tell whether a part is displayed: d < D, with the coarser D for what is out of view."""
    d = distance_to(s, x, y, z)
    inside, outside = d < limit, d < limit_offscreen
    return inside if inside == outside or sphere_in_frustum(s, x, y, z, bound) else outside
