"""Noise without edge: value-gradient noise on integer lattices, and its sum over octaves.

Every lattice point carries a hashed value and a hashed gradient (Peachey's value-gradient noise, in
Ebert et al. 2003, *Texturing & Modeling*, ch. 2), blended with Perlin's quintic (Perlin 2002,
"Improving noise"). The hash is output ``iy`` of the SplitMix64 stream seeded by output ``ix`` of
the stream seeded by the key (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number
generators"): a point costs some fifty hashes, so it must be cheaper than ``scenes.random``.
"""

import math
from collections.abc import Callable
from functools import cache

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Reals
from lod.camera import STEP_M, Corner
from lod.runs import in_runs
from scenes.octave_sums import SoFar

STEEP = 2.0
"""Length of the gradients. With values uniform in [-1, 1] it makes the variance at the middle of a
cell equal to that at its corners, 1/3 = (1/3 + STEEP²/4)/4, so that lattices do not show."""

BOUND = 1 + STEEP / math.sqrt(2)
"""No value of unit noise is beyond it: 1 + STEEP·Σw|d|, where (Σw|d|)² ≤ Σw|d|² ≤ 1/2 (Jensen)."""

STEEPEST = (15 + math.sqrt(274)) / 4
"""No slope of unit noise is beyond it (per lattice side): the largest over places and directions e
of Σ|∂w| + STEEP·|w·e + ∂w·d| over the four corners, reached at the middle of a cell (found by
search, which a test repeats)."""

_SHORTEST_RUN = 8192
"""Points for which another thread is worth its start; so that runs of those have none of their
own."""

