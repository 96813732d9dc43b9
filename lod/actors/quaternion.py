"""What are vectors and components of quaternions as plain data? Tuples, which need no library.

Quaternions as numbers: rotations that can be multiplied, divided and mixed with reals (§3.3).

They are drjit's scalar quaternions, with components i, j, k and then the real part (x, y, z, w).
A vector is a quaternion whose real part is 0; a rotation is one of length 1. Products combine
rotations from the right: ``a * b`` turns by b first, then by a.

A drjit quaternion can be written to (``q.x = 1``), and ``==`` compares component by component.
Therefore state is stored as a tuple (``components``), and every quaternion returned is a new one.

>>> i, j, k = (pure_quaternion(axis) for axis in (EAST, NORTH, UP))
>>> i * i, j * j, k * k, i * j * k
(-1, -1, -1, -1)
"""

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from drjit.scalar import Quaternion4f64

from lod.errors import InputError

Vector = tuple[float, float, float]
VectorLike = Sequence[float] | np.ndarray
Components = tuple[float, float, float, float]
"""i, j, k and the real part."""


Quaternion: TypeAlias = Quaternion4f64

EAST: Vector = (1.0, 0.0, 0.0)
NORTH: Vector = (0.0, 1.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
IDENTITY: Components = (0.0, 0.0, 0.0, 1.0)
"""Components of the rotation by 0: the number 1."""

_UNIT_WITHIN = 4e-16
"""Largest difference from 1 by which a rounded length counts as 1."""


def vector(values: VectorLike, where: str = "vector") -> Vector:
    """Return three finite numbers as a tuple. Raises InputError for anything else."""
    try:
        x, y, z = (float(value) for value in values)
    except (TypeError, ValueError):
        raise InputError(where, values, "three numbers") from None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise InputError(where, values, "three finite numbers")
    return x, y, z


def components(q: Quaternion) -> Components:
    """Return the components (x, y, z, w) as a tuple."""
    return q.x, q.y, q.z, q.w


def pure_quaternion(values: VectorLike) -> Quaternion:
    """Return a vector as a quaternion whose real part is 0 (§3.3)."""
    return Quaternion(*vector(values), 0.0)


def unit(q: Quaternion) -> Quaternion:
    """Scale ``q`` to length 1; return it unchanged where its length is 1 to rounding.

    Applied after every product, it prevents that errors of rounding add up. Raises InputError for
    0, NaN and infinity.
    """
    length = math.hypot(q.x, q.y, q.z, q.w)
    if abs(length - 1.0) <= _UNIT_WITHIN:
        return q
    if not (math.isfinite(length) and length > 0):
        raise InputError("quaternion", components(q), "finite and not 0: it stands for a rotation")
    return q / length


def rotation(axis: VectorLike, angle_deg: float) -> Quaternion:
    """Return the rotation by ``angle_deg`` about ``axis``, anticlockwise seen from its tip.

    Hamilton (reference 39 of the paper) gives the formula. Raises InputError for an axis of length
    0 or an angle that is not finite.
    """
    x, y, z = vector(axis, "axis")
    length = math.hypot(x, y, z)
    if length == 0.0:
        raise InputError("axis", axis, "a direction, not 0", "try (0, 1, 0)")
    if not math.isfinite(angle_deg):
        raise InputError("angle", angle_deg, "finite")
    half = math.radians(angle_deg) / 2
    s = math.sin(half) / length
    return unit(Quaternion(x * s, y * s, z * s, math.cos(half)))


def rotate(q: Quaternion, values: VectorLike) -> Vector:
    """Rotate a vector by ``q``: q·v·q⁻¹, which keeps its length whatever the length of q."""
    turned = q * pure_quaternion(values) / q
    return turned.x, turned.y, turned.z


def angles_of(q: Quaternion) -> Vector:
    """Compute the angles about x, y and z of Rz·Ry·Rx [degrees], that about y within ±90."""
    about_x = math.atan2(2 * (q.w * q.x + q.y * q.z), 1 - 2 * (q.x * q.x + q.y * q.y))
    about_y = math.asin(max(-1.0, min(1.0, 2 * (q.w * q.y - q.z * q.x))))
    about_z = math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z))
    return math.degrees(about_x), math.degrees(about_y), math.degrees(about_z)


def from_angles(angles_deg: VectorLike) -> Quaternion:
    """Return the rotation Rz·Ry·Rx by angles about x, y and z [degrees]: invert ``angles_of``."""
    half = np.radians(np.array(vector(angles_deg, "angles"))) / 2
    (sx, sy, sz), (cx, cy, cz) = np.sin(half).tolist(), np.cos(half).tolist()
    return Quaternion(
        sx * cy * cz - cx * sy * sz,
        cx * sy * cz + sx * cy * sz,
        cx * cy * sz - sx * sy * cz,
        cx * cy * cz + sx * sy * sz,
    )
