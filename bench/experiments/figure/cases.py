"""What does the figure experiment measure? Kinds of object, metrics, details and distances (§4).

The view is fixed: 640×360 pixels, 60° across, so m is τ·1.8 mrad. Distances run in even ratios from
the sphere that bounds the object in every pose, so that the eye is outside, to where its last part
goes. Each pose is looked at from distances of its own between one and the next, so that no count
depends on where the grid of distances lies.
"""

import math
from dataclasses import asdict, dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from jaxtyping import Float64

from bench.old_experiment import Effort
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
from lod.view import View
from scenes.figures.animal_file import animal
from scenes.figures.person import people_at_rest
from scenes.plugins import metric_by_name
from scenes.rig.rigged_prototype import RiggedPrototype

PERSON = "person"
EVERYTHING = (PERSON, "rabbit", "giraffe", "ostrich", "insect", "windmill")
"""The objects that are measured; their order gives their seeds, so new ones go to the end."""
METRICS = ("blake", "bounded", "solid_angle")

DETAIL_PX = 1.0
EXAGGERATED_PX = 16.0
"""τ of exaggerated detail [px]: the paper exaggerated its detail, and does not say how much."""

SIZE_PX, FOV_DEG = (640, 360), 60.0
POINTS_PER_JOINT = {"composing": 0, "composing_and_placing": 2}
"""The points that posing places on each joint: none, or both ends of a stick."""

_GOLDEN = (math.sqrt(5) - 1) / 2

Distances = Float64[np.ndarray, "distances poses"]


@dataclass(frozen=True)
class Curve:
    """The curve of parts against distance of one kind, metric and detail threshold τ [px]."""

    kind: str
    metric: str
    detail: float

    def as_json(self) -> dict[str, Any]:
        """Return plain data."""
        return asdict(self)

    @property
    def view(self) -> View:
        """The view of the metric, which sees all round."""
        camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0.0, 0.0, FOV_DEG, SIZE_PX)
        return View(camera, metric_by_name(self.metric), self.detail, look_around=True)

    @property
    def limits(self) -> Reals:
        """The clamped limit distance of every part, (n,) [m]."""
        return self.view.limits(object_of(self.kind).hierarchy)[0]

    @property
    def fits(self) -> float:
        """The distance from which the object fits into the picture, whatever its pose [m]."""
        return float(object_of(self.kind).hierarchy.B[0] / self.view.camera.tan_half[1])

    def distances(self, count: int) -> Reals:
        """Return distances of the eye from the object's origin, in even ratios, (count,) [m]."""
        near = object_of(self.kind).hierarchy.B[0]
        return np.geomspace(near, self.limits[0], count + 1)[:-1]


@dataclass(frozen=True)
class Approach:
    """A curve that is counted, the number of its poses, and of its distances."""

    curve: Curve
    poses: int
    distances: int


@dataclass(frozen=True)
class Sizes:
    """A kind of object whose parts' sizes are listed."""

    kind: str


@dataclass(frozen=True)
class PosingTask:
    """What is posed, the number of poses in each repeat, and the number of repeats."""

    task: str
    poses: int
    repeats: int


def cases(effort: Effort, metric: str | None = None) -> list[Approach | Sizes | PosingTask]:
    """Return every curve, the sizes of all parts of every kind, and posing in two ways."""
    poses, distances = effort["poses"], effort["distances"]
    return [
        *(Approach(curve, poses, distances) for curve in curves(metric)),
        *(Sizes(kind) for kind in EVERYTHING),
        *(PosingTask(task, effort["posed"], effort["repeats"]) for task in POINTS_PER_JOINT),
    ]


def curves(more: str | None = None) -> tuple[Curve, ...]:
    """Return every kind with every metric, and the person with exaggerated detail."""
    metrics = (*METRICS, *([more] if more else []))
    usual = [Curve(kind, metric, DETAIL_PX) for kind in EVERYTHING for metric in metrics]
    return (*usual, *(Curve(PERSON, metric, EXAGGERATED_PX) for metric in metrics))


@lru_cache(maxsize=16)
def object_of(kind: str) -> RiggedPrototype:
    """Return the one object of a kind; the person is an adult."""
    return people_at_rest(0, 1, 0.0)[0] if kind == PERSON else animal(kind)


def looked_from(distances: Reals, poses: int) -> Distances:
    """Return where each pose is looked at from: a share of a step past each distance [m].

    The shares are multiples of the golden section, which fill a step evenly however many there are.
    """
    step = (distances[-1] / distances[0]) ** (1 / (len(distances) - 1))
    return distances[:, None] * step ** np.mod(_GOLDEN * np.arange(poses), 1.0)