RIDGED_MEAN, RIDGED_RMS = 0.5128, 0.3578
"""Mean of |unit noise|, and RMS of what is left of it without its mean (measured, which a test
repeats)."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_VALUE_BITS = np.uint64(2**24 - 1)
_DIRECTIONS = 256
_TURN = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
_GRADIENTS = STEEP * np.stack((np.cos(_TURN), np.sin(_TURN)), axis=1)


@cache
def unit_rms() -> float:
    """RMS of unit noise over a cell: √(∫∫ Σ w²·(1/3 + STEEP²·|d|²/2)), integrated exactly."""
    blend = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
    away = np.polynomial.Polynomial([-1, 1])
    square, moment = (p.integ()(1.0) for p in (blend**2, blend**2 * away**2))
    return math.sqrt(4 * square**2 / 3 + 4 * STEEP**2 * square * moment)


@njit(cache=True)
def _mixed(z: np.uint64) -> np.uint64:
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def lattice_bits(key: np.uint64, ix: np.int64, iy: np.int64) -> np.uint64:
    """64 random bits of one lattice point, a function of the key and the point alone."""
    return _mixed(_mixed(key + np.uint64(ix) * _GOLDEN) + np.uint64(iy) * _GOLDEN)


@njit(cache=True)
def _lattice_cell(key, ix, iy, cell):  # type: ignore[no-untyped-def]
    """Value, and gradient along x and y, of the corners (0, 0), (1, 0), (0, 1), (1, 1) of a
    lattice cell, into (12,).
    """
    column, row = np.uint64(ix) * _GOLDEN, np.uint64(iy) * _GOLDEN
    for x in range(2):
        stream = _mixed(key + column)
        for y in range(2):
            bits = _mixed(stream + row + np.uint64(y) * _GOLDEN)
            at = 3 * (2 * y + x)
            cell[at] = np.float64(bits >> np.uint64(11)) * 2.0**-52 - 1.0
            gradient = _GRADIENTS[bits & np.uint64(_DIRECTIONS - 1)]
            cell[at + 1], cell[at + 2] = gradient[0], gradient[1]
        column += _GOLDEN


@njit(cache=True, inline="always")
def _ramps(c, u, v):  # type: ignore[no-untyped-def]
    """What each corner of a lattice cell says of the height at (u, v) in it."""
    f00, f10 = c[0] + c[1] * u + c[2] * v, c[3] + c[4] * (u - 1.0) + c[5] * v
    f01 = c[6] + c[7] * u + c[8] * (v - 1.0)
    return f00, f10, f01, c[9] + c[10] * (u - 1.0) + c[11] * (v - 1.0)


@njit(cache=True, inline="always")
def _quintic(u):  # type: ignore[no-untyped-def]
    return u * u * u * (u * (6.0 * u - 15.0) + 10.0)


@njit(cache=True)
def _value(cell, u, v):  # type: ignore[no-untyped-def]
    """Noise at (u, v) in [0, 1)² of a lattice cell."""
    f00, f10, f01, f11 = _ramps(cell, u, v)
    su, sv = _quintic(u), _quintic(v)
    return f00 + su * (f10 - f00) + sv * (f01 - f00) + su * sv * (f11 - f10 - f01 + f00)


@njit(cache=True)
def _slopes(c, u, v):  # type: ignore[no-untyped-def]
    """Slopes of the noise along u and v there."""
    f00, f10, f01, f11 = _ramps(c, u, v)
    su, sv = _quintic(u), _quintic(v)
    ku, kv = 30.0 * (u * (u - 1.0)) ** 2, 30.0 * (v * (v - 1.0)) ** 2
    across, along, twist = f10 - f00, f01 - f00, f11 - f10 - f01 + f00
    w00, w10, w01, w11 = (1 - su) * (1 - sv), su * (1 - sv), (1 - su) * sv, su * sv
    slope_x = w00 * c[1] + w10 * c[4] + w01 * c[7] + w11 * c[10] + ku * (across + sv * twist)
    slope_y = w00 * c[2] + w10 * c[5] + w01 * c[8] + w11 * c[11] + kv * (along + su * twist)
    return slope_x, slope_y


@njit(cache=True)
def _twin_cells(key, ix, iy, cells):  # type: ignore[no-untyped-def]
    """What ``_lattice_cell`` says of one noise, of two, into (2, 12): of each point's bits either
    has 24 for the value and 8 for the gradient.
    """
    column, row = np.uint64(ix) * _GOLDEN, np.uint64(iy) * _GOLDEN
    for x in range(2):
        stream = _mixed(key + column)
        for y in range(2):
            bits = _mixed(stream + row + np.uint64(y) * _GOLDEN)
            at = 3 * (2 * y + x)
            for twin in range(2):
                cells[twin, at] = np.float64((bits >> np.uint64(8)) & _VALUE_BITS) * 2.0**-23 - 1.0
                gradient = _GRADIENTS[bits & np.uint64(_DIRECTIONS - 1)]
                cells[twin, at + 1], cells[twin, at + 2] = gradient[0], gradient[1]
                bits >>= np.uint64(32)
        column += _GOLDEN


@njit(cache=True)
def unit_noise(
    key: np.uint64, ix: np.int64, iy: np.int64, u: float, v: float
) -> tuple[float, float, float]:
    """Noise and its slopes at (u, v) in [0, 1)² of lattice cell (ix, iy)."""
    cell = np.empty(12)
    _lattice_cell(key, ix, iy, cell)
    slope_x, slope_y = _slopes(cell, u, v)
    return _value(cell, u, v), slope_x, slope_y


Octaves = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Keys (k,) uint64, lattice squares (k, 2) int64, offsets (k, 2) [m], (side [m], weight) (k, 2)."""


def octaves_at(corner: Corner, key: int, sides: Reals, weights: Reals) -> Octaves:
    """The octaves of a sum as a frame at ``corner`` sees them: lattices of these sides [m]."""
    lattices = [corner.squares(side) for side in sides.tolist()]
    key64 = np.uint64(key % 2**64)
    keys = [lattice_bits(key64, np.int64(number_of(side)), np.int64(0)) for side in sides.tolist()]
    return (
        np.array(keys, np.uint64),
        np.array([lattice[:2] for lattice in lattices], np.int64).reshape(-1, 2),
        np.array([lattice[2:] for lattice in lattices], np.float64).reshape(-1, 2),
        np.stack((sides, weights), axis=1),
    )


