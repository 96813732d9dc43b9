"""Objects put where a preset says, one by one: the few that a picture is about."""

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from lod.camera import GRID_M, Corner
from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import Cut
from lod.pruning.shapes import Appearance
from lod.pruning.view import View
from scenes.field.posed_species import (
    InstancesInView,
    SpeciesPrototypes,
    instances_in_view,
    shutter_times,
    species_prototypes,
)
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose_tables import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.appearance.tone import Illumination
from scenes.sticks.prototype import Prototype
from scenes.terrain.ground import Ground


@dataclass(frozen=True, eq=False)
class Placed:
    """A Representation: one object at (x, y) metres from the plane's origin, facing a heading.

    heading_deg: clockwise from north; period of its motion as the prototype's, from phase 0;
    illumination as in SpeciesField
    """

    name: str
    prototype: Prototype | RiggedPrototype
    x: float
    y: float
    heading_deg: float
    ground: Ground
    illumination: Illumination | None = None

    @cached_property
    def prototypes(self) -> SpeciesPrototypes:
        """Return its prototype with its tables."""
        return species_prototypes((self.prototype,))

    def roots(self, view: View) -> Parts:
        """Return the object itself, whether near or far."""
        return self.prototypes.wholes(self._instances_in_view(view), view)

    def cut(self, view: View) -> Cut:
        """Find what of it is displayed, by the compiled traversal."""
        return self.prototypes.cut(self._instances_in_view(view), view, 1)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the parts that ``parts`` own directly."""
        return self.prototypes.parts_of(parts, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Appearance:
        """Return the appearance of the displayed parts."""
        return self.prototypes.appearance(parts, weights, self.illumination)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Pose the parts as they are at another time [s]."""
        if not self.prototypes.moves:
            return parts
        instances = self._place(view.camera.corner, time_s)
        return replace(parts, state=replace(parts.state, instances=instances))

    def _instances_in_view(self, view: View) -> InstancesInView:
        placed = [self._place(view.camera.corner, time_s) for time_s in shutter_times(view)]
        return instances_in_view(self.prototypes, None, view, placed)

    def _place(self, corner: Corner, time_s: float) -> Instances:
        """The object as it stands at a time [s]."""
        xy = np.array([[self.x - corner.x * GRID_M, self.y - corner.y * GRID_M]])
        facing = math.radians(90.0 - self.heading_deg)
        return place_on_ground(
            self.prototypes.pose_tables,
            partial(self.ground.height, corner),
            Placements(
                xy,
                cos=np.array([math.cos(facing)]),
                sin=np.array([math.sin(facing)]),
                prototype=np.zeros(1, np.int64),
                phase=np.array([time_s / self.prototypes.rigged[0].motion.period]),
                stride_factor=np.ones(1),
            ),
        )
