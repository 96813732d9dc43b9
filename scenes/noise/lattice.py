"""Value-gradient noise on an endless lattice of integers.

Every lattice point carries a hashed value and a hashed gradient (Peachey's value-gradient noise, in
Ebert et al. 2003, *Texturing & Modeling*, ch. 2), blended with Perlin's quintic (Perlin 2002,
"Improving noise"). The hash is output ``iy`` of the SplitMix64 stream seeded by output ``ix`` of
the stream seeded by the key (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number
generators"): a point costs some fifty hashes, so it must be cheaper than ``scenes.noise.philox``.
"""

import math
from functools import cache

import numpy as np
from numba import njit

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
    """Output function of SplitMix64."""
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
