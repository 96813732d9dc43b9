"""What the figure experiment measures, as data: kinds of object, metrics, details, distances (§4).

The view is fixed: 640×360, 60° across, so m is τ·1.8 mrad. Distances run in even ratios from where
every part is displayed, or where the object fits into the picture, whichever is nearer, to where
its last part goes. A detail that is exaggerated never shows every part of an object from without:
there they begin at the object's bounding sphere.
"""

from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from lod.arrays import Reals
from lod.camera import Corner, look
from lod.metric import metric_named
from lod.view import View
from scenes.animals import KINDS, animal
from scenes.rig_figure import rigged_people
from scenes.rig_prototype import RiggedPrototype

PERSON = "person"
EVERYTHING = (PERSON, *KINDS)
METRICS = ("blake", "bounded", "solid_angle")

DETAIL_PX = 1.0
EXAGGERATED_PX = 16.0
"""The paper says its detail was exaggerated, and not how much: a sixteenth of what can be seen."""

SIZE_PX, FOV_DEG = (640, 360), 60.0
_NEARLY = 0.999
"""The farthest distance is this share of the whole object's limit distance."""


@dataclass(frozen=True)
class Curve:
    """Parts against distance, for one kind, metric and detail threshold τ [px]."""

    kind: str
    metric: str
    detail: float

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @property
    def view(self) -> View:
        """The view, that sees all round."""
        camera = look(Corner(0, 0), np.zeros(3), 0.0, 0.0, FOV_DEG, SIZE_PX)
        return View(camera, metric_named(self.metric), self.detail, look_around=True)

    @property
    def limits(self) -> Reals:
        """Clamped limit distance of every part, (n,) [m]."""
        return self.view.limits(object_of(self.kind).hierarchy)[0]

    @property
    def fits(self) -> float:
        """Distance from which the object fits into the picture in whatever pose [m]."""
        return float(object_of(self.kind).hierarchy.B[0] / self.view.camera.tan_half[1])

    def distances(self, count: int) -> Reals:
        """Of the eye from the object's origin, (count,) [m]."""
        bound, limits = float(object_of(self.kind).hierarchy.B[0]), self.limits
        near = max(bound, min(self.fits, float(limits.min()) - bound))
        return np.geomspace(near, _NEARLY * limits[0], count)


def curves() -> tuple[Curve, ...]:
    """Every kind with every metric; the person with exaggerated detail too."""
    usual = [Curve(kind, metric, DETAIL_PX) for kind in EVERYTHING for metric in METRICS]
    return (*usual, *(Curve(PERSON, metric, EXAGGERATED_PX) for metric in METRICS))


@lru_cache(maxsize=16)
def object_of(kind: str) -> RiggedPrototype:
    """The one object of a kind; the person is an adult."""
    return rigged_people(0, 1, 0.0)[0] if kind == PERSON else animal(kind)
