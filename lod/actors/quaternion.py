"""Quaternions as numbers: rotations to multiply, divide and mix with reals (§3.3).

They are drjit's scalar quaternions, with components i, j, k and then the real part (x, y, z, w).
A vector is a quaternion whose real part is 0; a rotation is one of length 1. Products combine
rotations from the right: ``a * b`` turns by b first, then by a.

A drjit quaternion can be written to (``q.x = 1``), and ``==`` compares component by component; so
state is kept as a tuple (``components``), and every quaternion handed out is a new one.

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

Quaternion: TypeAlias = Quaternion4f64
Vector = tuple[float, float, float]
VectorLike = Sequence[float] | np.ndarray
Components = tuple[float, float, float, float]

EAST: Vector = (1.0, 0.0, 0.0)
NORTH: Vector = (0.0, 1.0, 0.0)
UP: Vector = (0.0, 0.0, 1.0)
IDENTITY: Components = (0.0, 0.0, 0.0, 1.0)
"""Components of the rotation that leaves everything as it is: the number 1."""

_UNIT_WITHIN = 4e-16
"""How far from 1 a length may round to and still count as 1."""


def vector(values: VectorLike, where: str = "vector") -> Vector:
    """Three finite numbers as a tuple. Raises InputError for anything else."""
    try:
        x, y, z = (float(value) for value in values)
    except (TypeError, ValueError):
        raise InputError(where, values, "three numbers") from None
    if not (math.isfinite(x) and math.isfinite(y) and math.isfinite(z)):
        raise InputError(where, values, "three finite numbers")
    return x, y, z


def components(q: Quaternion) -> Components:
    """(x, y, z, w): a copy that nothing can change."""
    return q.x, q.y, q.z, q.w


def pure_quaternion(values: VectorLike) -> Quaternion:
    """A vector as a quaternion with a zero real part (§3.3)."""
    return Quaternion(*vector(values), 0.0)


def vector_part(q: Quaternion) -> Vector:
    """The vector of a quaternion, whatever its real part."""
    return q.x, q.y, q.z


def norm(q: Quaternion) -> float:
    """Length |q|; |a·b| = |a|·|b|."""
    return math.hypot(q.x, q.y, q.z, q.w)


def unit(q: Quaternion) -> Quaternion:
    """``q`` at length 1; itself where it is so to rounding. Raises InputError for 0, NaN and Inf.

    After every product, this keeps a rotation a rotation: errors of rounding never add up.
    """
    length = math.hypot(q.x, q.y, q.z, q.w)
    if abs(length - 1.0) <= _UNIT_WITHIN:
        return q
    if not (math.isfinite(length) and length > 0):
        raise InputError("quaternion", components(q), "finite and not 0: it stands for a rotation")
    return q / length


def rotation(axis: VectorLike, angle_deg: float) -> Quaternion:
    """Turn by ``angle_deg`` about ``axis``, anticlockwise seen from its tip (Hamilton [39])."""
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
    """The vector turned by ``q``: q·v·q⁻¹, of the same length whatever the length of q."""
    return vector_part(q * pure_quaternion(values) / q)


def slerp(a: Quaternion, b: Quaternion, share: float) -> Quaternion:
    """From a at share 0 to b at share 1 at an even pace, the shorter way (Shoemake [41])."""
    turn = rotation_vector(unit(b / a))
    return unit(from_rotation_vector([share * angle for angle in turn]) * a)


def rotation_vector(q: Quaternion) -> Vector:
    """Axis times angle [degrees], the shorter way round: at most 180 long (the logarithm of q)."""
    sine = math.hypot(q.x, q.y, q.z)
    if sine == 0.0:
        return 0.0, 0.0, 0.0
    angle = 2 * math.degrees(math.atan2(sine, abs(q.w)))
    scale = math.copysign(angle / sine, q.w)
    return q.x * scale, q.y * scale, q.z * scale


def from_rotation_vector(angles_deg: VectorLike) -> Quaternion:
    """The turn about a vector by its length [degrees] (the exponential; inverse of the above)."""
    x, y, z = vector(angles_deg, "rotation vector")
    angle = math.hypot(x, y, z)
    return rotation((x, y, z), angle) if angle > 0 else Quaternion(*IDENTITY)


def matrix(q: Quaternion) -> np.ndarray:
    """The rotation matrix of ``q``, (3, 3): its columns are the turned axes."""
    return np.array([rotate(q, axis) for axis in (EAST, NORTH, UP)]).T
