"""Noise without edge: value-gradient noise on integer lattices, and its sum over octaves.

Every lattice point carries a hashed value and a hashed gradient (Peachey's value-gradient noise, in
Ebert et al. 2003, *Texturing & Modeling*, ch. 2), blended with Perlin's quintic (Perlin 2002,
"Improving noise"). The hash is output ``iy`` of the SplitMix64 stream seeded by output ``ix`` of
the stream seeded by the key (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number
generators"): a point costs some fifty hashes, so it must be cheaper than ``scenes.random``.
"""

import math

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Reals
from lod.camera import Corner
from lod.runs import in_runs

STEEP = 2.0
"""Length of the gradients. With values uniform in [-1, 1] it makes the variance at the middle of a
cell equal to that at its corners, 1/3 = (1/3 + STEEP²/4)/4, so that lattices do not show."""

BOUND = 1 + STEEP / math.sqrt(2)
"""No value of unit noise is beyond it: 1 + STEEP·Σw|d|, where (Σw|d|)² ≤ Σw|d|² ≤ 1/2 (Jensen)."""

STEEPEST = (15 + math.sqrt(274)) / 4
"""No slope of unit noise is beyond it (per lattice side): the largest over places and directions e
of Σ|∂w| + STEEP·|w·e + ∂w·d| over the four corners, reached at the middle of a cell (found by
search, which a test repeats)."""

_SHORTEST_RUN = 4096
"""Points for which another thread is worth its start."""

RIDGED_MEAN, RIDGED_RMS = 0.5128, 0.3578
"""Mean of |unit noise|, and RMS of what is left of it without its mean (measured, which a test
repeats)."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST = np.uint64(0xBF58476D1CE4E5B9)
_SECOND = np.uint64(0x94D049BB133111EB)
_DIRECTIONS = 256
_TURN = 2 * np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
_GRADIENTS = STEEP * np.stack((np.cos(_TURN), np.sin(_TURN)), axis=1)


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
def _corner(
    key: np.uint64, ix: np.int64, iy: np.int64, du: float, dv: float
) -> tuple[float, float, float]:
    bits = lattice_bits(key, ix, iy)
    value = np.float64(bits >> np.uint64(11)) * 2.0**-52 - 1.0
    g = _GRADIENTS[bits & np.uint64(_DIRECTIONS - 1)]
    return value + g[0] * du + g[1] * dv, g[0], g[1]


@njit(cache=True)
def unit_noise(
    key: np.uint64, ix: np.int64, iy: np.int64, u: float, v: float
) -> tuple[float, float, float]:
    """Noise and its slopes at (u, v) in [0, 1)² of lattice cell (ix, iy)."""
    one = np.int64(1)
    f00, x00, y00 = _corner(key, ix, iy, u, v)
    f10, x10, y10 = _corner(key, ix + one, iy, u - 1.0, v)
    f01, x01, y01 = _corner(key, ix, iy + one, u, v - 1.0)
    f11, x11, y11 = _corner(key, ix + one, iy + one, u - 1.0, v - 1.0)
    su, sv = u * u * u * (u * (6.0 * u - 15.0) + 10.0), v * v * v * (v * (6.0 * v - 15.0) + 10.0)
    ku, kv = 30.0 * (u * (u - 1.0)) ** 2, 30.0 * (v * (v - 1.0)) ** 2
    across, along, twist = f10 - f00, f01 - f00, f11 - f10 - f01 + f00
    value = f00 + su * across + sv * along + su * sv * twist
    w00, w10, w01, w11 = (1 - su) * (1 - sv), su * (1 - sv), (1 - su) * sv, su * sv
    slope_x = w00 * x00 + w10 * x10 + w01 * x01 + w11 * x11 + ku * (across + sv * twist)
    slope_y = w00 * y00 + w10 * y10 + w01 * y01 + w11 * y11 + kv * (along + su * twist)
    return value, slope_x, slope_y


Octaves = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Keys (k,) uint64, lattice squares (k, 2) int64, offsets (k, 2) [m], (side [m], weight) (k, 2)."""


def octaves_at(corner: Corner, key: int, exponents: range, weights: Reals) -> Octaves:
    """The octaves of a sum as a frame at ``corner`` sees them: lattices of side 2**exponent m."""
    lattices = [corner.lattice(exponent) for exponent in exponents]
    key64 = np.uint64(key % 2**64)
    keys = [lattice_bits(key64, np.int64(exponent), np.int64(0)) for exponent in exponents]
    return (
        np.array(keys, np.uint64),
        np.array([lattice[:2] for lattice in lattices], np.int64).reshape(-1, 2),
        np.array([lattice[2:] for lattice in lattices], np.float64).reshape(-1, 2),
        np.array([2.0**e for e in exponents] + list(weights)).reshape(2, -1).T.copy(),
    )


@njit(cache=True, nogil=True)
def _sums(
    keys: np.ndarray,
    squares: np.ndarray,
    offsets: np.ndarray,
    scales: np.ndarray,
    xy: np.ndarray,
    shortest: np.ndarray,
    limit_value: bool,
    crest: float,
    out: np.ndarray,
) -> None:
    for i in range(len(xy)):
        for k in range(len(keys)):
            side, weight = scales[k, 0], scales[k, 1]
            # An octave up to twice too short fades; of shorter ones there is nothing.
            kept = 1.0 if side >= shortest[i] else max(0.0, 1.0 + math.log2(side / shortest[i]))
            if kept == 0.0 and limit_value:
                break
            u, v = (offsets[k, 0] + xy[i, 0]) / side, (offsets[k, 1] + xy[i, 1]) / side
            fu, fv = math.floor(u), math.floor(v)
            ix, iy = squares[k, 0] + np.int64(fu), squares[k, 1] + np.int64(fv)
            value, slope_x, slope_y = unit_noise(keys[k], ix, iy, u - fu, v - fv)
            if crest > 0.0:
                turned = -1.0 if value > 0.0 else 1.0
                value, slope_x, slope_y = crest - abs(value), turned * slope_x, turned * slope_y
            out[i, 0] += (kept if limit_value else 1.0) * weight * value
            out[i, 1] += kept * weight / side * slope_x
            out[i, 2] += kept * weight / side * slope_y


def octave_sums(
    octaves: Octaves,
    xy: Float64[np.ndarray, "n 2"],
    shortest: Reals,
    limit_value: bool = False,
    crest: float = 0.0,
) -> Float64[np.ndarray, "n 3"]:
    """Weighted sum of the octaves and its two slopes at each point, (n, 3).

    Slopes leave out octaves of half of ``shortest`` [m] and less at each point, and fade those in
    between; so does the value where ``limit_value``. Octaves stand longest first. With a ``crest``
    it is the sum of crest − |noise|.
    """
    points, least = np.ascontiguousarray(xy, np.float64), np.ascontiguousarray(shortest)
    out = np.zeros((len(points), 3))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        _sums(*octaves, points[rows], least[rows], limit_value, crest, out[rows])

    in_runs(run, len(points), _SHORTEST_RUN)
    return out
