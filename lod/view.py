"""A view: a camera, a metric and a detail, and with them the one test of every part, d < D (§2.4).

The test has two forms, on arrays and compiled for one point. Their arithmetic and its order are the
same, in float64, so that both agree to the last bit.
"""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from lod.camera import Camera
from lod.errors import InputError
from lod.hierarchy import Hierarchy
from lod.kernels import njit
from lod.metric import Metric, limit_distances
from lod.motion import ShutterInterval, motion_coarsening
from lod.viewing import ViewingConditions


@dataclass(frozen=True, eq=False)
class View:
    """What one frame asks of every representation.

    detail            τ: detail threshold [px]
    offscreen_detail  detail kept out of view, as a share of that in view (0 to 1]
    look_around       no field of view: every direction counts as in view (experiments on the law)
    fade              share of D before it over which a part shrinks away; 0 = it is clipped at D
    time_s            when the frame is taken, for what moves [s]
    conditions        air, display and eye; None = clear air and an ideal eye
    shutter           while the shutter is open; None = no time at all, and motion hides nothing
    sun               unit vector on the map to where the sun stands, for appearances that depend
                      on it; None = they are the same from all sides
    """

    camera: Camera
    metric: Metric
    detail: float = 1.0
    offscreen_detail: float = 0.25
    look_around: bool = False
    fade: float = 0.0
    time_s: float = 0.0
    conditions: ViewingConditions | None = None
    shutter: ShutterInterval | None = None
    sun: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        if self.look_around and self.metric.along_axis:
            raise InputError("metric", self.metric.name, "needs a view axis, not a full turn")
        pixel = self.camera.pixel_angle if self.conditions is None else self.conditions.widths.pixel
        if pixel != self.camera.pixel_angle:
            raise InputError(
                "conditions.widths.pixel", pixel, "the angle of the camera's own pixel"
            )

    @property
    def theta(self) -> float:
        """Return θ of one pixel, or of all blurs together but that of motion (§2.1) [rad]."""
        if self.conditions is None:
            return self.camera.pixel_angle
        return self.conditions.widths.effective

    @property
    def m(self) -> float:
        """Compute m = τ·θ in view (§2.4) [rad]."""
        return self.detail * self.theta

    @property
    def m_offscreen(self) -> float:
        """Compute the coarser m of what is out of view, seen only by shadow and bounce [rad]."""
        return self.m / self.offscreen_detail

    def limits(self, hierarchy: Hierarchy, motion_step: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Compute the clamped limit distances of every part, in view and out of it, (n,) each [m].

        motion_step: of the object, a whole step on the scale of ``shutter``.
        Out of view those of what thins out are 0: what of it casts shadows into view has a bound so
        large that it counts as in view. None is greater out of view: an eye's W grows faster at a
        finer m, and could turn them round where much of D is the range (``bounded``); and what
        motion hides in view is not kept for its shadow. None grows with motion_step. For two eyes
        they are those of ``for_both_eyes``.
        """
        inside = limit_distances(hierarchy, self.metric, self.m, self.conditions)
        if motion_step and self.metric.finite:
            coarser, conditions = motion_coarsening(motion_step), self.conditions
            if conditions is not None:  # θ_motion is the even blur of the same m
                motion = self.theta * math.sqrt(coarser**2 - 1)
                conditions = replace(conditions, widths=replace(conditions.widths, motion=motion))
            moving = limit_distances(hierarchy, self.metric, self.m * coarser, conditions)
            inside = np.minimum(inside, moving)
        if self.metric.along_axis:
            return self.for_both_eyes(inside), np.zeros_like(inside)
        if hierarchy.is_thinned and self.metric.finite:
            return self.for_both_eyes(inside), np.zeros_like(inside)
        outside = limit_distances(hierarchy, self.metric, self.m_offscreen, self.conditions)
        return self.for_both_eyes(inside), self.for_both_eyes(np.minimum(inside, outside))

    def for_both_eyes(self, limits: np.ndarray) -> np.ndarray:
        """Lengthen limit distances so that a cut from the middle of two eyes serves both, (n,) [m].

        d from the middle is at most half the baseline more than from the nearer eye. What is
        displayed nowhere stays so.
        """
        if not self.camera.baseline_m:
            return limits
        return np.where(limits > 0, limits + self.camera.baseline_m / 2, 0.0)


def distance(view: View, position: np.ndarray) -> np.ndarray:
    """Compute d of points (n, 3) from the eye, or along the axis if the metric says so, (n,) [m].

    Never below 0, so that nothing passes a limit of 0; a point behind the eye has depth 0.
    """
    offset = position - view.camera.eye
    if view.metric.along_axis:
        return np.maximum(_dot(offset, view.camera.forward), 0.0)
    return np.sqrt(offset[:, 0] ** 2 + offset[:, 1] ** 2 + offset[:, 2] ** 2)


def in_view(view: View, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
    """Tell whether each sphere reaches into the pyramid of view, (n, 3), (n,) → (n,).

    Of two eyes it is the pyramid of the middle, which each sphere reaches that is half the
    baseline larger than one that reaches into an eye's own.

    Plane by plane, so a sphere beyond an edge of the pyramid may count as in view; never the
    reverse. A sphere inside another is in view only if the other is: with nested bounds, cuts stay
    connected.
    """
    if view.look_around:
        return np.ones(len(centre), bool)
    camera, offset = view.camera, centre - view.camera.eye
    radius = radius + camera.baseline_m / 2
    ahead = _dot(offset, camera.forward)
    seen = ahead > -radius
    for axis, tangent in zip((camera.right, camera.up), camera.tan_half, strict=True):
        aside, length = _dot(offset, axis), math.hypot(1.0, tangent)
        seen &= (ahead * tangent - np.abs(aside)) / length > -radius
    return seen


def _dot(offset: np.ndarray, axis: np.ndarray) -> np.ndarray:
    # Summed from x to z whatever n is: one point has the same bits in any batch and compiled.
    return offset[:, 0] * axis[0] + offset[:, 1] * axis[1] + offset[:, 2] * axis[2]


def search_radius(view: View, limit: float, bound: float) -> float:
    """Compute the greatest true distance at which something in view can pass its test [m].

    Along the axis it can be D deep and still lie aside of it, by D·tan + B·√(1 + tan²) on each
    axis.
    """
    if not view.metric.along_axis:
        return limit
    aside = [limit * tan + bound * math.hypot(1.0, tan) for tan in view.camera.tan_half]
    return math.hypot(limit, *aside)


ENTRY_SHARE = 0.25
"""Share of its diameter with which a sphere has entered the view: what it holds fills little of it,
and would be seen thin along the picture's edges if that took longer."""

Triple = tuple[float, float, float]


class CompiledView(NamedTuple):
    """A view as compiled traversals read it: the eye, the camera's axes, and the view frustum.

    tan     tangents of half the field of view on both axes; length: √(1 + tan²)
    aside   how far either of two eyes is from the middle [m]
    """

    eye: Triple
    forward: Triple
    right: Triple
    up: Triple
    tan: tuple[float, float]
    length: tuple[float, float]
    along_axis: bool
    look_around: bool
    aside: float


def compile_view(view: View) -> CompiledView:
    """Return what compiled traversals need of a view."""
    camera = view.camera
    tan_x, tan_y = camera.tan_half
    return CompiledView(
        _triple(camera.eye),
        _triple(camera.forward),
        _triple(camera.right),
        _triple(camera.up),
        (tan_x, tan_y),
        (math.hypot(1.0, tan_x), math.hypot(1.0, tan_y)),
        view.metric.along_axis,
        view.look_around,
        camera.baseline_m / 2,
    )


def _triple(values: np.ndarray) -> Triple:
    x, y, z = values.tolist()
    return x, y, z


@njit(cache=True)
def distance_to(s, x, y, z):  # type: ignore[no-untyped-def]
    """Compute ``distance`` of one point [m]."""
    x, y, z = x - s.eye[0], y - s.eye[1], z - s.eye[2]
    if s.along_axis:
        return max(x * s.forward[0] + y * s.forward[1] + z * s.forward[2], 0.0)
    return math.sqrt(x * x + y * y + z * z)


@njit(cache=True)
def sphere_in_frustum(s, x, y, z, radius):  # type: ignore[no-untyped-def]
    """Tell ``in_view`` of one sphere."""
    if s.look_around:
        return True
    radius += s.aside
    x, y, z = x - s.eye[0], y - s.eye[1], z - s.eye[2]
    ahead = x * s.forward[0] + y * s.forward[1] + z * s.forward[2]
    if not ahead > -radius:
        return False
    aside = abs(x * s.right[0] + y * s.right[1] + z * s.right[2])
    if not (ahead * s.tan[0] - aside) / s.length[0] > -radius:
        return False
    above = abs(x * s.up[0] + y * s.up[1] + z * s.up[2])
    return (ahead * s.tan[1] - above) / s.length[1] > -radius


@njit(cache=True)
def entry_fraction(s, x, y, z, radius):  # type: ignore[no-untyped-def]
    """Compute the share of its entry that a sphere in the frustum has made, 0 to 1.

    The entry is complete once ENTRY_SHARE of the sphere's diameter is inside the pyramid of view:
    plane by plane as in ``sphere_in_frustum``.
    """
    if s.look_around or radius <= 0.0:
        return 1.0
    x, y, z = x - s.eye[0], y - s.eye[1], z - s.eye[2]
    ahead = x * s.forward[0] + y * s.forward[1] + z * s.forward[2]
    aside = abs(x * s.right[0] + y * s.right[1] + z * s.right[2])
    above = abs(x * s.up[0] + y * s.up[1] + z * s.up[2])
    across = (ahead * s.tan[0] - aside) / s.length[0]
    margin = min(ahead, across, (ahead * s.tan[1] - above) / s.length[1])
    return min((margin + s.aside + radius) / (2.0 * ENTRY_SHARE * radius), 1.0)


@njit(cache=True)
def is_displayed(s, x, y, z, bound, limit, limit_offscreen):  # type: ignore[no-untyped-def]
    """Tell whether a part is displayed: d < D, with the coarser D for what is out of view.

    Whether it is in view is computed only where that decides.
    """
    d = distance_to(s, x, y, z)
    inside, outside = d < limit, d < limit_offscreen
    return inside if inside == outside or sphere_in_frustum(s, x, y, z, bound) else outside
