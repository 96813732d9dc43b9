"""Which cells of a field a frame must visit: those from which a whole could pass its test."""

import math
from typing import Any

import numpy as np

from lod.camera import Corner
from lod.errors import InputError
from lod.pruning.compiled_test import compile_view
from lod.pruning.view import View
from lod.pruning.view_geometry import search_radius
from scenes.field.poisson_cells import PoissonCells, cells_near


def search(
    cells: PoissonCells,
    extent: float | None,
    view: View,
    inside: float,
    outside: float,
    bound: float,
    lean: float,
    low: float,
    high: float,
) -> tuple[Any, Any, Any]:
    """What ``cells_near`` is asked with: spans, lattice and rules; all lengths in metres.

    extent            side of the window on the field; None = no edge
    inside, outside   greatest limit of a whole, in view and out of it; bound: greatest B of one
    lean              how far in plan the origin of a whole can be from its home
    low, high         heights that it cannot be beyond
    """
    inside, eye = search_radius(view, inside, bound), view.camera.eye
    above = max(0.0, eye[2] - high, low - eye[2])
    in_plan = math.sqrt(max(inside**2 - above**2, 0.0)) + lean
    spans = _spans(cells, extent, view.camera.corner, eye, in_plan)
    radius = cells.side_m / math.sqrt(2) + (high - low) / 2 + lean + bound
    rules = (in_plan, inside, outside, lean, above, (low + high) / 2, radius)
    lattice = (*view.camera.corner.lattice(cells.exponent), cells.side_m)
    return spans, lattice, rules


def cells_near_view(view: View, asked: tuple[Any, Any, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Cells near enough, in view or out of it, to hold a displayed whole; asked: of ``search``."""
    spans, lattice, rules = asked
    return cells_near(spans, lattice, compile_view(view), rules)


def _spans(
    cells: PoissonCells, extent: float | None, corner: Corner, eye: np.ndarray, reach: float
) -> tuple[int, int, int, int]:
    """Ranges of cell numbers in x and y that hold ``reach`` about the eye, in the window."""
    ix, iy, rest_x, rest_y = corner.lattice(cells.exponent)
    side = cells.side_m
    window = math.inf if extent is None else extent / 2 / side
    x_range = _span(ix, (eye[0] + rest_x) / side, reach / side, window)
    return *x_range, *_span(iy, (eye[1] + rest_y) / side, reach / side, window)


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
