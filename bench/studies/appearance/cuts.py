"""One object displayed down to one level of detail, as it looks from one direction."""

import math
from dataclasses import dataclass, replace

import numpy as np

from bench.counting import FLAT
from bench.studies.appearance.cases import Case, prototype_of
from lod.arrays import Reals
from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import BlendWeights, Cut, prune
from lod.shapes import Appearance, Sticks, StickTable, Triangles, batches_of
from lod.view import View
from scenes.appearance.tone import Illumination
from scenes.field.species_field import Placed
from scenes.sticks.shapes import Shapes


@dataclass(frozen=True, eq=False)
class LoneObject:
    """An object alone on level ground, with all of its parts.

    placed  the object; every: the cut that displays all of it
    """

    placed: Placed
    every: Cut

    @property
    def finest(self) -> int:
        """Return the finest level of detail."""
        return int(self.every.level.max())

    @property
    def reach(self) -> float:
        """Return the radius about its foot that holds all of it [m]."""
        return float(self.placed.prototypes.part_tables.bound[0])

    def shown(
        self,
        level: int,
        sin_elevation: float,
        cos_azimuth: float = math.nan,
        light: Illumination | None = None,
    ) -> Appearance:
        """Return what is displayed while parts down to a level are, seen from one direction.

        cos_azimuth  of the angle between the lines to the eye and to the sun on the map
        light        that it is displayed in; None: shapes have their own albedo
        """
        parts = self.every.parts
        n, owns = len(parts), np.zeros(len(parts), np.bool_)
        owns[parts.parent[parts.parent >= 0]] = True
        inner = (parts.level < level) & owns
        leaf = (parts.level == level) | ((parts.level < level) & ~owns)
        weights = BlendWeights(
            inner.astype(np.float64),
            leaf.astype(np.float64),
            np.full(n, sin_elevation),
            np.full(n, cos_azimuth),
        )
        return self.placed.prototypes.appearance(parts, weights, light)


def lone_object(case: Case) -> LoneObject:
    """Make the object of a case, and display all of it."""
    placed = Placed(case.kind, prototype_of(case), 0.0, 0.0, 90.0, FLAT)
    away = np.array((0.0, -30.0, 2.0))
    camera = camera_from_heading(Corner(0, 0), away, 0.0, 0.0, 60.0, (64, 64))
    view = View(camera, METRICS["full"], look_around=True)
    return LoneObject(placed, prune(placed, replace(view, fade=0.0)))


def shapes_of(shown: Appearance) -> Shapes:
    """Return what is displayed as sticks of a single part, and triangles."""
    sticks, corners, colours = [], [np.zeros((0, 3, 3))], [np.zeros((0, 3))]
    for each in batches_of(shown):
        if isinstance(each, Sticks):
            columns = each.start, each.end, each.start_radius, each.end_radius, each.tint
            sticks.append(StickTable(np.array((0, len(each))), *columns))
        elif isinstance(each, Triangles):
            corners.append(each.vertices[each.faces])
            colours.append(each.colours[each.faces].mean(axis=1))
    flat = np.concatenate(corners), np.concatenate(colours)
    return Shapes(StickTable.as_one_part(sticks), *flat)


def unit(azimuth_deg: Reals | float, elevation_deg: Reals | float) -> np.ndarray:
    """Compute unit vectors of azimuths from the x axis and of elevations, (…, 3)."""
    a, e = np.radians(azimuth_deg), np.radians(elevation_deg)
    a, e = np.broadcast_arrays(a, e)
    return np.stack((np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)), axis=-1)
