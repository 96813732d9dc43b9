"""A species: what grows or walks in a field, how densely, and where."""

import math
from dataclasses import dataclass, replace

from lod.errors import InputError
from lod.metric.family import Metric
from lod.pruning.view import View
from scenes.field.habitat import Habitat
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²].

    patrol_m  what has a stride walks circles of this radius about its home; 0 = it stays there
    habitat   where it grows, thinning the density; None = everywhere
    metric    which member of the family decides, in place of the view's; None = the view's

    Raises InputError for a density or a radius that cannot be, and where no prototype is given.
    """

    name: str
    prototypes: tuple[Prototype | RiggedPrototype, ...]
    density: float
    patrol_m: float = 0.0
    habitat: Habitat | None = None
    metric: Metric | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            where = f"species.{self.name}.density"
            raise InputError(where, self.density, "objects per m², finite and above 0")
        if not (math.isfinite(self.patrol_m) and self.patrol_m >= 0):
            raise InputError(f"species.{self.name}.patrol", self.patrol_m, "0 m or more, finite")
        if not self.prototypes:
            raise InputError(f"species.{self.name}.prototypes", 0, "at least one prototype")

    def seen_in(self, view: View) -> View:
        """Return the view with this species' own metric, where it has one.

        A view that displays everything, or measures depth along its axis, does so for all species.
        """
        if self.metric is None or view.metric.along_axis or not view.metric.finite:
            return view
        return replace(view, metric=self.metric)
