"""Objects put where a preset says, one by one: the few that a picture is about."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from lod.camera import GRID_M
from lod.parts import Look, Parts, Sticks
from lod.view import View
from scenes.field import Ground, footing
from scenes.prototype import Prototype
from scenes.rig_cast import Bodies
from scenes.rig_prototype import RiggedPrototype
from scenes.troupe import Objects, Troupe, troupe_of


@dataclass(frozen=True, eq=False)
class Placed:
    """A Representation: one object at (x, y) metres from the plane's origin, facing a heading.

    heading_deg: clockwise from north; period of its motion as the prototype's, from phase 0
    """

    name: str
    prototype: Prototype | RiggedPrototype
    x: float
    y: float
    heading_deg: float
    ground: Ground

    @cached_property
    def troupe(self) -> Troupe:
        """Its parts and looks."""
        return troupe_of((self.prototype,))

    def roots(self, view: View) -> Parts:
        """The object itself, whether near or far."""
        corner = view.camera.corner
        xy = np.array([[self.x - corner.x * GRID_M, self.y - corner.y * GRID_M]])
        facing = math.radians(90.0 - self.heading_deg)
        height, slope = self.ground.height(corner, xy), np.zeros((1, 2))
        if self.troupe.has_legs:
            height, slope = footing(self.ground, corner, xy, self.troupe.stance_m)
        bodies = Bodies(
            origin=np.column_stack((xy, height)),
            cos=np.array([math.cos(facing)]),
            sin=np.array([math.sin(facing)]),
            variant=np.zeros(1, np.int64),
            phase=np.array([view.time_s / self.troupe.rigged[0].motion.period]),
            gradient=slope,
        )
        return self.troupe.wholes(Objects(bodies, None), view)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        return self.troupe.parts_of(parts, view)

    def appearance(self, parts: Parts, look: Look) -> Sticks:
        """Sticks of the displayed parts."""
        return self.troupe.appearance(parts, look)
