"""Sums of noise over octaves (``lattice_noise``), each octave on a lattice of its own.

Octaves shorter than what a point can show fade, and still shorter ones are left out.
"""

import math
from collections.abc import Callable

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Reals
from lod.camera import STEP_M, Corner
from lod.threads import map_chunks
from scenes.noise.lattice import (
    cell_slopes,
    cell_value,
    fill_corners,
    fill_twin_corners,
    lattice_bits,
)
from scenes.noise.partial_sums import SoFar

_SHORTEST_RUN = 8192
"""Points for which another thread is worth its start; so that runs of those have none of their
own."""

Octaves = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Keys (k,) uint64, lattice squares (k, 2) int64, offsets (k, 2) [m], (side [m], weight) (k, 2)."""


def octaves_at(corner: Corner, key: int, sides: Reals, weights: Reals) -> Octaves:
    """The octaves of a sum as a frame at ``corner`` sees them: lattices of these sides [m]."""
    lattices = [corner.squares(side) for side in sides.tolist()]
    key64 = np.uint64(key % 2**64)
    keys = [
        lattice_bits(key64, np.int64(lattice_number(side)), np.int64(0)) for side in sides.tolist()
    ]
    return (
        np.array(keys, np.uint64),
        np.array([lattice[:2] for lattice in lattices], np.int64).reshape(-1, 2),
        np.array([lattice[2:] for lattice in lattices], np.float64).reshape(-1, 2),
        np.stack((sides, weights), axis=1),
    )


def lattice_number(side: float) -> int:
    """A lattice's number: log₂ of its side in metres, or else the side in STEP_M."""
    exponent = round(math.log2(side))
    return exponent if 2.0**exponent == side else round(side / STEP_M)


@njit(cache=True)
def _octave_weight(side: float, shortest: float) -> float:
    """Share of an octave that is kept: one up to twice too short fades; of shorter ones nothing."""
    if side >= shortest:
        return 1.0
    return 1.0 + math.log2(side / shortest) if 2.0 * side > shortest else 0.0


@njit(cache=True)
def height_slack(
    radius: np.ndarray,
    shortest: np.ndarray,
    sides: np.ndarray,
    highest: np.ndarray,
    steepest: np.ndarray,
) -> np.ndarray:
    """How far, within ``radius`` of each point, the sum can be from what is kept of it there.

    What is kept of an octave changes by at most its steepest slope × radius; the rest of it is
    within its bound. (n,), all else in metres, slopes in metres per metre, (k,) of each octave.
    """
    most = np.zeros(len(radius))
    for i in range(len(radius)):
        for k in range(len(sides)):
            kept = _octave_weight(sides[k], shortest[i])
            most[i] += kept * steepest[k] * radius[i] + (1.0 - kept) * highest[k]
    return most


@njit(cache=True, inline="always")
def _on_lattice(square, offset, side, xy):  # type: ignore[no-untyped-def]
    """The lattice cell that a point is in, and where in it, in [0, 1)²."""
    # Where the side is a power of two, multiplying by its inverse divides exactly.
    u, v = (offset[0] + xy[0]) * (1.0 / side), (offset[1] + xy[1]) * (1.0 / side)
    fu, fv = math.floor(u), math.floor(v)
    return square[0] + np.int64(fu), square[1] + np.int64(fv), u - fu, v - fv


@njit(cache=True, nogil=True)
def _values(keys, squares, offsets, scales, xy, shortest, crest, out):  # type: ignore[no-untyped-def]
    """Points that stand together share the cells of long waves: each octave's last is kept."""
    most = len(keys)
    cells, names, known = np.empty((most, 12)), np.empty((most, 2), np.int64), np.zeros(most, "?")
    for i in range(len(xy)):
        for k in range(most):
            side = scales[k, 0]
            kept = _octave_weight(side, shortest[i])
            if kept == 0.0:
                break
            ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
            if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                fill_corners(keys[k], ix, iy, cells[k])
                names[k, 0], names[k, 1], known[k] = ix, iy, True
            value = cell_value(cells[k], u, v)
            if crest > 0.0:
                value = crest - abs(value)
            out[i] += kept * scales[k, 1] * value


