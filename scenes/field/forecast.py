"""How many objects, parts and sticks of a species a view will display, before it is pruned.

The law's integral of what an object displays over the ground (``lod.law``) is taken
by pruning the objects of a few cells: one at each node of a polar net, which is dense where the
camera looks. Its cost does not depend on how much there is to display.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.pruner import Cut
from lod.view import View, compile_view
from scenes.field.cells import cell_in_reach, cell_reach, search_spans
from scenes.field.emission import triangles_of
from scenes.field.part_tables import PartTables
from scenes.field.species_field import SpeciesField

_RINGS, _SPOKES = 32, 24
"""Nodes of the net; a third of its spokes stand where the camera does not look."""

_FADING = 1.1
"""Sticks drawn for each that is foretold: appearances that fade into one another are both drawn."""

_INNER_M = 0.5
"""Radius of the one disc about the eye that is not divided further."""

_FARTHEST_M = 1e15
"""No search goes farther: cells there are as fine as their numbers can say."""


@dataclass(frozen=True)
class FieldForecast:
    """Expected numbers of what a view visits and displays of a species.

    cells    visited; objects: those in them, wherever they can grow
    parts    displayed; sticks, triangles: those of the appearances that the parts show
    """

    cells: float
    objects: float
    parts: float
    sticks: float
    triangles: float


def forecast_field(field: SpeciesField, view: View) -> FieldForecast:
    """Foretell what a view displays of a species, within some 20 % where that is much.

    Raises InputError where nothing bounds the search.
    """
    view = field.species.seen_in(view)
    xy, area = _net(field, view)
    cells, lattice = field.cells, field.cells.lattice(view.camera.corner)
    reach = cell_reach(view, field.search_bounds(view), cells.side_m)
    corner = np.array([lattice.rest_x, lattice.rest_y])
    steps = np.floor((xy + corner) / cells.side_m)
    middle = (steps + 0.5) * cells.side_m - corner
    near = _in_reach(middle, cells.side_m, compile_view(view), reach)
    share = area[near] / cells.side_m**2  # of a cell, or how many, for which a node stands
    first = np.array([lattice.cell_x, lattice.cell_y])
    number = steps[near].astype(np.int64) + first
    cell, node = np.unique(number[:, 0] + 1j * number[:, 1], return_inverse=True)
    weight = np.bincount(node, share, minlength=len(cell))
    x, y = cell.real.astype(np.int64), cell.imag.astype(np.int64)
    samples = field.sample_cells(view.camera.corner, x, y)
    count = len(samples)
    cut = field.prototypes.cut(field.instances_in_view(samples, view), view, count)
    of_object = weight[np.searchsorted(cell, samples.cell_x + 1j * samples.cell_y)]
    of_part = of_object[cut.object]
    tables = field.prototypes.part_tables
    sticks = float(of_part @ sticks_shown(cut, tables)) * _FADING
    triangles = float(of_part @ triangles_of(tables.meshes, cut.part.astype(np.int64)))
    visited = float(weight.sum())
    objects = visited * cells.density * cells.side_m**2
    return FieldForecast(visited, objects, float(of_part.sum()), sticks, triangles)


def sticks_shown(cut: Cut, tables: PartTables) -> Float64[np.ndarray, " n"]:
    """Sticks of each displayed part, (n,): of its leaf appearance where none of its own parts is
    displayed, and of its inner one elsewhere.
    """
    is_leaf = np.bincount(cut.parent[cut.parent >= 0], minlength=len(cut)) == 0
    block = 2 * cut.part.astype(np.int64) + is_leaf
    first = tables.sticks.first
    return (first[block + 1] - first[block]).astype(np.float64)


def _net(field: SpeciesField, view: View) -> tuple[np.ndarray, np.ndarray]:
    """Nodes (n, 2) [m] from the corner, and the area that each stands for (n,) [m²]."""
    bounds, cells = field.search_bounds(view), field.cells
    x0, x1, y0, y1 = search_spans(cells, view, bounds)
    reach = min(cell_reach(view, bounds, cells.side_m).horizontal, _FARTHEST_M)
    if field.extent is not None:
        lattice, eye = cells.lattice(view.camera.corner), view.camera.eye[:2]
        first = np.array([lattice.cell_x, lattice.cell_y], np.float64)
        low, high = ((np.array(n) - first) * cells.side_m for n in ((x0, y0), (x1, y1)))
        if ((eye < low) | (eye > high)).any():
            return _grid(low, high)
        reach = min(reach, float(np.hypot(*np.maximum(eye - low, high - eye))))
    widest = float(bounds.bound.max()) + bounds.max_offset + cells.side_m
    return _polar(view, reach, widest)


def _grid(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """An even net over a window that the eye is outside of."""
    n = _RINGS * _SPOKES
    u = np.indices((_RINGS, _SPOKES)) + _chance().random((2, _RINGS, _SPOKES))
    size = np.maximum(high - low, 0.0)
    xy = low + u.reshape(2, -1).T / (_RINGS, _SPOKES) * size
    return xy, np.full(n, size[0] * size[1] / n)


def _polar(view: View, reach: float, widest: float) -> tuple[np.ndarray, np.ndarray]:
    """A net about the eye: most spokes within what the camera may see, the others beyond."""
    chance = _chance()
    edges = np.concatenate(([0.0], np.geomspace(_INNER_M, max(reach, 2 * _INNER_M), _RINGS)))
    inner, outer = edges[:-1, None], edges[1:, None]
    half = _half_angle(view, widest, outer)
    spoke, ahead = np.arange(_SPOKES), _SPOKES - _SPOKES // 3
    seen, behind = spoke < ahead, _SPOKES - ahead
    place = spoke + chance.random((_RINGS, _SPOKES))
    rest = 2 * (math.pi - half)
    angle = np.where(seen, (2 * place / ahead - 1) * half, half + rest * (place - ahead) / behind)
    width = np.where(seen, 2 * half / ahead, rest / behind)
    radius = np.sqrt(inner**2 + chance.random(angle.shape) * (outer**2 - inner**2))
    angle = angle + math.atan2(view.camera.forward[1], view.camera.forward[0])
    around = np.stack((radius * np.cos(angle), radius * np.sin(angle)), axis=-1)
    area = width * (outer**2 - inner**2) / 2
    return view.camera.eye[:2] + around.reshape(-1, 2), area.ravel()


def _chance() -> np.random.Generator:
    return np.random.default_rng((_RINGS, _SPOKES))


def _half_angle(view: View, widest: float, distance: np.ndarray) -> np.ndarray:
    """Angle on the map to either side within which things ``widest`` [m] may be in view [rad]."""
    forward, (tan_x, tan_y) = view.camera.forward, view.camera.tan_half
    level = float(np.hypot(*forward[:2]))
    if view.look_around or abs(forward[2]) * tan_y >= level:
        return np.full_like(distance, 0.75 * math.pi)  # the zenith or the nadir is in the picture
    aside = math.atan2(tan_x, level - abs(float(forward[2])) * tan_y)
    return np.minimum(aside + np.arcsin(np.minimum(widest / distance, 1.0)), 0.75 * math.pi)


@njit(cache=True)
def _in_reach(middle, side, view, reach):  # type: ignore[no-untyped-def]
    """Whether each of these cells may hold a displayed whole, (n,)."""
    near = np.empty(len(middle), np.bool_)
    for i in range(len(middle)):
        near[i] = cell_in_reach(view, middle[i, 0], middle[i, 1], side, reach)
    return near
