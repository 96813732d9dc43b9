"""Counter-based random numbers: the same counter always gives the same numbers, in any order.

Philox4x64-10 of Salmon, Moraes, Dror & Shaw, "Parallel random numbers: as easy as 1, 2, 3" (SC
2011); NumPy's ``Philox`` is the same generator and serves as the reference in the tests.
"""

import hashlib

import numpy as np
from numba import njit, types
from numba.extending import intrinsic

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
def philox(c0, c1, c2, c3, k0, k1):  # type: ignore[no-untyped-def]
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
