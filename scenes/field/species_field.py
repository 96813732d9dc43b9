"""The endless field: one species spread over the plane, handed to the pruner as parts (§4.1).

No list of objects exists anywhere. A frame visits only the cells from which a part could pass.
"""

import math
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from lod.arrays import Ints, Reals
from lod.camera import Corner
from lod.errors import InputError
from lod.pruning.compiled_test import compile_view
from lod.pruning.parts import BlendWeights, Parts
from lod.pruning.pruner import Cut
from lod.pruning.shapes import Sticks
from lod.pruning.view import View
from lod.pruning.view_geometry import search_radius
from scenes.field.cell_search import cells_near_view, search
from scenes.field.habitat import Habitat
from scenes.field.poisson_cells import CellSamples, PoissonCells, SearchBounds
from scenes.field.posed_species import InstancesInView, SpeciesPrototypes, species_prototypes
from scenes.gait.patrol import PatrolOrbit, stride_factors
from scenes.rig.foot_placement import SOLE, Placements, place_on_ground
from scenes.rig.pose_tables import Instances
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.prototype import Prototype
from scenes.terrain.ground import Ground


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²].

    patrol_m: what has a stride walks circles of this radius about its home; 0 = stays there
    habitat: where it grows, thinning the density; None = everywhere
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


