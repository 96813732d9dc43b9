"""Which cells of a field a frame visits: those from which a whole could pass its test."""

import math

import numpy as np
from numba import njit

from lod.errors import InputError
from lod.pruning.compiled_test import compile_view
from lod.pruning.view import View
from scenes.field.poisson_cells import CellSamples, PoissonCells
from scenes.field.search_bounds import SearchBounds, cell_in_reach, cell_reach


def candidates(cells: PoissonCells, view: View, bounds: SearchBounds) -> tuple[CellSamples, int]:
    """Return the objects of a field that could be displayed, and how many were examined."""
    return cells.candidates(*cells_in_reach(cells, view, bounds), view, bounds)


def cells_in_reach(
    cells: PoissonCells, view: View, bounds: SearchBounds
) -> tuple[np.ndarray, np.ndarray]:
    """Find the cells that may hold a displayed whole, in view or not, row by row: x, y (n,)."""
    reach = cell_reach(view, bounds, cells.side_m)
    spans, lattice = search_spans(cells, view, bounds), cells.lattice(view.camera.corner)
    return _cells_in_reach(spans, lattice, compile_view(view), reach)


def search_spans(
    cells: PoissonCells, view: View, bounds: SearchBounds
) -> tuple[int, int, int, int]:
    """Find ranges of cell numbers that hold all cells in reach: x from and before, then y.

    Raises InputError where nothing bounds the search.
    """
    side, lattice = cells.side_m, cells.lattice(view.camera.corner)
    reach, window = cell_reach(view, bounds, side).horizontal / side, bounds.half_window / side
    east, north = view.camera.eye[:2].tolist()
    x_range = _span(lattice.cell_x, (east + lattice.rest_x) / side, reach, window)
    return *x_range, *_span(lattice.cell_y, (north + lattice.rest_y) / side, reach, window)


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


@njit(cache=True)
def _cells_in_reach(spans, lattice, view, reach):  # type: ignore[no-untyped-def]
    """Those of the cells in ``spans`` that are in reach, row by row: x, y (n,)."""
    x0, x1, y0, y1 = spans
    side = lattice.side
    room = max(x1 - x0, 0) * max(y1 - y0, 0)
    cell_x, cell_y, n = np.empty(room, np.int64), np.empty(room, np.int64), 0
    for y in range(y0, y1):
        north = (y - lattice.cell_y + 0.5) * side - lattice.rest_y
        for x in range(x0, x1):
            east = (x - lattice.cell_x + 0.5) * side - lattice.rest_x
            if cell_in_reach(view, east, north, side, reach):
                cell_x[n], cell_y[n] = x, y
                n += 1
    return cell_x[:n], cell_y[:n]
