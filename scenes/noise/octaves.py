"""Sums of octaves of noise at points, each octave on a lattice of its own.

At every point octaves shorter than a given wavelength are left out, and those of up to twice that
wavelength are faded in, so that a sum changes smoothly with the wavelength.
"""

import math
from collections.abc import Callable
from typing import NamedTuple

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

_POINTS_PER_THREAD = 8192
"""Number of points for which another thread is worth its start. Callers that already work on runs
of so many points get no further threads."""


class Octaves(NamedTuple):
    """The k octaves of a sum, longest first, as a frame at one grid corner sees them.

    key (k,) uint64     key of the hash of each octave's lattice
    square (k, 2) int64 lattice cell that the corner is in
    offset (k, 2)       place of the corner in that cell [m]
    side (k,)           side of a lattice cell, which is the wavelength [m]
    weight (k,)         factor on unit noise
    """

    key: np.ndarray
    square: np.ndarray
    offset: np.ndarray
    side: np.ndarray
    weight: np.ndarray


def octaves_at(corner: Corner, key: int, sides: Reals, weights: Reals) -> Octaves:
    """Octaves with lattices of these sides (k,) [m] and weights (k,), for a frame at ``corner``."""
    lattices = [corner.lattice(side) for side in sides.tolist()]
    key64 = np.uint64(key % 2**64)
    keys = [
        lattice_bits(key64, np.int64(lattice_number(side)), np.int64(0)) for side in sides.tolist()
    ]
    return Octaves(
        np.array(keys, np.uint64),
        np.array([lattice[:2] for lattice in lattices], np.int64).reshape(-1, 2),
        np.array([lattice[2:] for lattice in lattices], np.float64).reshape(-1, 2),
        np.ascontiguousarray(sides, np.float64),
        np.ascontiguousarray(weights, np.float64),
    )


def lattice_number(side: float) -> int:
    """Number of the lattice of a side [m]: its log₂ if whole, or else the side in STEP_M."""
    exponent = round(math.log2(side))
    return exponent if 2.0**exponent == side else round(side / STEP_M)


@njit(cache=True)
def _octave_share(side: float, shortest: float) -> float:
    """Share of an octave that counts where waves shorter than ``shortest`` are left out.

    It is 1 from ``shortest`` up, 0 at half of it and below, and linear in the octave between.
    """
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
    """Bound on how far the full sum in a circle is from the faded sum at its middle, (n,) [m].

    What counts of an octave changes by at most its steepest slope × radius; the rest of it is
    within its bound.

    radius, shortest (n,)  of the circles, and of the faded sums [m]
    sides, highest, steepest (k,)  wavelength, bound [m] and steepest slope of each octave
    """
    most = np.zeros(len(radius))
    for i in range(len(radius)):
        for k in range(len(sides)):
            share = _octave_share(sides[k], shortest[i])
            most[i] += share * steepest[k] * radius[i] + (1.0 - share) * highest[k]
    return most


@njit(cache=True, nogil=True)
def left_out_variance(shortest: np.ndarray, sides: np.ndarray, variances: np.ndarray) -> np.ndarray:
    """Variance that sums without octaves shorter than ``shortest`` (n,) lack, (n,).

    sides, variances (k,)  wavelength, and variance in full, of each octave
    """
    lacking = np.zeros(len(shortest))
    for i in range(len(shortest)):
        for k in range(len(sides)):
            lacking[i] += (1.0 - _octave_share(sides[k], shortest[i]) ** 2) * variances[k]
    return lacking


@njit(cache=True, inline="always")
def _cell_of(square, offset, inverse, point):  # type: ignore[no-untyped-def]
    """The lattice cell that a point is in, and its place in that cell, in [0, 1)²."""
    # Where the side is a power of two, multiplying by its inverse divides exactly.
    u, v = (offset[0] + point[0]) * inverse, (offset[1] + point[1]) * inverse
    fu, fv = math.floor(u), math.floor(v)
    return square[0] + np.int64(fu), square[1] + np.int64(fv), u - fu, v - fv


# Points side by side share lattice cells: each kernel keeps the last cell of every octave, with the
# values and gradients at its corners. Arrays are taken out of the tuple once, above the loops:
# inside, each access would count a reference.


@njit(cache=True, nogil=True)
def _values(octaves, points, shortest, crest, sums):  # type: ignore[no-untyped-def]
    """Add the weighted octaves at points to ``sums`` (n,)."""
    key, square, offset, side, weight = octaves
    count = len(key)
    corners, cell = np.empty((count, 12)), np.empty((count, 2), np.int64)
    filled = np.zeros(count, np.bool_)
    for i in range(len(points)):
        for k in range(count):
            share = _octave_share(side[k], shortest[i])
            if share == 0.0:
                break
            ix, iy, u, v = _cell_of(square[k], offset[k], 1.0 / side[k], points[i])
            if not filled[k] or ix != cell[k, 0] or iy != cell[k, 1]:
                fill_corners(key[k], ix, iy, corners[k])
                cell[k, 0], cell[k, 1], filled[k] = ix, iy, True
            value = cell_value(corners[k], u, v)
            if crest > 0.0:
                value = crest - abs(value)
            sums[i] += share * weight[k] * value


