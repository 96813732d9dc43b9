"""What the figure experiment measures, as data: kinds of object, metrics, details, distances (§4).

The view is fixed: 640×360, 60° across, so m is τ·1.8 mrad. Distances run in even ratios from the
sphere that bounds the object in every pose, so that the eye is without, to where its last part
goes; each pose is looked at from distances of its own between one and the next, so that no count
hangs on where the grid happens to lie.
"""

import math
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from bench.runner.experiment import Effort
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
from lod.pruning.view import View
from scenes.models.animals.catalogue import animal
from scenes.models.people.people import people_at_rest
from scenes.plugins.entry_points import metric_by_name
from scenes.rig.rigged_prototype import RiggedPrototype

PERSON = "person"
EVERYTHING = (PERSON, "rabbit", "giraffe", "ostrich", "insect", "windmill")
"""Objects measured. Seeds are drawn by position here: a new one belongs at the end."""
METRICS = ("blake", "bounded", "solid_angle")

DETAIL_PX = 1.0
EXAGGERATED_PX = 16.0
"""The paper says its detail was exaggerated, and not how much: a sixteenth of what can be seen."""

SIZE_PX, FOV_DEG = (640, 360), 60.0
POINTS_PER_JOINT = {"composing": 0, "composing_and_placing": 2}
"""The frames of all joints alone, as counting needs them; and both ends of a stick on each."""

_GOLDEN = (math.sqrt(5) - 1) / 2

Distances = Float64[np.ndarray, "distances poses"]


@dataclass(frozen=True)
class Curve:
    """Parts against distance, for one kind, metric and detail threshold τ [px]."""

    kind: str
    metric: str
    detail: float

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)

    @property
    def view(self) -> View:
        """The view, that sees all round."""
        camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0.0, 0.0, FOV_DEG, SIZE_PX)
        return View(camera, metric_by_name(self.metric), self.detail, look_around=True)

    @property
    def limits(self) -> Reals:
        """Clamped limit distance of every part, (n,) [m]."""
        return self.view.limits(object_of(self.kind).hierarchy)[0]

    @property
    def fits(self) -> float:
        """Distance from which the object fits into the picture, whatever its pose [m]."""
        return float(object_of(self.kind).hierarchy.B[0] / self.view.camera.tan_half[1])

    def distances(self, count: int) -> Reals:
        """Of the eye from the object's origin, in even ratios, (count,) [m]."""
        near = object_of(self.kind).hierarchy.B[0]
        return np.geomspace(near, self.limits[0], count + 1)[:-1]


@dataclass(frozen=True)
class Approach:
    """A curve that is counted, over so many poses, at so many distances."""

    curve: Curve
    poses: int
    distances: int


@dataclass(frozen=True)
class Sizes:
    """A kind whose parts' sizes are listed."""

    kind: str


@dataclass(frozen=True)
class PosingTask:
    """What is posed, so many poses in each repeat, and how many repeats."""

    task: str
    poses: int
    repeats: int


def cases(effort: Effort, metric: str | None = None) -> list[Approach | Sizes | PosingTask]:
    """Every curve, ``metric``'s too; the sizes of all parts of every kind; posing in two ways."""
    poses, distances = effort["poses"], effort["distances"]
    return [
        *(Approach(curve, poses, distances) for curve in curves(metric)),
        *(Sizes(kind) for kind in EVERYTHING),
        *(PosingTask(task, effort["posed"], effort["repeats"]) for task in POINTS_PER_JOINT),
    ]


def curves(more: str | None = None) -> tuple[Curve, ...]:
    """Every kind with every metric, ``more`` too; the person with exaggerated detail as well."""
    metrics = (*METRICS, *([more] if more else []))
    usual = [Curve(kind, metric, DETAIL_PX) for kind in EVERYTHING for metric in metrics]
    return (*usual, *(Curve(PERSON, metric, EXAGGERATED_PX) for metric in metrics))


@lru_cache(maxsize=16)
def object_of(kind: str) -> RiggedPrototype:
    """The one object of a kind; the person is an adult."""
    return people_at_rest(0, 1, 0.0)[0] if kind == PERSON else animal(kind)


def looked_from(distances: Reals, poses: int) -> Distances:
    """Where each pose is looked at from: a share of a step beyond each distance [m].

    The shares are multiples of the golden section, which fill a step evenly however many there are.
    """
    step = (distances[-1] / distances[0]) ** (1 / (len(distances) - 1))
    return distances[:, None] * step ** np.mod(_GOLDEN * np.arange(poses), 1.0)
