"""Products of quaternions, and vectors turned by them, for many poses at once (§3.3).

The components are the last axis, in the order x, y, z, w of ``lod.actors.quaternion``; the axes
before it broadcast. They are written out instead of ``scipy.spatial.transform.Rotation``, which
normalizes its quaternions: that changes the last bits of poses, and so of pictures.
"""

import numpy as np
from jaxtyping import Float64


def multiply_quaternions(
    a: Float64[np.ndarray, "... 4"], b: Float64[np.ndarray, "... 4"]
) -> np.ndarray:
    """Return the products a·b: the rotation by b first, then by a (Hamilton [39])."""
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


def rotate_vectors(q: Float64[np.ndarray, "... 4"], v: Float64[np.ndarray, "... 3"]) -> np.ndarray:
    """Turn vectors by unit quaternions (u, w): v + 2w(u×v) + 2u×(u×v), which is q·v·q⁻¹."""
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