@njit(cache=True, nogil=True)
def _slopes(octaves, points, shortest, crest, sums):  # type: ignore[no-untyped-def]
    """Add the slopes of what ``_values`` adds up, two for each column of ``shortest``."""
    key, square, offset, side, weight = octaves
    count, columns = len(key), shortest.shape[1]
    corners, cell = np.empty((count, 12)), np.empty((count, 2), np.int64)
    filled = np.zeros(count, np.bool_)
    for i in range(len(points)):
        least = math.inf
        for column in range(columns):
            least = min(least, shortest[i, column])
        for k in range(count):
            if _octave_share(side[k], least) == 0.0:
                break
            ix, iy, u, v = _cell_of(square[k], offset[k], 1.0 / side[k], points[i])
            if not filled[k] or ix != cell[k, 0] or iy != cell[k, 1]:
                fill_corners(key[k], ix, iy, corners[k])
                cell[k, 0], cell[k, 1], filled[k] = ix, iy, True
            slope_x, slope_y = cell_slopes(corners[k], u, v)
            falls = crest > 0.0 and cell_value(corners[k], u, v) > 0.0
            for column in range(columns):
                share = _octave_share(side[k], shortest[i, column])
                if share > 0.0:
                    steep = share * weight[k] / side[k] * (-1.0 if falls else 1.0)
                    sums[i, 2 * column] += steep * slope_x
                    sums[i, 2 * column + 1] += steep * slope_y


@njit(cache=True, nogil=True)
def _twin_values(octaves, points, shortest, _crest, sums):  # type: ignore[no-untyped-def]
    """Add what ``_values`` adds up of one noise, of two independent ones, to ``sums`` (n, 2)."""
    key, square, offset, side, weight = octaves
    count = len(key)
    corners, cell = np.empty((count, 2, 12)), np.empty((count, 2), np.int64)
    filled = np.zeros(count, np.bool_)
    for i in range(len(points)):
        for k in range(count):
            share = _octave_share(side[k], shortest[i])
            if share == 0.0:
                break
            ix, iy, u, v = _cell_of(square[k], offset[k], 1.0 / side[k], points[i])
            if not filled[k] or ix != cell[k, 0] or iy != cell[k, 1]:
                fill_twin_corners(key[k], ix, iy, corners[k])
                cell[k, 0], cell[k, 1], filled[k] = ix, iy, True
            for twin in range(2):
                sums[i, twin] += share * weight[k] * cell_value(corners[k, twin], u, v)


def octave_values(
    octaves: Octaves, xy: Float64[np.ndarray, "n 2"], shortest: Reals, crest: float = 0.0
) -> Reals:
    """Weighted sum of the octaves at points ``xy`` [m] from the frame's corner, (n,).

    shortest (n,)  octaves of half of it and less are left out; those in between fade [m]
    crest          where above 0, ``crest`` − |noise| is summed in place of the noise
    """
    return _sum_octaves(_values, octaves, xy, shortest, np.zeros(len(xy)), crest)


def octave_slopes(
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: Float64[np.ndarray, "n k"],
    crest: float = 0.0,
) -> Float64[np.ndarray, "n _"]:
    """Slopes along x and y of ``octave_values`` for each column of ``shortest``, (n, 2k)."""
    sums = np.zeros((len(xy), 2 * shortest.shape[1]))
    return _sum_octaves(_slopes, octaves, xy, shortest, sums, crest)


def twin_values(
    octaves: Octaves, xy: Float64[np.ndarray, "n 2"], shortest: Reals
) -> Float64[np.ndarray, "n 2"]:
    """Two independent ``octave_values`` of each point, for little more than one of them costs."""
    return _sum_octaves(_twin_values, octaves, xy, shortest, np.zeros((len(xy), 2)), 0.0)


def _sum_octaves(
    kernel: Callable[..., None],
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: np.ndarray,
    sums: np.ndarray,
    crest: float,
) -> np.ndarray:
    """Run a kernel on all points, in threads, each of which adds to rows of ``sums`` of its own."""
    points, least = np.ascontiguousarray(xy, np.float64), np.ascontiguousarray(shortest)

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        kernel(octaves, points[rows], least[rows], crest, sums[rows])

    map_chunks(run, len(points), _POINTS_PER_THREAD)
    return sums
