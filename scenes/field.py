"""The endless field: one species spread over the plane, handed to the pruner as parts (§4.1).

No list of objects exists anywhere. A frame visits only the cells from which a part could pass.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, runtime_checkable

import numpy as np

from lod.arrays import freeze
from lod.camera import Corner
from lod.errors import InputError
from lod.parts import Parts, Sticks
from lod.view import View, in_view, reach
from scenes.atlas import Atlas
from scenes.cells import Draws, PoissonCells
from scenes.prototype import Prototype


@runtime_checkable
class Ground(Protocol):
    """What the field stands on."""

    def height(self, corner: Corner, xy: np.ndarray) -> np.ndarray:
        """Height of the ground [m] at points (n, 2) [m] from the corner, (n,)."""

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest that the ground can be anywhere [m]."""


@dataclass(frozen=True, eq=False)
class Species:
    """Objects of a kind: equally likely prototypes, spread with density K [1/m²]."""

    name: str
    prototypes: tuple[Prototype, ...]
    density: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.density) and self.density > 0):
            where = f"species.{self.name}.density"
            raise InputError(where, self.density, "objects per m², finite and above 0")
        if not self.prototypes:
            raise InputError(f"species.{self.name}.prototypes", 0, "at least one prototype")


@dataclass(frozen=True, eq=False)
class Objects:
    """The objects of one frame that were examined.

    origin (n, 3) where each stands, in the frame's coordinates [m]; cos, sin (n,) of its heading
    variant (n,) its prototype; draws: its identity in the endless field
    """

    origin: np.ndarray
    cos: np.ndarray
    sin: np.ndarray
    variant: np.ndarray
    draws: Draws

    def __post_init__(self) -> None:
        freeze(self, origin=np.float64, cos=np.float64, sin=np.float64, variant=np.int64)

    def __len__(self) -> int:
        return len(self.variant)

    def place(self, rows: np.ndarray, points: np.ndarray) -> np.ndarray:
        """Points of the objects' own frames, (n, 3), as they stand in the frame, (n, 3) [m]."""
        c, s, origin = self.cos[rows], self.sin[rows], self.origin[rows]
        x = origin[:, 0] + c * points[:, 0] - s * points[:, 1]
        y = origin[:, 1] + s * points[:, 0] + c * points[:, 1]
        return np.stack((x, y, origin[:, 2] + points[:, 2]), axis=1)


