"""Rotations of joints: unit quaternions (x, y, z, w), and angles about x, y and z.

A joint's angles rotate it about x first, then y, then z of its parent: R = Rz·Ry·Rx. Products
combine from the right, as in ``lod.actors.quaternion``: p·q rotates by q first. Compiled functions
of scalars are for the kernels of ``scenes.rig.pose``, functions of arrays for everything else; of
arrays the components are the last axis, and the axes before it broadcast. They are written out
instead of ``scipy.spatial.transform.Rotation``, which normalizes its quaternions: that changes the
last bits of poses, and so of pictures.
"""

import math

import numpy as np
from jaxtyping import Float64

from lod.kernels import njit

Quaternions = Float64[np.ndarray, "... 4"]
Vectors = Float64[np.ndarray, "... 3"]
Matrices = Float64[np.ndarray, "... 3 3"]


def multiply_quaternions(a: Quaternions, b: Quaternions) -> np.ndarray:
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


def rotate_vectors(q: Quaternions, v: Vectors) -> np.ndarray:
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


def from_euler(degrees: Vectors) -> Quaternions:
    """Compute quaternions of Rz·Ry·Rx from angles about x, y, z [degrees]."""
    half = np.radians(degrees) / 2
    (sx, sy, sz), (cx, cy, cz) = (np.moveaxis(f(half), -1, 0) for f in (np.sin, np.cos))
    return np.stack(
        (
            sx * cy * cz - cx * sy * sz,
            cx * sy * cz + sx * cy * sz,
            cx * cy * sz - sx * sy * cz,
            cx * cy * cz + sx * sy * sz,
        ),
        axis=-1,
    )


def to_euler(rotations: Quaternions) -> Vectors:
    """Compute the angles about x, y, z [degrees] of Rz·Ry·Rx, the one about y within ±90°."""
    x, y, z, w = np.moveaxis(rotations, -1, 0)
    about_x = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    about_y = np.arcsin(np.clip(2 * (w * y - z * x), -1, 1))
    about_z = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return np.degrees(np.stack((about_x, about_y, about_z), axis=-1))


def inverse(q: Quaternions) -> Quaternions:
    """Invert the rotations of unit quaternions."""
    return q * np.array((-1.0, -1.0, -1.0, 1.0))


def matrices(q: Quaternions) -> Matrices:
    """Compute the rotation matrices of unit quaternions: their columns are the rotated axes."""
    axes = [rotate_vectors(q, np.broadcast_to(axis, (*q.shape[:-1], 3))) for axis in np.eye(3)]
    return np.stack(axes, axis=-1)


def shortest_arc(a: Vectors, b: Vectors) -> Quaternions:
    """Find the shortest rotations that take directions a to b, (…, 4), which are not opposite."""
    length = np.linalg.norm(a, axis=-1) * np.linalg.norm(b, axis=-1)
    w = length + (a * b).sum(axis=-1)
    q = np.concatenate((np.cross(a, b), w[..., None]), axis=-1)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


@njit(cache=True)
def quaternion_product(ax, ay, az, aw, bx, by, bz, bw):  # type: ignore[no-untyped-def]
    """Compute the product a·b of two quaternions, component by component."""
    return (
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    )


@njit(cache=True)
def rotate_vector(qx, qy, qz, qw, x, y, z):  # type: ignore[no-untyped-def]
    """Rotate the vector (x, y, z) by a unit quaternion."""
    tx, ty, tz = 2 * (qy * z - qz * y), 2 * (qz * x - qx * z), 2 * (qx * y - qy * x)
    return (
        x + qw * tx + qy * tz - qz * ty,
        y + qw * ty + qz * tx - qx * tz,
        z + qw * tz + qx * ty - qy * tx,
    )


@njit(cache=True)
def slerp_weights(share, angle, per_sine):  # type: ignore[no-untyped-def]
    """Compute the weights of two quaternions in a spherical interpolation.

    angle: between the quaternions, half the rotation between them [rad]; per_sine: 1/sin(angle).
    Shoemake, "Animating rotation with quaternion curves", SIGGRAPH 1985.
    """
    return _sine((1.0 - share) * angle) * per_sine, _sine(share * angle) * per_sine


@njit(cache=True, inline="always")
def _sine(x):  # type: ignore[no-untyped-def]
    """Compute the sine of x ≥ 0, for small angles by its series to x¹¹; the rest is rounding."""
    if x > 0.3:
        return math.sin(x)
    s = x * x
    tail = 1.0 / 120.0 - s * (1.0 / 5040.0 - s * (1.0 / 362880.0 - s * (1.0 / 39916800.0)))
    return x * (1.0 - s * (1.0 / 6.0 - s * tail))
