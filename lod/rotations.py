"""Rotations by the array: the quaternions of many poses at once (§3.3).

Components stand last, in the order x, y, z, w of lod.actors.quaternion; everything before them
broadcasts.
"""

import numpy as np
from jaxtyping import Float64


def products(a: Float64[np.ndarray, "... 4"], b: Float64[np.ndarray, "... 4"]) -> np.ndarray:
    """a·b, each: turn by b first, then by a (Hamilton [39])."""
    ax, ay, az, aw = np.moveaxis(a, -1, 0)
    bx, by, bz, bw = np.moveaxis(b, -1, 0)
    return np.stack(
        (
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ),
        axis=-1,
    )


def rotated(q: Float64[np.ndarray, "... 4"], v: Float64[np.ndarray, "... 3"]) -> np.ndarray:
    """Vectors turned by unit quaternions (u, w): v + 2w(u×v) + 2u×(u×v), which is q·v·q⁻¹."""
    # Written out: for few vectors np.cross costs several times as much.
    x, y, z, w = np.moveaxis(q, -1, 0)
    a, b, c = np.moveaxis(v, -1, 0)
    d, e, f = 2.0 * (y * c - z * b), 2.0 * (z * a - x * c), 2.0 * (x * b - y * a)
    return np.stack(
        (
            a + w * d + (y * f - z * e),
            b + w * e + (z * d - x * f),
            c + w * f + (x * e - y * d),
        ),
        axis=-1,
    )


def units(q: Float64[np.ndarray, "... 4"]) -> np.ndarray:
    """Each at length 1."""
    return q / np.sqrt(np.sum(q * q, axis=-1, keepdims=True))


def from_rotation_vectors(angles_deg: Float64[np.ndarray, "... 3"]) -> np.ndarray:
    """The turn about each vector by its length [degrees] (the exponential)."""
    half = np.radians(angles_deg) / 2
    angle = np.sqrt(np.sum(half * half, axis=-1, keepdims=True))
    # np.sinc(x) is sin(πx)/(πx), and 1 at 0.
    return np.concatenate((half * np.sinc(angle / np.pi), np.cos(angle)), axis=-1)


def slerps(
    a: Float64[np.ndarray, "... 4"],
    b: Float64[np.ndarray, "... 4"],
    share: Float64[np.ndarray, "..."],
) -> np.ndarray:
    """From a at share 0 to b at share 1 at an even pace, the shorter way (Shoemake [41])."""
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    near = np.where(cosine < 0, -b, b)
    angle = 2 * np.arctan2(_length(near - a), _length(near + a))
    share = np.asarray(share)[..., None]
    # Where the two coincide the sines vanish; np.sinc keeps their ratio.
    whole = np.sinc(angle / np.pi)
    before = (1 - share) * np.sinc((1 - share) * angle / np.pi) / whole
    after = share * np.sinc(share * angle / np.pi) / whole
    return units(before * a + after * near)


def _length(q: np.ndarray) -> np.ndarray:
    return np.sqrt(np.sum(q * q, axis=-1, keepdims=True))