@dataclass(frozen=True, eq=False)
class SpeciesField:
    """A Representation: one species on the ground, endless or within a window.

    extent: side L of a square window about the plane's origin [m]; None = no edge. What has its
    home in the window is there.
    """

    species: Species
    seed: int
    ground: Ground
    extent: float | None = None

    @property
    def name(self) -> str:
        """The species' name."""
        return self.species.name

    @cached_property
    def prototypes(self) -> SpeciesPrototypes:
        """The prototypes, ready to be handed out."""
        return species_prototypes(self.species.prototypes)

    @cached_property
    def cells(self) -> PoissonCells:
        """The Poisson process."""
        return PoissonCells(self.seed, self.species.name, self.species.density)

    def instances_in_cells(
        self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray, time_s: float = 0.0
    ) -> InstancesInView:
        """All objects of the given cells with homes in the window, as they are at a time."""
        samples = self._grown(corner, self._drawn(cell_x, cell_y))
        return InstancesInView(
            self._bodies(corner, samples, time_s, None), samples, np.zeros(len(samples))
        )

    def _drawn(self, cell_x: np.ndarray, cell_y: np.ndarray) -> CellSamples:
        samples = self.cells.draw(cell_x, cell_y)
        return samples if self.extent is None else samples.take(self._within_window(samples))

    def habitat_mask(self, corner: Corner, samples: CellSamples) -> np.ndarray:
        """Which of them have their home where the species grows: a matter of the place alone."""
        if self.species.habitat is None:
            return np.ones(len(samples), bool)
        share = self.species.habitat.share(corner, self.homes(corner, samples))
        return samples.u[:, 7] < share

    def _grown(self, corner: Corner, samples: CellSamples) -> CellSamples:
        """Those of them that grow."""
        return (
            samples
            if self.species.habitat is None
            else samples.take(self.habitat_mask(corner, samples))
        )

    def instances_in_view(self, samples: CellSamples, view: View) -> InstancesInView:
        """These objects as a view has them."""
        corner = view.camera.corner
        # What does not move is the same in every frame, to the last bit.
        now = self._bodies(corner, samples, view.time_s if self.moves else 0.0, view)
        moves = self.moves and view.shutter is not None

        def bodies_at(time_s: float) -> Instances:
            return self._bodies(corner, samples, time_s, view) if moves else now

        return self.prototypes.seen(samples, view, bodies_at)

    @property
    def moves(self) -> bool:
        """Whether any of it moves, by itself or as it walks."""
        return bool(self.species.patrol_m or self.prototypes.moves)

    def roots(self, view: View) -> Parts:
        """The wholes of every cell from which one could be displayed."""
        samples = self._grown(view.camera.corner, self._drawn(*self.cells_in_range(view)))
        return self.prototypes.wholes(self.instances_in_view(samples, view), view)

    def cut(self, view: View) -> Cut:
        """What is displayed, by compiled walks: of the objects, then of their parts."""
        corner, near = view.camera.corner, self.search_bounds(view)
        samples, examined = self.cells.candidates(
            *self.cells_in_range(view), corner, compile_view(view), near
        )
        return self.prototypes.cut(
            self.instances_in_view(self._grown(corner, samples), view), view, examined
        )

    def search_bounds(self, view: View) -> SearchBounds:
        """Where wholes can be displayed at all, prototype by prototype."""
        part_tables = self.prototypes.part_tables
        bound = part_tables.bound[part_tables.root]
        inside, outside = (limit[part_tables.root] for limit in part_tables.limits(view))
        pairs = zip(inside.tolist(), bound.tolist(), strict=True)
        farthest = np.array([search_radius(view, limit, radius) for limit, radius in pairs])
        lean, half = self.prototypes.max_offset_m + self.species.patrol_m, self.extent
        window = math.inf if half is None else half / 2
        return SearchBounds(farthest, outside, bound, lean, *self._root_heights(), window)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        return self.prototypes.parts_of(parts, view)

    def appearance(self, parts: Parts, weights: BlendWeights) -> Sticks:
        """Sticks of the displayed parts, as much of both appearances as they show."""
        return self.prototypes.appearance(parts, weights)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """The same parts as they look at another time."""
        if not self.moves:
            return parts
        instances = self._bodies(view.camera.corner, parts.state.samples, time_s, view)
        return replace(parts, state=replace(parts.state, instances=instances))

    def _bodies(
        self, corner: Corner, samples: CellSamples, time_s: float, view: View | None
    ) -> Instances:
        """Where these objects are at a time, and how they stand, as closely as a view can tell."""
        home, (prototype, stride_factor, rounds) = (
            self.homes(corner, samples),
            self.patrol_orbits(samples),
        )
        walkers = rounds.at(time_s)
        heights = partial(self.ground.height, corner)
        facing = walkers.cos, walkers.sin
        pose_tables, xy = self.prototypes.pose_tables, home + walkers.offset
        level = SOLE if view is None else self.prototypes.heed(view, xy, prototype)
        where = Placements(xy, *facing, prototype, walkers.phase, stride_factor, level)
        return place_on_ground(pose_tables, heights, where)

    def patrol_orbits(self, samples: CellSamples) -> tuple[Ints, Reals, PatrolOrbit]:
        """Prototype of each of these objects, its stride as a share of that one's, and how it goes
        round.
        """
        u = samples.u
        prototype = (u[:, 3] * len(self.species.prototypes)).astype(np.int64)
        motions = [prototype.motion for prototype in self.prototypes.rigged]
        stride, period = (np.array([getattr(m, k) for m in motions]) for k in ("stride", "period"))
        stride_factor, tempo = stride_factors(u[:, 6])
        rounds = PatrolOrbit(
            self.species.patrol_m or 1.0,  # what has no patrol has no stride either
            2 * np.pi * u[:, 2],
            u[:, 5] < 0.5,
            u[:, 4],
            stride[prototype] * stride_factor * (self.species.patrol_m > 0),
            period[prototype] * np.where(stride[prototype] > 0, tempo, 1.0),
        )
        return prototype, stride_factor, rounds

    def homes(self, corner: Corner, samples: CellSamples) -> np.ndarray:
        """Where these objects are at home, (n, 2) [m] from the corner."""
        ix, iy, rest_x, rest_y = corner.lattice(self.cells.exponent)
        side = self.cells.side_m
        x = (samples.cell_x - ix) * side + samples.u[:, 0] * side - rest_x
        y = (samples.cell_y - iy) * side + samples.u[:, 1] * side - rest_y
        return np.stack((x, y), axis=1)

    def _within_window(self, samples: CellSamples) -> np.ndarray:
        """Membership depends on the object alone, never on the eye."""
        half, side = self.extent / 2, self.cells.side_m  # type: ignore[operator]
        x, y = (samples.cell_x + samples.u[:, 0]) * side, (samples.cell_y + samples.u[:, 1]) * side
        return (np.abs(x) <= half) & (np.abs(y) <= half)

    def cells_in_range(self, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Cells near enough, in view or out of it, to hold a displayed whole."""
        return cells_near_view(view, self.search(view))

    def search(self, view: View) -> tuple[Any, Any, Any]:
        """What ``cells_near`` is asked with: spans, lattice and rules."""
        part_tables = self.prototypes.part_tables
        inside, outside = (
            float(limit[part_tables.root].max()) for limit in part_tables.limits(view)
        )
        bound = float(part_tables.bound[part_tables.root].max())
        lean = self.prototypes.max_offset_m + self.species.patrol_m
        sizes = inside, outside, bound, lean
        return search(self.cells, self.extent, view, *sizes, *self._root_heights())

    def _root_heights(self) -> tuple[float, float]:
        """Lowest and highest that the origin of a whole can be [m]."""
        low, high = self.ground.bounds()
        part_tables, sway = self.prototypes.part_tables, self.prototypes.max_sway_m
        z = part_tables.rest[part_tables.root, 2]
        return low + float(z.min()) - sway, high + float(z.max()) + sway
