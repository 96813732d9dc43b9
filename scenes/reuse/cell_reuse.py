"""Which cells of a field are near enough, and for how long: what ``field_after`` asks of them."""

import math

import numpy as np
from numba import njit

from lod.pruning.compiled_test import compile_view, frustum_margin
from lod.pruning.view import View
from scenes.field.poisson_cells import Draws, away_at_least, away_in_plan, near_enough
from scenes.field.species_field import SpeciesField


def drawn_anew(
    field: SpeciesField, view: View, cells: np.ndarray, spread: float
) -> tuple[Draws, np.ndarray, np.ndarray, np.ndarray]:
    """The objects of these cells that could be displayed; how many of each cell are in the window,
    and kept (2, c); slack of that, by distance and by view (c, 2), and more than anything of each
    cell is away, with ``spread`` on top (c,) [m].

    cells: rows of those that ``field.search`` spans.
    """
    (x0, x1, y0, _), lattice, rules = field.search(view)
    reach, vantage, corner = field.near(view), compile_view(view), view.camera.corner
    spread += reach.high - reach.low
    x, y = x0 + cells % (x1 - x0), y0 + cells // (x1 - x0)
    counts, room = np.zeros((2, len(cells)), np.int32), np.empty((len(cells), 2))
    is_near, far = _searched(x, y, vantage, lattice, rules, spread, room)
    near = np.flatnonzero(is_near)
    held = np.zeros((len(near), 4))
    draws, _ = field.cells.near(x[near], y[near], corner, vantage, reach, held)
    grown = field.grown(corner, draws)
    cell = np.repeat(np.arange(len(held)), held[:, 1].astype(np.int64))[grown]
    counts[0, near], counts[1, near] = held[:, 0], np.bincount(cell, minlength=len(held))
    room[near] = np.minimum(room[near], held[:, 2:])
    return draws.take(grown), counts, room, far


@njit(cache=True)
def _searched(cell_x, cell_y, vantage, lattice, rules, spread, room):  # type: ignore[no-untyped-def]
    """Which of the cells are near enough; more than anything of them is away (n,); and into
    ``room`` (n, 2) the slack of that, by distance and by view.
    """
    ix, iy, rest_x, rest_y, side = lattice
    _, inside, outside, lean, above, middle, radius = rules
    is_near, away = np.empty(len(cell_x), np.bool_), np.empty(len(cell_x))
    for i in range(len(cell_x)):
        east, north = (cell_x[i] - ix + 0.5) * side - rest_x, (cell_y[i] - iy + 0.5) * side - rest_y
        is_near[i] = near_enough(vantage, east, north, side, rules)
        near = away_in_plan(vantage, east, north, side)
        far = away_at_least(near, lean, above)
        away[i] = near + 2 * side + 2 * lean + above + spread
        room[i, 0], room[i, 1] = abs(inside - far), math.inf
        if above >= inside:
            room[i, 0] = 0.0
        elif not vantage.look_around and not far > inside:
            if not far > outside:
                room[i, 0] = outside - far
            else:
                within = frustum_margin(vantage, east, north, middle)
                room[i, 1] = abs(within + radius)
                if not is_near[i]:
                    room[i, 0] = far - outside
    return is_near, away
