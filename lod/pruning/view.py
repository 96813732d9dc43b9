"""A view: a camera, a metric and a detail, and with them the one test of every part."""

import math
from dataclasses import dataclass, replace

import numpy as np

from lod.camera import Camera
from lod.errors import InputError
from lod.metric.family import Metric, limit_distances
from lod.metric.hierarchy import Hierarchy
from lod.motion.shutter import ShutterInterval, motion_coarsening
from lod.vision.viewer import ViewingConditions


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
        if not (math.isfinite(self.detail) and self.detail > 0):
            raise InputError("detail", self.detail, "a threshold above 0 px", "try --detail 1.0")
        if not 0 < self.offscreen_detail <= 1:
            raise InputError("offscreen_detail", self.offscreen_detail, "above 0, at most 1")
        if not 0 <= self.fade < 1:
            raise InputError("fade", self.fade, "at least 0, below 1", "try 0.2")
        if self.look_around and self.metric.along_axis:
            raise InputError("metric", self.metric.name, "needs a view axis, not a full turn")
        if self.conditions is not None and self.conditions.widths.pixel != self.camera.pixel_angle:
            arrived = self.conditions.widths.pixel
            raise InputError(
                "conditions.widths.pixel", arrived, "the angle of the camera's own pixel"
            )

    @property
    def theta(self) -> float:
        """Return θ of one pixel, or of all blurs together but that of motion (§2.1) [rad]."""
        return (
            self.camera.pixel_angle if self.conditions is None else self.conditions.widths.effective
        )

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
        None is greater out of view: an eye's W grows faster at a finer m, and could turn them
        round where much of D is the range (``bounded``); and what motion hides in view is not kept
        for its shadow. None grows with motion_step. For two eyes they are those of
        ``for_both_eyes``.
        """
        inside = limit_distances(hierarchy, self.metric, self.m, self.conditions)
        if motion_step and self.metric.finite:
            m, conditions = (
                self.m * motion_coarsening(motion_step),
                self._conditions_in_motion(motion_step),
            )
            inside = np.minimum(inside, limit_distances(hierarchy, self.metric, m, conditions))
        if self.metric.along_axis:
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

    def _conditions_in_motion(self, motion_step: int) -> ViewingConditions | None:
        """What is looked through while things move: θ_motion is the even blur of the same m."""
        if self.conditions is None:
            return None
        motion = self.theta * math.sqrt(motion_coarsening(motion_step) ** 2 - 1)
        return replace(self.conditions, widths=replace(self.conditions.widths, motion=motion))
