"""The endless field: one species spread over the plane, handed to the pruner as parts (§4.1).

No list of objects exists anywhere. A frame visits only the cells from which a part could pass.

Objects put where a preset says, one by one: the few that a picture is about.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np
from jaxtyping import Float64

from lod.camera import GRID_M, Corner
from lod.pruner import BlendWeights, Cut, Parts
from lod.shapes import Appearance
from lod.view import View
from scenes.appearance.tone import Illumination
from scenes.field.cells import (
    CellSamples,
    PoissonCells,
    SearchBounds,
    candidates,
    cells_in_reach,
    search_bounds,
)
from scenes.field.placement import Species, place_instances
from scenes.field.prototypes import (
    InstancesInView,
    SpeciesPrototypes,
    instances_in_view,
    shutter_times,
    species_prototypes,
)
from scenes.ground.relief import Ground
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype


@dataclass(frozen=True, eq=False)
class SpeciesField:
    """A Representation: one species on the ground, endless or within a window.

    extent: side L of a square window about the plane's origin [m]; None = no edge. What has its
    home in the window is there.
    illumination: light that leaf appearances have the tone for; None = they have their own albedo.
    """

    species: Species
    seed: int
    ground: Ground
    extent: float | None = None
    illumination: Illumination | None = None

    @property
    def name(self) -> str:
        """Return the species' name."""
        return self.species.name

    @cached_property
    def prototypes(self) -> SpeciesPrototypes:
        """Return the prototypes with their tables."""
        return species_prototypes(self.species.prototypes)

    @cached_property
    def cells(self) -> PoissonCells:
        """Return the Poisson process."""
        return PoissonCells(self.seed, self.species.name, self.species.density)

    @property
    def moves(self) -> bool:
        """Tell whether any of it moves, by itself or as it walks."""
        return bool(self.species.patrol_m or self.prototypes.moves)

    def roots(self, view: View) -> Parts:
        """Find the wholes of every cell from which one could be displayed."""
        view = self.species.seen_in(view)
        cells = cells_in_reach(self.cells, view, self.search_bounds(view))
        samples = self.sample_cells(view.camera.corner, *cells)
        return self.prototypes.wholes(self.instances_in_view(samples, view), view)

    def cut(self, view: View) -> Cut:
        """Find what is displayed, by compiled loops: over the objects, then over their parts."""
        view = self.species.seen_in(view)
        samples, examined = candidates(self.cells, view, self.search_bounds(view))
        grown = self.in_habitat(view.camera.corner, samples)
        return self.prototypes.cut(self.instances_in_view(grown, view), view, examined)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """Return the parts that ``parts`` own directly."""
        return self.prototypes.parts_of(parts, self.species.seen_in(view))

    def appearance(self, parts: Parts, weights: BlendWeights) -> Appearance:
        """Return the appearance of the displayed parts, as much of both as they show."""
        return self.prototypes.appearance(parts, weights, self.illumination)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """Return the same parts, posed as they are at another time [s]."""
        if not self.moves:
            return parts
        instances = self._place(view.camera.corner, parts.state.samples, time_s, view)
        return replace(parts, state=replace(parts.state, instances=instances))

    def search_bounds(self, view: View) -> SearchBounds:
        """Find where wholes can be displayed at all, prototype by prototype."""
        view = self.species.seen_in(view)
        tables, sway = self.prototypes.part_tables, self.prototypes.max_sway_m
        inside, outside = (limit[tables.root] for limit in tables.limits(view))
        offset = self.prototypes.max_offset_m + self.species.patrol_m
        (low, high), (lowest, highest) = self.ground.bounds(), self.prototypes.root_heights
        heights, bound = (low + lowest - sway, high + highest + sway), tables.bound[tables.root]
        return search_bounds(view, (inside, outside), bound, offset, heights, self.extent)

    def instances_in_cells(
        self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray, time_s: float = 0.0
    ) -> InstancesInView:
        """Pose all objects of the given cells with homes in the window, at a time [s]."""
        samples = self.sample_cells(corner, cell_x, cell_y)
        instances = self._place(corner, samples, time_s, None)
        return InstancesInView(instances, samples, np.zeros(len(samples)))

    def sample_cells(self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        """Draw the objects of cells that have their homes in the window and grow there."""
        samples = self.cells.sample(cell_x, cell_y)
        if self.extent is not None:
            samples = samples.take(self.cells.in_window(samples, self.extent / 2))
        return self.in_habitat(corner, samples)

    def in_habitat(self, corner: Corner, samples: CellSamples) -> CellSamples:
        """Return those objects that have their home where the species grows."""
        if self.species.habitat is None:
            return samples
        share = self.species.habitat.share(corner, self.homes(corner, samples))
        return samples.take(samples.u[:, 7] < share)

    def homes(self, corner: Corner, samples: CellSamples) -> Float64[np.ndarray, "n 2"]:
        """Find where objects are at home, (n, 2) [m] from the corner."""
        return self.cells.positions(corner, samples)

    def instances_in_view(self, samples: CellSamples, view: View) -> InstancesInView:
        """Return these objects as a view has them, and how much motion hides of each."""
        times, corner = shutter_times(view), view.camera.corner
        if self.moves:
            placed = [self._place(corner, samples, time_s, view) for time_s in times]
        else:  # the same in every frame, to the last bit
            placed = [self._place(corner, samples, 0.0, view)] * len(times)
        return instances_in_view(self.prototypes, samples, view, placed)

    def _place(
        self, corner: Corner, samples: CellSamples, time_s: float, view: View | None
    ) -> Instances:
        heights, homes = partial(self.ground.height, corner), self.homes(corner, samples)
        species, prototypes = self.species, self.prototypes
        return place_instances(species, prototypes, heights, homes, samples, time_s, view)


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