@njit(cache=True, nogil=True)
def _slopes(keys, squares, offsets, scales, xy, shortest, crest, whole, sums, out):  # type: ignore[no-untyped-def]
    """Slopes of what ``_values`` adds up; a column of ``shortest`` for each two of ``out``.

    whole, sums: as in SoFar; the sums go on from there.
    """
    most, columns = len(keys), shortest.shape[1]
    cells, names, known = np.empty((most, 12)), np.empty((most, 2), np.int64), np.zeros(most, "?")
    for i in range(len(xy)):
        least, first = math.inf, most
        for column in range(columns):
            least = min(least, shortest[i, column])
            _go_on(scales, shortest[i, column], whole[i], sums[i], column, out[i])
            first = min(first, whole[i, column])
        for k in range(first, most):
            side, weight = scales[k, 0], scales[k, 1]
            if _octave_weight(side, least) == 0.0:
                break
            looked_up, fall, slope_x, slope_y = False, False, 0.0, 0.0
            for column in range(columns):
                kept = _octave_weight(side, shortest[i, column]) if k >= whole[i, column] else 0.0
                if kept == 0.0:
                    continue
                if not looked_up:
                    ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
                    if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                        fill_corners(keys[k], ix, iy, cells[k])
                        names[k, 0], names[k, 1], known[k] = ix, iy, True
                    slope_x, slope_y = cell_slopes(cells[k], u, v)
                    fall, looked_up = crest > 0.0 and cell_value(cells[k], u, v) > 0.0, True
                steep = kept * weight / side * (-1.0 if fall else 1.0)
                out[i, 2 * column] += steep * slope_x
                out[i, 2 * column + 1] += steep * slope_y
                if kept == 1.0:
                    _keep(k, whole[i], sums[i], column, out[i])


@njit(cache=True, nogil=True)
def _twin_values(keys, squares, offsets, scales, xy, shortest, whole, sums, out):  # type: ignore[no-untyped-def]
    """What ``_values`` adds up of one noise, of two. whole, sums: as in SoFar."""
    most = len(keys)
    cells, names = np.empty((most, 2, 12)), np.empty((most, 2), np.int64)
    known = np.zeros(most, "?")
    for i in range(len(xy)):
        _go_on(scales, shortest[i], whole[i], sums[i], 0, out[i])
        for k in range(whole[i, 0], most):
            side = scales[k, 0]
            kept = _octave_weight(side, shortest[i])
            if kept == 0.0:
                break
            ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
            if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                fill_twin_corners(keys[k], ix, iy, cells[k])
                names[k, 0], names[k, 1], known[k] = ix, iy, True
            for twin in range(2):
                out[i, twin] += kept * scales[k, 1] * cell_value(cells[k, twin], u, v)
            if kept == 1.0:
                _keep(k, whole[i], sums[i], 0, out[i])


@njit(cache=True, inline="always")
def _go_on(scales, shortest, whole, sums, column, out):  # type: ignore[no-untyped-def]
    """Begin a sum with what is known of it: all of that, or else nothing counts whole now."""
    if whole[column] > 0 and scales[whole[column] - 1, 0] < shortest:
        whole[column], sums[2 * column], sums[2 * column + 1] = 0, 0.0, 0.0
    out[2 * column], out[2 * column + 1] = sums[2 * column], sums[2 * column + 1]


@njit(cache=True, inline="always")
def _keep(k, whole, sums, column, out):  # type: ignore[no-untyped-def]
    """Octave k counts whole, and so do all before it: that much of the sum will hold."""
    whole[column] = k + 1
    sums[2 * column], sums[2 * column + 1] = out[2 * column], out[2 * column + 1]


def octave_values(
    octaves: Octaves, xy: Float64[np.ndarray, "n 2"], shortest: Reals, crest: float = 0.0
) -> Reals:
    """Weighted sum of the octaves at each point, (n,); with a ``crest`` of crest − |noise|.

    Octaves of half of ``shortest`` [m] and less are left out at each point, and those in between
    fade. They stand longest first.
    """
    return _sum_octaves(_values, octaves, xy, shortest, (), crest)


def octave_slopes(
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: Float64[np.ndarray, "n k"],
    crest: float = 0.0,
    so_far: SoFar | None = None,
) -> Float64[np.ndarray, "n _"]:
    """The two slopes of ``octave_values`` for each column of ``shortest``, (n, 2k).

    so_far: of these very points, k columns; None: nothing is known yet
    """
    known = so_far or SoFar.none(*shortest.shape)
    kept = known.whole, known.sums
    return _sum_octaves(_slopes, octaves, xy, shortest, (2 * shortest.shape[1],), crest, kept=kept)


def twin_values(
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: Reals,
    so_far: SoFar | None = None,
) -> Float64[np.ndarray, "n 2"]:
    """Two independent ``octave_values`` of each point, for little more than one of them costs.

    so_far: of these very points, one column; None: nothing is known yet
    """
    known = so_far or SoFar.none(len(xy), 1)
    return _sum_octaves(_twin_values, octaves, xy, shortest, (2,), kept=(known.whole, known.sums))


def _sum_octaves(
    kernel: Callable[..., None],
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: np.ndarray,
    columns: tuple[int, ...],
    *more: float,
    kept: tuple[np.ndarray, ...] = (),
) -> np.ndarray:
    """What a kernel adds up at each point, (n, *columns); ``kept`` (n, …): what it goes on from."""
    points, least = np.ascontiguousarray(xy, np.float64), np.ascontiguousarray(shortest)
    out = np.zeros((len(points), *columns))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        kernel(*octaves, points[rows], least[rows], *more, *(k[rows] for k in kept), out[rows])

    map_chunks(run, len(points), _SHORTEST_RUN)
    return out
