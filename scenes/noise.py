"""Random numbers that a counter gives, and fractal noise on endless lattices of integers.

The same counter always gives the same numbers, in any order: Philox4x64-10 of Salmon, Moraes, Dror
& Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC 2011); NumPy's ``Philox`` is the same
generator and serves as the reference in the tests.

Every lattice point of a noise carries a hashed value and a hashed gradient (Peachey's
value-gradient noise, in Ebert et al. 2003, *Texturing & Modeling*, ch. 2), blended with Perlin's
quintic (Perlin 2002, "Improving noise"). The hash is output ``iy`` of the SplitMix64 stream seeded
by output ``ix`` of the stream seeded by the key (Steele, Lea & Flood 2014, "Fast splittable
pseudorandom number generators"): a point costs some fifty hashes, so it must be cheaper than
Philox.

A sum of noise has octaves, each on a lattice of its own. At every point octaves shorter than a
given wavelength are left out, and those of up to twice that wavelength are faded in, so that a sum
changes smoothly with the wavelength.
"""

import hashlib
import math
from collections.abc import Callable
from functools import cache
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numba import types
from numba.extending import intrinsic

from lod.arrays import Reals
from lod.camera import STEP_M, Corner
from lod.kernels import map_chunks, njit

_M0, _M1 = np.uint64(0xD2E7470EE14C6C93), np.uint64(0xCA5A826395121157)
_W0, _W1 = np.uint64(0x9E3779B97F4A7C15), np.uint64(0xBB67AE8584CAA73B)


@intrinsic
def _high_product(_typing, a, b):  # type: ignore[no-untyped-def]
    """Upper 64 of the 128 bits of a·b, by one instruction of the processor."""

    def generate(_context, builder, _signature, arguments):  # type: ignore[no-untyped-def]
        word = arguments[0].type
        wide = type(word)(128)
        factors = [builder.zext(each, wide) for each in arguments]
        return builder.trunc(builder.lshr(builder.mul(*factors), wide(64)), word)

    return types.uint64(types.uint64, types.uint64), generate


@njit(cache=True)
def philox4x64(c0, c1, c2, c3, k0, k1):  # type: ignore[no-untyped-def]
    """One block of four 64-bit words from a 256-bit counter and a 128-bit key, all uint64."""
    for _ in range(10):
        high0, low0 = _high_product(_M0, c0), _M0 * c0
        high1, low1 = _high_product(_M1, c2), _M1 * c2
        c0, c1, c2, c3 = high1 ^ c1 ^ k0, low1, high0 ^ c3 ^ k1, low0
        k0, k1 = k0 + _W0, k1 + _W1
    return c0, c1, c2, c3


@njit(cache=True, inline="always")
def unit_float(word):  # type: ignore[no-untyped-def]
    """A 64-bit word as a float64 in [0, 1), on the grid of 2^-53."""
    return np.float64(word >> np.uint64(11)) * 2.0**-53


def hash_name(text: str) -> np.uint64:
    """64-bit word of a name, from its SHA-256."""
    return np.uint64(int.from_bytes(hashlib.sha256(text.encode()).digest()[:8], "little"))


GRADIENT_LENGTH = 2.0
"""Length of the gradients at lattice points.

With values uniform in [-1, 1] it makes the variance at the middle of a
cell equal to that at its corners, 1/3 = (1/3 + STEEP²/4)/4, so that lattices do not show.
"""

NOISE_BOUND = 1 + GRADIENT_LENGTH / math.sqrt(2)
"""Largest absolute value that unit noise can have.

It is 1 + GRADIENT_LENGTH·Σw|d| over the corners, where (Σw|d|)² ≤ Σw|d|² ≤ 1/2 (Jensen).
"""

NOISE_MAX_SLOPE = (15 + math.sqrt(274)) / 4
"""Largest slope that unit noise can have, per side of the lattice.

It is the largest over places and directions e of Σ|∂w| + GRADIENT_LENGTH·|w·e + ∂w·d| over the four
corners, which is at the middle of a cell (found by search, which a test repeats).
"""