@dataclass(frozen=True, eq=False)
class SpeciesField:
    """A Representation: one species on the ground, endless or within a window.

    extent: side L of a square window about the plane's origin [m]; None = no edge.
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
    def atlas(self) -> Atlas:
        """All prototypes in one set of arrays."""
        return Atlas.of(self.species.prototypes)

    @cached_property
    def cells(self) -> PoissonCells:
        """The Poisson process."""
        return PoissonCells(self.seed, self.species.name, self.species.density)

    def objects(self, corner: Corner, cell_x: np.ndarray, cell_y: np.ndarray) -> Objects:
        """All objects of the given cells that lie in the window."""
        draws = self.cells.draw(cell_x, cell_y)
        if self.extent is not None:
            draws = draws.take(self._within_window(draws))
        ix, iy, rest_x, rest_y = corner.lattice(self.cells.exponent)
        side = self.cells.side_m
        x = (draws.cell_x - ix) * side + draws.u[:, 0] * side - rest_x
        y = (draws.cell_y - iy) * side + draws.u[:, 1] * side - rest_y
        z = self.ground.height(corner, np.stack((x, y), axis=1))
        turn = 2 * np.pi * draws.u[:, 2]
        variant = (draws.u[:, 3] * len(self.species.prototypes)).astype(np.int64)
        return Objects(np.stack((x, y, z), axis=1), np.cos(turn), np.sin(turn), variant, draws)

    def roots(self, view: View) -> Parts:
        """The wholes of every cell from which one could be displayed."""
        objects = self.objects(view.camera.corner, *self._cells_near(view))
        part = self.atlas.root[objects.variant]
        rows = np.arange(len(objects))
        return self._parts(objects, rows, part, np.full(len(rows), -1), view)

    def parts_of(self, parts: Parts, view: View) -> Parts:
        """The parts that ``parts`` own directly."""
        whole, part = self.atlas.parts_of(parts.part)
        return self._parts(parts.state, parts.object[whole], part, whole, view)

    def appearance(self, parts: Parts, is_leaf: np.ndarray) -> Sticks:
        """Sticks of the displayed parts, as inner nodes or in their leaf appearance."""
        table, owner, stick = self.atlas.sticks_of(parts.part, is_leaf)
        rows = parts.object[owner]
        return Sticks(
            start=parts.state.place(rows, table.start[stick]),
            end=parts.state.place(rows, table.end[stick]),
            start_radius=table.start_radius[stick],
            end_radius=table.end_radius[stick],
            tint=table.tint[stick],
            tints=self.atlas.tints,
            owner=owner,
        )

    def _parts(
        self, objects: Objects, rows: np.ndarray, part: np.ndarray, whole: np.ndarray, view: View
    ) -> Parts:
        position = objects.place(rows, self.atlas.position[part])
        limit, limit_offscreen = self.atlas.limits(view)
        return Parts(
            position=position,
            centre=position,
            bound=self.atlas.bound[part],
            limit=limit[part],
            limit_offscreen=limit_offscreen[part],
            level=self.atlas.level[part],
            object=rows,
            part=part,
            whole=whole,
            state=objects,
        )

    def _within_window(self, draws: Draws) -> np.ndarray:
        """Membership depends on the object alone, never on the eye."""
        half, side = self.extent / 2, self.cells.side_m  # type: ignore[operator]
        x, y = (draws.cell_x + draws.u[:, 0]) * side, (draws.cell_y + draws.u[:, 1]) * side
        return (np.abs(x) <= half) & (np.abs(y) <= half)

    def _cells_near(self, view: View) -> tuple[np.ndarray, np.ndarray]:
        """Cells near enough, and near enough for being in view or not, to hold a displayed whole."""
        inside, outside = (limit[self.atlas.root].max() for limit in self.atlas.limits(view))
        bound = float(self.atlas.bound[self.atlas.root].max())
        inside = reach(view, float(inside), bound)
        lean = float(np.hypot(*self.atlas.position[self.atlas.root, :2].T).max())
        low, high = self._root_heights()
        eye = view.camera.eye
        above = max(0.0, eye[2] - high, low - eye[2])
        in_plan = math.sqrt(max(inside**2 - above**2, 0.0)) + lean
        x, y = self._cells_within(view.camera.corner, eye, in_plan)
        if len(x) == 0 or view.look_around:
            return x, y
        centre, near = self._cell_places(view.camera.corner, eye, x, y)
        centre[:, 2] = (low + high) / 2
        radius = self.cells.side_m / math.sqrt(2) + (high - low) / 2 + lean
        seen = in_view(view, centre, np.full(len(x), radius + bound))
        far = np.hypot(np.maximum(near - lean, 0.0), above)
        return tuple(a[far <= np.where(seen, inside, outside)] for a in (x, y))

    def _root_heights(self) -> tuple[float, float]:
        """Lowest and highest that the origin of a whole can be [m]."""
        low, high = self.ground.bounds()
        z = self.atlas.position[self.atlas.root, 2]
        return low + float(z.min()), high + float(z.max())

    def _cells_within(
        self, corner: Corner, eye: np.ndarray, reach: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Cells of which some point is within ``reach`` of the eye in plan, and in the window."""
        ix, iy, rest_x, rest_y = corner.lattice(self.cells.exponent)
        side = self.cells.side_m
        x_range = _span(ix, (eye[0] + rest_x) / side, reach / side, self._window_cells())
        y_range = _span(iy, (eye[1] + rest_y) / side, reach / side, self._window_cells())
        x, y = (a.ravel() for a in np.meshgrid(np.arange(*x_range), np.arange(*y_range)))
        _, near = self._cell_places(corner, eye, x, y)
        keep = near <= reach
        return x[keep], y[keep]

    def _cell_places(
        self, corner: Corner, eye: np.ndarray, x: np.ndarray, y: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Centres of cells, (n, 3) with z = 0, and the distance in plan to their nearest point."""
        ix, iy, rest_x, rest_y = corner.lattice(self.cells.exponent)
        side = self.cells.side_m
        centre = np.zeros((len(x), 3))
        centre[:, 0] = (x - ix + 0.5) * side - rest_x
        centre[:, 1] = (y - iy + 0.5) * side - rest_y
        aside = np.maximum(np.abs(centre[:, :2] - eye[:2]) - side / 2, 0.0)
        return centre, np.hypot(aside[:, 0], aside[:, 1])

    def _window_cells(self) -> float:
        """Half the window in cells; infinite where there is no edge."""
        return math.inf if self.extent is None else self.extent / 2 / self.cells.side_m


def _span(first: int, eye: float, reach: float, half_window: float) -> tuple[int, int]:
    """Range of cell numbers within ``reach`` cells of the eye, cut to the window."""
    if math.isinf(reach) and math.isinf(half_window):
        raise InputError(
            "world.extent", None, "this metric needs a finite world", "-D world.extent=500"
        )
    lows, highs = [], []
    if math.isfinite(half_window):
        lows.append(math.floor(-half_window))
        highs.append(math.floor(half_window))
    if math.isfinite(reach):
        lows.append(first + math.floor(eye - reach))
        highs.append(first + math.floor(eye + reach))
    low, high = max(lows), min(highs)
    return (low, high + 1) if low <= high else (0, 0)