def number_of(side: float) -> int:
    """A lattice's number: log₂ of its side in metres, or else the side in STEP_M."""
    exponent = round(math.log2(side))
    return exponent if 2.0**exponent == side else round(side / STEP_M)


@njit(cache=True)
def _kept(side: float, shortest: float) -> float:
    """Share of an octave that is kept: one up to twice too short fades; of shorter ones nothing."""
    if side >= shortest:
        return 1.0
    return 1.0 + math.log2(side / shortest) if 2.0 * side > shortest else 0.0


@njit(cache=True)
def slack(
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
            kept = _kept(sides[k], shortest[i])
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
            kept = _kept(side, shortest[i])
            if kept == 0.0:
                break
            ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
            if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                _lattice_cell(keys[k], ix, iy, cells[k])
                names[k, 0], names[k, 1], known[k] = ix, iy, True
            value = _value(cells[k], u, v)
            if crest > 0.0:
                value = crest - abs(value)
            out[i] += kept * scales[k, 1] * value


@njit(cache=True, nogil=True)
def _steepness(keys, squares, offsets, scales, xy, shortest, crest, whole, sums, out):  # type: ignore[no-untyped-def]
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
            if _kept(side, least) == 0.0:
                break
            looked_up, fall, slope_x, slope_y = False, False, 0.0, 0.0
            for column in range(columns):
                kept = _kept(side, shortest[i, column]) if k >= whole[i, column] else 0.0
                if kept == 0.0:
                    continue
                if not looked_up:
                    ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
                    if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                        _lattice_cell(keys[k], ix, iy, cells[k])
                        names[k, 0], names[k, 1], known[k] = ix, iy, True
                    slope_x, slope_y = _slopes(cells[k], u, v)
                    fall, looked_up = crest > 0.0 and _value(cells[k], u, v) > 0.0, True
                steep = kept * weight / side * (-1.0 if fall else 1.0)
                out[i, 2 * column] += steep * slope_x
                out[i, 2 * column + 1] += steep * slope_y
                if kept == 1.0:
                    _keep(k, whole[i], sums[i], column, out[i])


@njit(cache=True, nogil=True)
def _twins(keys, squares, offsets, scales, xy, shortest, whole, sums, out):  # type: ignore[no-untyped-def]
    """What ``_values`` adds up of one noise, of two. whole, sums: as in SoFar."""
    most = len(keys)
    cells, names = np.empty((most, 2, 12)), np.empty((most, 2), np.int64)
    known = np.zeros(most, "?")
    for i in range(len(xy)):
        _go_on(scales, shortest[i], whole[i], sums[i], 0, out[i])
        for k in range(whole[i, 0], most):
            side = scales[k, 0]
            kept = _kept(side, shortest[i])
            if kept == 0.0:
                break
            ix, iy, u, v = _on_lattice(squares[k], offsets[k], side, xy[i])
            if not known[k] or ix != names[k, 0] or iy != names[k, 1]:
                _twin_cells(keys[k], ix, iy, cells[k])
                names[k, 0], names[k, 1], known[k] = ix, iy, True
            for twin in range(2):
                out[i, twin] += kept * scales[k, 1] * _value(cells[k, twin], u, v)
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
    return _summed(_values, octaves, xy, shortest, (), crest)


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
    return _summed(_steepness, octaves, xy, shortest, (2 * shortest.shape[1],), crest, kept=kept)


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
    return _summed(_twins, octaves, xy, shortest, (2,), kept=(known.whole, known.sums))


def _summed(
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

    in_runs(run, len(points), _SHORTEST_RUN)
    return out
