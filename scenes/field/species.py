"""A species: what grows or walks in a field, how densely, and where."""

import math
from dataclasses import dataclass

from lod.errors import InputError
from scenes.field.habitat import Habitat
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²].

    patrol_m  what has a stride walks circles of this radius about its home; 0 = it stays there
    habitat   where it grows, thinning the density; None = everywhere

    Raises InputError for a density or a radius that cannot be, and where no prototype is given.
    """

    name: str
    prototypes: tuple[Prototype | RiggedPrototype, ...]
    density: float
    patrol_m: float = 0.0
    habitat: Habitat | None = None

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            where = f"species.{self.name}.density"
            raise InputError(where, self.density, "objects per m², finite and above 0")
        if not (math.isfinite(self.patrol_m) and self.patrol_m >= 0):
            raise InputError(f"species.{self.name}.patrol", self.patrol_m, "0 m or more, finite")
        if not self.prototypes:
            raise InputError(f"species.{self.name}.prototypes", 0, "at least one prototype")
