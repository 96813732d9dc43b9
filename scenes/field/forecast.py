"""How many objects, parts and sticks of a species a view will display, before it is pruned.

The law's integral of what an object displays over the ground is taken on the nodes of the law's own
quadrature (``lod.law.spread_nodes``), by pruning the objects of the cells that they fall in. Its
cost does not depend on how much there is to display.
"""

from dataclasses import dataclass

import numpy as np

from lod.law import spread_nodes
from lod.view import View, compile_view
from scenes.field.cells import cell_in_reach, search_spans
from scenes.field.emission import PLAIN
from scenes.field.species_field import SpeciesField

_NODES = 768

_FADING = 1.1
"""Sticks drawn for each estimated one: appearances that fade into one another are both drawn."""


@dataclass(frozen=True)
class FieldForecast:
    """Expected numbers of what a view visits and displays of a species.

    objects  in the cells visited, wherever they can grow
    parts    displayed; sticks, triangles: those of the appearances that the parts show
    """

    objects: float
    parts: float
    sticks: float
    triangles: float


def forecast_field(field: SpeciesField, view: View) -> FieldForecast:
    """Estimate what a view displays of a species, within some 20 % where that is much.

    Raises InputError where nothing bounds the search.
    """
    view = field.species.seen_in(view)
    cells, bounds = field.cells, field.search_bounds(view)
    side, lattice = cells.side_m, cells.lattice(view.camera.corner)
    x0, x1, y0, y1 = search_spans(cells, view, bounds)
    origin = np.array([lattice.cell_x, lattice.cell_y]), np.array([lattice.rest_x, lattice.rest_y])
    low, high = ((np.array(n) - origin[0]) * side - origin[1] for n in ((x0, y0), (x1, y1)))
    eye, is_window = view.camera.eye[:2], field.extent is not None
    farthest = min(bounds.horizontal, 1e15)  # cells there are as fine as their numbers can say
    if is_window and ((eye < low) | (eye > high)).any():
        # The eye is outside of the window: an even net over that.
        sides = np.indices((32, 24)).reshape(2, -1).T + 0.5
        size = np.maximum(high - low, 0.0)
        xy, area = low + sides / (32, 24) * size, np.full(len(sides), size.prod() / len(sides))
    else:
        if is_window:
            farthest = min(farthest, float(np.hypot(*np.maximum(eye - low, high - eye))))
        net = spread_nodes(np.array([farthest]), view, _NODES, by_area=0.0)
        xy, area = net.xy, net.area
    steps = np.floor((xy + origin[1]) / side)
    number = steps.astype(np.int64) + origin[0]
    middle, compiled = (steps + 0.5) * side - origin[1], compile_view(view)
    near = np.array(
        [cell_in_reach(compiled, *each, side, bounds) for each in middle.tolist()], bool
    )
    near &= ((number >= (x0, y0)) & (number < (x1, y1))).all(axis=1)
    share = area[near] / side**2  # of a cell, or how many, for which a node stands
    cell, node = np.unique(number[near] @ (1, 1j), return_inverse=True)
    weight = np.bincount(node, share, minlength=len(cell))
    x, y = cell.real.astype(np.int64), cell.imag.astype(np.int64)
    samples = field.sample_cells(view.camera.corner, x, y)
    objects = field.instances_in_view(samples, view)
    cut = field.prototypes.cut(objects, view, len(samples))
    of_object = weight[np.searchsorted(cell, samples.cell_x + 1j * samples.cell_y)]
    of_part, part = of_object[cut.object], cut.part.astype(np.int64)
    # Of a part the leaf appearance where none of its own parts is displayed, or else the inner one.
    is_leaf = np.bincount(cut.parent[cut.parent >= 0], minlength=len(cut)) == 0
    tables = field.prototypes.part_tables
    sticks = tables.sticks.count[2 * part + is_leaf]
    triangles = np.zeros(len(part)) if tables.meshes is None else tables.meshes.count[part]
    kept = cut.parts.kept
    if kept is not None:
        triangles = np.where((kept > 0) & (kept < 1 / PLAIN), np.minimum(triangles, 1), triangles)
    visited = float(weight.sum())
    return FieldForecast(
        objects=visited * cells.density * side**2,
        parts=float(of_part.sum()),
        sticks=float(of_part @ sticks) * _FADING,
        triangles=float(of_part @ triangles),
    )
