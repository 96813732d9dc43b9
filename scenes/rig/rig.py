"""What a rig is: joints of one object, their limits, the sticks that ride on them, and motions.

The frame of the object: origin where it stands on the ground, z up, x the way it faces, y to its
left. A joint sits at ``offset`` in the frame of its parent and turns there; joint −1 is the
object's own frame. A motion is cyclic: keyframes of every joint, slerped at each object's own
phase.

Rotations of joints: unit quaternions (x, y, z, w), and angles about x, y and z.

A joint's angles rotate it about x first, then y, then z of its parent: R = Rz·Ry·Rx. Products
combine from the right, as in ``lod.actors.actor``: p·q rotates by q first. Compiled functions
of scalars are for the kernels of ``scenes.rig.pose``, functions of arrays for everything else; of
arrays the components are the last axis, and the axes before it broadcast. They are written out
instead of ``scipy.spatial.transform.Rotation``, which normalizes its quaternions: that changes the
last bits of poses, and so of pictures.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from lod.arrays import (
    ArrayData,
    FlagArray,
    FloatArray,
    IntArray,
    Ints,
    Points,
    Reals,
    check_columns,
    freeze,
    frozen,
)
from lod.errors import InputError
from lod.kernels import njit
from lod.shapes import StickTable

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
        (a + w * d + (y * f - z * e), b + w * e + (z * d - x * f), c + w * f + (x * e - y * d)),
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


_SLACK_DEG = 1e-6


@dataclass(frozen=True, eq=False)
class Rig(ArrayData):
    """The joints of one object, parents before children.

    name    of every joint
    parent  (j,) −1 for joints that sit in the object's own frame
    offset  (j, 3) origin in the parent's frame [m]
    rest    (j, 4) rotation of each joint as the object stands, (x, y, z, w)
    low, high (j, 3) least and greatest angle about x, y, z, in Rz·Ry·Rx [degrees]
    shift_low, shift_high (3,) how far the joints of the object's own frame may move as it walks on
        the spot: bob and sway [m]
    """

    name: tuple[str, ...]
    parent: IntArray
    offset: FloatArray
    rest: FloatArray
    low: FloatArray
    high: FloatArray
    shift_low: FloatArray
    shift_high: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        j = len(self.name)
        vectors = dict.fromkeys(("offset", "low", "high"), (j, 3))
        check_columns("rig", self, parent=(j,), rest=(j, 4), **vectors)
        check_columns("rig", self, shift_low=(3,), shift_high=(3,))
        for row in np.flatnonzero((self.parent >= np.arange(j)) | (self.parent < -1)):
            rule = "a joint stands after its parent; -1 is the object's frame"
            raise InputError(f"rig.parent[{row}]", int(self.parent[row]), rule)
        if np.any(self.low > self.high) or np.any(self.shift_low > self.shift_high):
            raise InputError("rig.low", "a limit above its upper limit", "low is at most high")
        if np.abs(np.linalg.norm(self.rest, axis=1) - 1).max(initial=0) > 1e-9:
            rule = "a turn is a unit quaternion"
            raise InputError("rig.rest", "a quaternion not of length 1", rule)
        for row in np.flatnonzero(self.limit_excess(self.rest) > _SLACK_DEG):
            arrived = np.round(to_euler(self.rest[row]), 2).tolist()
            low, high = self.low[row].tolist(), self.high[row].tolist()
            rule = f"stands between {low} and {high} degrees"
            raise InputError(f"rig.rest[{self.name[row]}]", arrived, rule)

    def __len__(self) -> int:
        return len(self.name)

    def row(self, name: str) -> int:
        """Find the row of the joint of that name. Raises InputError where there is none."""
        if name not in self.name:
            raise InputError("joint", name, f"one of {', '.join(self.name)}")
        return self.name.index(name)

    def frames(
        self,
        rotations: Quaternions | None = None,
        shift: Sequence[float] | np.ndarray = (0.0, 0.0, 0.0),
    ) -> tuple[Vectors, Quaternions]:
        """Compute origin (…, j, 3) [m] and rotation (…, j, 4) of every joint in the object's frame.

        turns: (…, j, 4) rotation of every joint in its parent, at rest by default
        shift: (…, 3) added to the origins of joints that sit in the object's frame [m]
        """
        local = self.rest if rotations is None else rotations
        before = local.shape[:-2]
        poses = math.prod(before)
        shifts = np.broadcast_to(np.asarray(shift, np.float64), (*before, 3)).reshape(poses, 3)
        flat = frozen(local.reshape(poses, len(self), 4), np.float64)
        origin, turn = _frames(self.parent, self.offset, flat, frozen(shifts, np.float64))
        return origin.reshape(*before, len(self), 3), turn.reshape(local.shape)

    def limit_excess(self, rotations: Quaternions) -> Float64[np.ndarray, "..."]:
        """Compute how far each joint is beyond its limits, (…, j) [degrees], 0 within them."""

        def outside(angle: np.ndarray) -> np.ndarray:
            middle = (self.low + self.high) / 2
            near = middle + (angle - middle + 180.0) % 360.0 - 180.0
            return np.maximum(0, np.maximum(self.low - near, near - self.high)).max(axis=-1)

        angle = to_euler(rotations)
        # The same turn has a second set of angles, (x ± 180, ±180 − y, z ± 180).
        other = angle * np.array((1.0, -1.0, 1.0)) + 180.0
        return np.minimum(outside(angle), outside(other))

    def random_turns(self, rng: np.random.Generator, count: int) -> Quaternions:
        """Draw random poses within limits, (count, j, 4): uniform angles, and limits themselves."""
        share = np.clip(rng.uniform(-0.25, 1.25, (count, len(self), 3)), 0, 1)
        return from_euler(self.low + share * (self.high - self.low))

    def scaled(self, factor: float) -> "Rig":
        """Return the rig with every length multiplied by ``factor``."""
        lengths = ("offset", "shift_low", "shift_high")
        return replace(self, **{name: getattr(self, name) * factor for name in lengths})


@dataclass(frozen=True, eq=False)
class RiggedSticks(StickTable):
    """Sticks of every part, each end in the frame of a joint (−1 = the object's own frame).

    start_joint, end_joint (k,): the frames that start and end are in
    """

    start_joint: IntArray
    end_joint: IntArray

    def __post_init__(self) -> None:
        super().__post_init__()
        for key in ("start_joint", "end_joint"):
            joints = getattr(self, key)
            if joints.shape != self.tint.shape or np.any(joints < -1):
                raise InputError(f"sticks.{key}", joints.shape, "a joint, or -1, for every stick")

    @staticmethod
    def on(
        table: StickTable, start: Ints, end: Ints, origin: Float64[np.ndarray, "j 3"]
    ) -> "RiggedSticks":
        """Put sticks on joints, (k,) of their starts and ends: ``origin`` (j, 3) at rest, unturned.

        The sticks are in the object's frame.
        """
        local = np.concatenate((np.zeros((1, 3)), origin))
        ends = table.start - local[start + 1], table.end - local[end + 1]
        radii = table.start_radius, table.end_radius
        return RiggedSticks(table.first, *ends, *radii, table.tint, start, end)

    @property
    def joints(self) -> Ints:
        """Return the joints of ``spheres``, (2 k,)."""
        return np.concatenate((self.start_joint, self.end_joint))

    def posed(self, origin: Vectors, turn: Quaternions) -> StickTable:
        """Return the sticks in the object's frame, given the frames of all joints."""
        start = to_object_frame(origin, turn, self.start_joint, self.start)
        end = to_object_frame(origin, turn, self.end_joint, self.end)
        return StickTable(self.first, start, end, self.start_radius, self.end_radius, self.tint)


def to_object_frame(origin: Vectors, turn: Quaternions, joint: Ints, point: Points) -> Points:
    """Transform points (k, 3) [m] from the frames of joints (k,) to the object's frame."""
    if not len(origin):  # a rig without joints
        return point
    row = np.maximum(joint, 0)
    at = origin[row] + rotate_vectors(turn[row], point)
    return np.where((joint < 0)[:, None], point, at)


@njit(cache=True)
def _frames(parent, offset, rotations, shift):  # type: ignore[no-untyped-def]
    """Compute origins (m, j, 3) and turns (m, j, 4) of m poses from turns and shifts (m, 3)."""
    m, j = rotations.shape[:2]
    origin, facing = np.empty((m, j, 3)), np.empty((m, j, 4))
    for o in range(m):
        for k in range(j):
            up, x, y, z = parent[k], offset[k, 0], offset[k, 1], offset[k, 2]
            q = rotations[o, k, 0], rotations[o, k, 1], rotations[o, k, 2], rotations[o, k, 3]
            at = shift[o, 0], shift[o, 1], shift[o, 2]
            if up >= 0:
                at = origin[o, up, 0], origin[o, up, 1], origin[o, up, 2]
                above = facing[o, up, 0], facing[o, up, 1], facing[o, up, 2], facing[o, up, 3]
                x, y, z = rotate_vector(*above, x, y, z)
                q = quaternion_product(*above, *q)
            origin[o, k, 0], origin[o, k, 1], origin[o, k, 2] = at[0] + x, at[1] + y, at[2] + z
            facing[o, k, 0], facing[o, k, 1], facing[o, k, 2], facing[o, k, 3] = q
    return origin, facing


@dataclass(frozen=True, eq=False)
class Feet(ArrayData):
    """The legs of an object that stand on the ground, (l,), in any order.

    legs   (l, 3) joints: hip, knee, ankle
    sticks_out (l,) whether its hip turns aside about z, not about x
    bend   (l,) +1 where a positive angle about y flexes the knee, −1 where a negative one does
    strike (l,) phase at which the foot lands; duty (l,) share of the cycle that it stands, above 0
    home   (l, 2) where the print is in mid-stance, in the object's own frame [m]
    steepest (l,) slope that the sole follows; what is steeper, it only touches
    sole   (l, 3, 2) three points that the sole rests on, from its print, in the same axes [m]
    """

    legs: IntArray
    sticks_out: FlagArray
    bend: FloatArray
    strike: FloatArray
    duty: FloatArray
    home: FloatArray
    steepest: FloatArray
    sole: FloatArray

    def __post_init__(self) -> None:
        super().__post_init__()
        n = len(self.legs)
        check_columns("feet", self, legs=(n, 3), bend=(n,), strike=(n,), duty=(n,), home=(n, 2))
        check_columns("feet", self, steepest=(n,), sole=(n, 3, 2), sticks_out=(n,))
        if not np.all((self.duty > 0) & (self.duty <= 1)):
            raise InputError("feet.duty", self.duty.tolist(), "above 0, at most 1")
        edges = self.sole[:, 1:] - self.sole[:, :1]
        if n and np.abs(np.linalg.det(edges)).min() < 1e-12:
            raise InputError("feet.sole", "points in a line", "three points that span a plane")

    def __len__(self) -> int:
        return len(self.legs)

    @property
    def plane(self) -> np.ndarray:
        """Compute matrices (l, 3, 3) from heights at three points to print height and slopes."""
        points = np.concatenate((np.ones((len(self), 3, 1)), self.sole), axis=2)
        return np.linalg.inv(points)

    def scaled(self, factor: float) -> "Feet":
        """Return the feet with every length multiplied by ``factor``."""
        return replace(self, home=self.home * factor, sole=self.sole * factor)


NO_FEET = Feet(
    np.zeros((0, 3)), *(np.zeros(0),) * 4, np.zeros((0, 2)), np.zeros(0), np.zeros((0, 3, 2))
)


@njit(cache=True, inline="always")
def print_and_swing(own, duty):  # type: ignore[no-untyped-def]
    """Compute how far the last print is ahead of mid-stance, and the foot has swung on [strides].

    A print recedes evenly under the body while the foot stands on it. The swing goes from 0,
    while the foot stands, to 1 at the next print. ``own`` is the phase after landing, 0 to 1,
    and ``duty`` the share of the cycle that the foot stands.
    """
    u = (own - duty) / (1.0 - duty) if own > duty else 0.0
    return duty / 2 - own, u * u * (3.0 - 2.0 * u)


@dataclass(frozen=True, eq=False)
class Motion:
    """One cycle of K key poses, evenly spaced in phase; key K is key 0 again.

    rotations (K, j, 4) of every joint in its parent, of one sign from key to key, so that slerp
            takes the short way
    shift   (K, 3) how far the joints of the object's own frame are from where they rest [m]
    stride  how far the object moves ahead in one cycle; 0 for what stays where it is [m]
    period  how long a cycle lasts [s]
    feet    the legs that stand on the ground
    tilts   whether feet follow slopes across their way, too: those of ankles near the ground
    """

    rotations: np.ndarray
    shift: np.ndarray
    stride: float
    period: float
    feet: Feet = NO_FEET
    tilts: bool = False

    def __post_init__(self) -> None:
        rotations = np.asarray(self.rotations, np.float64)
        if len(rotations) and rotations.ndim == 3:  # of one sign from key to key
            dots = (rotations[1:] * rotations[:-1]).sum(axis=-1)
            flips = np.cumprod(np.where(dots < 0, -1.0, 1.0), axis=0)
            signed = rotations[1:] * flips[..., None]
            rotations = np.concatenate((rotations[:1], signed))
        object.__setattr__(self, "rotations", rotations)
        freeze(self, rotations=np.float64, shift=np.float64)
        keys = len(rotations)
        if rotations.ndim != 3 or keys == 0 or rotations.shape[2] != 4:
            raise InputError("motion.rotations", rotations.shape, "at least one key, (K, j, 4)")
        check_columns("motion", self, rotations=rotations.shape, shift=(keys, 3))
        if not (math.isfinite(self.stride) and self.stride >= 0):
            raise InputError("motion.stride", self.stride, "finite, at least 0 m")
        if not (math.isfinite(self.period) and self.period > 0):
            raise InputError("motion.period", self.period, "finite, above 0 s")
        legs = self.feet.legs
        if legs.size and legs.max() >= rotations.shape[1]:
            raise InputError("motion.feet", int(legs.max()), "a joint of the rig")

    @property
    def speed(self) -> float:
        """Compute the ground speed at which the feet do not slide [m/s]."""
        return self.stride / self.period

    def scaled(self, factor: float) -> "Motion":
        """Return the dynamically similar motion of a rig ``factor`` times as large.

        Time then goes as √length: strides are alike at equal speed²/(g·leg length) (Alexander,
        "Stride length and speed for adults, children, and fossil hominids", Am. J. Phys. Anthropol.
        63:23, 1984).
        """
        period = self.period * math.sqrt(factor) if self.stride else self.period
        lengths = (self.shift * factor, self.stride * factor)
        return Motion(self.rotations, *lengths, period, self.feet.scaled(factor), self.tilts)


def rest_motion(rig: Rig) -> Motion:
    """Return the motion of an object that stays at rest, which has one key."""
    return Motion(rig.rest[None], np.zeros((1, 3)), 0.0, 1.0)


def key_phases(keys: int) -> Reals:
    """Give the phases of ``keys`` evenly spaced keys, (K,)."""
    return np.arange(keys) / keys