RIDGED_MEAN, RIDGED_RMS = 0.5128, 0.3578
"""Mean of |unit noise|, and RMS of what is left of it without its mean (measured, which a test
repeats)."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_VALUE_BITS = np.uint64(2**24 - 1)
_DIRECTIONS = 256
_TURN = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
_GRADIENTS = GRADIENT_LENGTH * np.stack((np.cos(_TURN), np.sin(_TURN)), axis=1)


@cache
def unit_rms() -> float:
    """RMS of unit noise over a cell: √(∫∫ Σ w²·(1/3 + STEEP²·|d|²/2)), integrated exactly."""
    blend = np.polynomial.Polynomial([0, 0, 0, 10, -15, 6])
    away = np.polynomial.Polynomial([-1, 1])
    square, moment = (p.integ()(1.0) for p in (blend**2, blend**2 * away**2))
    return math.sqrt(4 * square**2 / 3 + 4 * GRADIENT_LENGTH**2 * square * moment)


@cache
def unit_slope_variance() -> float:
    """Variance of the slope of unit noise along an axis, per squared side, over a cell.

    It is ∫∫ Σ (∂w²/3 + STEEP²/2·((w + ∂w·x)² + (∂w·y)²)) over the corners, integrated exactly.
    """
    blend = np.polynomial.Polynomial([1, 0, 0, -10, 15, -6])
    away, steep = np.polynomial.Polynomial([0, 1]), blend.deriv()
    value, moment, slope, turned = (
        p.integ()(1.0)
        for p in (blend**2, (blend * away) ** 2, steep**2, (blend + steep * away) ** 2)
    )
    gradient = GRADIENT_LENGTH**2 / 2 * (turned * value + slope * moment)
    return 4 * (slope * value / 3 + gradient)


@njit(cache=True)
def _splitmix(z: np.uint64) -> np.uint64:
    z = (z ^ (z >> np.uint64(30))) * _FIRST
    z = (z ^ (z >> np.uint64(27))) * _SECOND
    return z ^ (z >> np.uint64(31))


@njit(cache=True)
def lattice_bits(key: np.uint64, ix: np.int64, iy: np.int64) -> np.uint64:
    """64 random bits of one lattice point, a function of the key and the point alone."""
    return _splitmix(_splitmix(key + np.uint64(ix) * _GOLDEN) + np.uint64(iy) * _GOLDEN)


@njit(cache=True)
def fill_corners(key, ix, iy, cell):  # type: ignore[no-untyped-def]
    """Fill ``cell`` (12,) with the corners of a lattice cell.

    Each corner, in the order (0, 0), (1, 0), (0, 1), (1, 1), has a value and a gradient along x
    and y.
    """
    column, row = np.uint64(ix) * _GOLDEN, np.uint64(iy) * _GOLDEN
    for x in range(2):
        stream = _splitmix(key + column)
        for y in range(2):
            bits = _splitmix(stream + row + np.uint64(y) * _GOLDEN)
            at = 3 * (2 * y + x)
            cell[at] = np.float64(bits >> np.uint64(11)) * 2.0**-52 - 1.0
            gradient = _GRADIENTS[bits & np.uint64(_DIRECTIONS - 1)]
            cell[at + 1], cell[at + 2] = gradient[0], gradient[1]
        column += _GOLDEN


@njit(cache=True, inline="always")
def _corner_planes(c, u, v):  # type: ignore[no-untyped-def]
    """Heights at (u, v) of the planes through the four corners of a lattice cell."""
    f00, f10 = c[0] + c[1] * u + c[2] * v, c[3] + c[4] * (u - 1.0) + c[5] * v
    f01 = c[6] + c[7] * u + c[8] * (v - 1.0)
    return f00, f10, f01, c[9] + c[10] * (u - 1.0) + c[11] * (v - 1.0)


@njit(cache=True, inline="always")
def _quintic(u):  # type: ignore[no-untyped-def]
    return u * u * u * (u * (6.0 * u - 15.0) + 10.0)


@njit(cache=True)
def cell_value(cell, u, v):  # type: ignore[no-untyped-def]
    """Noise at (u, v) in [0, 1)² of a lattice cell with corners as ``fill_corners`` has them."""
    f00, f10, f01, f11 = _corner_planes(cell, u, v)
    su, sv = _quintic(u), _quintic(v)
    return f00 + su * (f10 - f00) + sv * (f01 - f00) + su * sv * (f11 - f10 - f01 + f00)


@njit(cache=True)
def cell_slopes(c, u, v):  # type: ignore[no-untyped-def]
    """Slopes of the noise along u and v at (u, v) in [0, 1)² of a lattice cell."""
    f00, f10, f01, f11 = _corner_planes(c, u, v)
    su, sv = _quintic(u), _quintic(v)
    ku, kv = 30.0 * (u * (u - 1.0)) ** 2, 30.0 * (v * (v - 1.0)) ** 2
    across, along, twist = f10 - f00, f01 - f00, f11 - f10 - f01 + f00
    w00, w10, w01, w11 = (1 - su) * (1 - sv), su * (1 - sv), (1 - su) * sv, su * sv
    slope_x = w00 * c[1] + w10 * c[4] + w01 * c[7] + w11 * c[10] + ku * (across + sv * twist)
    slope_y = w00 * c[2] + w10 * c[5] + w01 * c[8] + w11 * c[11] + kv * (along + su * twist)
    return slope_x, slope_y


@njit(cache=True)
def fill_twin_corners(key, ix, iy, cells):  # type: ignore[no-untyped-def]
    """Fill ``cells`` (2, 12) with the corners of a cell of two independent noises.

    Each noise has 32 of a lattice point's bits: 24 for the value and 8 for the gradient.
    """
    column, row = np.uint64(ix) * _GOLDEN, np.uint64(iy) * _GOLDEN
    for x in range(2):
        stream = _splitmix(key + column)
        for y in range(2):
            bits = _splitmix(stream + row + np.uint64(y) * _GOLDEN)
            at = 3 * (2 * y + x)
            for twin in range(2):
                cells[twin, at] = np.float64((bits >> np.uint64(8)) & _VALUE_BITS) * 2.0**-23 - 1.0
                gradient = _GRADIENTS[bits & np.uint64(_DIRECTIONS - 1)]
                cells[twin, at + 1], cells[twin, at + 2] = gradient[0], gradient[1]
                bits >>= np.uint64(32)
        column += _GOLDEN


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
    key64, keys = np.uint64(key % 2**64), []
    for side in sides.tolist():
        # The number of a lattice is log₂ of its side if whole, or else the side in STEP_M.
        exponent = round(math.log2(side))
        number = exponent if 2.0**exponent == side else round(side / STEP_M)
        keys.append(lattice_bits(key64, np.int64(number), np.int64(0)))
    return Octaves(
        np.array(keys, np.uint64),
        np.array([lattice[:2] for lattice in lattices], np.int64).reshape(-1, 2),
        np.array([lattice[2:] for lattice in lattices], np.float64).reshape(-1, 2),
        np.ascontiguousarray(sides, np.float64),
        np.ascontiguousarray(weights, np.float64),
    )


@njit(cache=True)
def _octave_share(side: float, shortest: float) -> float:
    """Share of an octave that counts where waves shorter than ``shortest`` are left out.

    It is 1 from ``shortest`` up, 0 at half of it and below, and linear in the octave between.
    """
    if side >= shortest:
        return 1.0
    return 1.0 + math.log2(side / shortest) if 2.0 * side > shortest else 0.0


@njit(cache=True)
def height_slack(radius, shortest, sides, highest, steepest):  # type: ignore[no-untyped-def]
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
    points, least = np.ascontiguousarray(xy, np.float64).view(), np.ascontiguousarray(shortest)
    points.flags.writeable = False  # as many callers' are, or there are two kernels of one

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        kernel(octaves, points[rows], least[rows], crest, sums[rows])

    # Callers that already work on runs of so many points get no further threads.
    map_chunks(run, len(points), 8192)
    return sums
