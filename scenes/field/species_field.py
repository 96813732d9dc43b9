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
from lod.pruning.parts import BlendWeights, Parts, Sticks
from lod.pruning.pruner import Cut
from lod.pruning.view import View, search_radius
from scenes.field.cell_search import cells_near_view, search
from scenes.field.habitat import Habitat
from scenes.field.poisson_cells import Draws, Near, PoissonCells
from scenes.field.posed_species import Objects, Troupe, troupe_of
from scenes.gait.patrol import PatrolOrbit, stride_factors
from scenes.rig.foot_placement import place_on_ground
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
    def troupe(self) -> Troupe:
        """The prototypes, ready to be handed out."""
        return troupe_of(self.species.prototypes)

    @cached_property
    def cells(self) -> PoissonCells:
        """The Poisson process."""
        return PoissonCells(self.seed, self.species.name, self.species.density)

    def objects(
        self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray, time_s: float = 0.0
    ) -> Objects:
        """All objects of the given cells with homes in the window, as they are at a time."""
        draws = self._grown(corner, self._drawn(cell_x, cell_y))
        return Objects(self._bodies(corner, draws, time_s, None), draws, np.zeros(len(draws)))

    def _drawn(self, cell_x: np.ndarray, cell_y: np.ndarray) -> Draws:
        draws = self.cells.draw(cell_x, cell_y)
        return draws if self.extent is None else draws.take(self._within_window(draws))

    def grown(self, corner: Corner, draws: Draws) -> np.ndarray:
        """Which of them have their home where the species grows: a matter of the place alone."""
        if self.species.habitat is None:
            return np.ones(len(draws), bool)
        share = self.species.habitat.share(corner, self.homes(corner, draws))
        return draws.u[:, 7] < share

    def _grown(self, corner: Corner, draws: Draws) -> Draws:
        """Those of them that grow."""
        return draws if self.species.habitat is None else draws.take(self.grown(corner, draws))

    def seen(self, draws: Draws, view: View) -> Objects:
        """These objects as a view has them."""
        corner = view.camera.corner
        # What does not move is the same in every frame, to the last bit.
        now = self._bodies(corner, draws, view.time_s if self.moves else 0.0, view)
        moves = self.moves and view.exposure is not None

        def bodies_at(time_s: float) -> Instances:
            return self._bodies(corner, draws, time_s, view) if moves else now

        return self.troupe.seen(draws, view, bodies_at)

    @property
    def moves(self) -> bool:
        """Whether any of it moves, by itself or as it walks."""
        return bool(self.species.patrol_m or self.troupe.moves)

    def roots(self, view: View) -> Parts:
        """The wholes of every cell from which one could be displayed."""
        draws = self._grown(view.camera.corner, self._drawn(*self._cells_near(view)))
        return self.troupe.wholes(self.seen(draws, view), view)

    def cut(self, view: View) -> Cut:
        """What is displayed, by compiled walks: of the objects, then of their parts."""
        corner, near = view.camera.corner, self.near(view)
        draws, examined = self.cells.near(*self._cells_near(view), corner, compile_view(view), near)
        return self.troupe.cut(self.seen(self._grown(corner, draws), view), view, examined)

    def near(self, view: View) -> Near:
        """Where wholes can be displayed at all, prototype by prototype."""
        atlas = self.troupe.atlas
        bound = atlas.bound[atlas.root]
        inside, outside = (limit[atlas.root] for limit in atlas.limits(view))
        pairs = zip(inside.tolist(), bound.tolist(), strict=True)
        farthest = np.array([search_radius(view, limit, radius) for limit, radius in pairs])
        lean, half = self.troupe.lean_m + self.species.patrol_m, self.extent
        window = math.inf if half is None else half / 2
        return Near(farthest, outside, bound, lean, *self._root_heights(), window)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        return self.troupe.parts_of(parts, view)

    def appearance(self, parts: Parts, look: BlendWeights) -> Sticks:
        """Sticks of the displayed parts, as much of both appearances as they show."""
        return self.troupe.appearance(parts, look)

    def later(self, parts: Parts, view: View, time_s: float) -> Parts:
        """The same parts as they look at another time."""
        if not self.moves:
            return parts
        instances = self._bodies(view.camera.corner, parts.state.draws, time_s, view)
        return replace(parts, state=replace(parts.state, instances=instances))

    def _bodies(self, corner: Corner, draws: Draws, time_s: float, view: View | None) -> Instances:
        """Where these objects are at a time, and how they stand, as closely as a view can tell."""
        home, (prototype, stride_factor, rounds) = self.homes(corner, draws), self.rounds(draws)
        walkers = rounds.at(time_s)
        heights = partial(self.ground.height, corner)
        facing = walkers.cos, walkers.sin
        pose_tables, xy = self.troupe.pose_tables, home + walkers.offset
        heed = None if view is None else self.troupe.heed(view, xy, prototype)
        return place_on_ground(
            pose_tables, heights, xy, *facing, prototype, walkers.phase, stride_factor, heed
        )

    def rounds(self, draws: Draws) -> tuple[Ints, Reals, PatrolOrbit]:
        """Prototype of each of these objects, its stride as a share of that one's, and how it goes
        round.
        """
        u = draws.u
        prototype = (u[:, 3] * len(self.species.prototypes)).astype(np.int64)
        motions = [prototype.motion for prototype in self.troupe.rigged]
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

    def homes(self, corner: Corner, draws: Draws) -> np.ndarray:
        """Where these objects are at home, (n, 2) [m] from the corner."""
        ix, iy, rest_x, rest_y = corner.lattice(self.cells.exponent)
        side = self.cells.side_m
        x = (draws.cell_x - ix) * side + draws.u[:, 0] * side - rest_x
        y = (draws.cell_y - iy) * side + draws.u[:, 1] * side - rest_y
        return np.stack((x, y), axis=1)

    def _within_window(self, draws: Draws) -> np.ndarray:
        """Membership depends on the object alone, never on the eye."""
        half, side = self.extent / 2, self.cells.side_m  # type: ignore[operator]
        x, y = (draws.cell_x + draws.u[:, 0]) * side, (draws.cell_y + draws.u[:, 1]) * side
        return (np.abs(x) <= half) & (np.abs(y) <= half)

    def _cells_near(self, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Cells near enough, in view or out of it, to hold a displayed whole."""
        return cells_near_view(view, self.search(view))

    def search(self, view: View) -> tuple[Any, Any, Any]:
        """What ``cells_near`` is asked with: spans, lattice and rules."""
        atlas = self.troupe.atlas
        inside, outside = (float(limit[atlas.root].max()) for limit in atlas.limits(view))
        bound = float(atlas.bound[atlas.root].max())
        lean = self.troupe.lean_m + self.species.patrol_m
        sizes = inside, outside, bound, lean
        return search(self.cells, self.extent, view, *sizes, *self._root_heights())

    def _root_heights(self) -> tuple[float, float]:
        """Lowest and highest that the origin of a whole can be [m]."""
        low, high = self.ground.bounds()
        atlas, sway = self.troupe.atlas, self.troupe.sway_m
        z = atlas.rest[atlas.root, 2]
        return low + float(z.min()) - sway, high + float(z.max()) + sway
