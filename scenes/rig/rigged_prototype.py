"""A posable object: its part hierarchy holds for every pose that the joint limits allow (§2.4).

It is the rule of ``scenes.sticks.prototype``, where a separation or an extent is the farthest "over
all poses": the bound of ``reach_bound``, never exceeded, and reached within a few per cent. Where a
leaf appearance spans joints, P is the largest over the poses of ``P_POSES`` as well. A rig that
cannot move gives the same numbers.

``reach_bound`` takes the points x of a jointed chain as a set S; |x| is at most max over directions
u of h(u) = max of u·x, the set's support function (Rockafellar, "Convex Analysis", 1970, §13). Down
the chain it obeys

    h_parent(u) = max over children of  u·offset + max over allowed R of h_child(Rᵀu),

and R = Rz·Ry·Rx takes three maxima over one angle each, so that no combination of angles is ever
listed. Two steps keep it an upper bound, both with an error of second order only:

* h is kept on the points (1, s, t) of a cube's faces. It is convex, so interpolating bilinearly
never gives less than its value (Jensen).
* An arc between two angles δ apart lies within the two points of those angles moved out from the
axis by 1/cos(δ/2), so that a few angles stand for all between them.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals, freeze, frozen
from lod.errors import InputError
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.kernels import njit
from lod.shapes import MeshTable, StickTable
from scenes.rig.rig import (
    Motion,
    Quaternions,
    Rig,
    RiggedSticks,
    from_euler,
    rest_motion,
    to_object_frame,
)
from scenes.sticks.areas import ViewDependence, largest_area
from scenes.sticks.prototype import Prototype, bounds_of_all_below, part_contrasts

P_POSES = 6
"""Random allowed poses in which leaf appearances that span joints are measured, besides rest and
straight.
"""


@dataclass(frozen=True, eq=False)
class RiggedPrototype:
    """One whole object that can be posed.

    joint   (n,) joint that the part's origin rides on
    place   (n, 3) the origin in that joint's frame; the joint's own by default [m]
    hierarchy  positions at rest; P, R, B and separation for every allowed pose
    inner, leaf, tints, view_dependence as in Prototype; motion: its walk, or whatever it does
    limbs  (j,) what each joint carries, as a foot on an ankle; by default the joints' names
    meshes  those of parts that own none, each in the frame of its part's joint; pictures show them
            in place of ``leaf``. None where every part is sticks
    """

    name: str
    rig: Rig
    joint: np.ndarray
    hierarchy: Hierarchy
    inner: RiggedSticks
    leaf: RiggedSticks
    tints: np.ndarray
    motion: Motion
    place: np.ndarray = field(default_factory=lambda: np.zeros((0, 3)))
    view_dependence: ViewDependence = field(default_factory=ViewDependence)
    limbs: tuple[str, ...] = ()
    meshes: MeshTable | None = None

    def __post_init__(self) -> None:
        if not len(self.place):
            object.__setattr__(self, "place", np.zeros((len(self.joint), 3)))
        if not self.limbs:
            object.__setattr__(self, "limbs", self.rig.name)
        freeze(self, joint=np.int64, tints=np.float64, place=np.float64)
        if self.motion.rotations.shape[1] != len(self.rig):
            arrived = self.motion.rotations.shape[1]
            raise InputError(f"{self.name}.motion", arrived, f"{len(self.rig)} joints")
        if self.meshes is not None and len(self.meshes.count) != len(self.joint):
            rule = "one mesh, or none, for each part"
            raise InputError(f"{self.name}.meshes", len(self.meshes.count), rule)
        if len(self.joint) != len(self.hierarchy) or self.joint.max() >= len(self.rig):
            raise InputError(f"{self.name}.joint", len(self.joint), "one joint for each part")
        for table in (self.inner, self.leaf):
            if len(table) and max(table.start_joint.max(), table.end_joint.max()) >= len(self.rig):
                raise InputError(f"{self.name}.sticks", "no such joint", "a joint of the rig")

    def posed(
        self,
        rotations: Quaternions | None = None,
        shift: tuple[float, float, float] | Reals = (0.0, 0.0, 0.0),
    ) -> Prototype:
        """Return the object in one pose, by default at rest; P, R and B stay those of all poses."""
        origin, turn = self.rig.frames(rotations, shift)
        position = to_object_frame(origin, turn, self.joint, self.place)
        hierarchy = replace(self.hierarchy, position=position)
        inner, leaf = (table.posed(origin, turn) for table in (self.inner, self.leaf))
        meshes = self.meshes
        if meshes is not None:
            joint = self.joint[meshes.vertex_owner]
            at = to_object_frame(origin, turn, joint, meshes.vertices)
            spine = to_object_frame(origin, turn, joint, meshes.spine)
            ahead = to_object_frame(np.zeros_like(origin), turn, joint, meshes.normals)
            meshes = replace(meshes, vertices=at, spine=spine, normals=ahead)
        looks = self.tints, self.view_dependence, meshes
        return Prototype(self.name, hierarchy, inner, leaf, *looks)

    def full_detail_sticks(self) -> tuple[RiggedSticks, RiggedSticks]:
        """Return what is shown while all parts are: inner sticks, and leaf sticks of ends."""
        owns = np.zeros(len(self.joint), bool)
        owns[self.hierarchy.parent[1:]] = True
        return self.inner.only(owns), self.leaf.only(~owns)

    def scaled(self, factor: float) -> "RiggedPrototype":
        """Return the object ``factor`` times as large, moving in a dynamically similar way."""
        lengths = "rig", "hierarchy", "inner", "leaf", "motion"
        scaled = {name: getattr(self, name).scaled(factor) for name in lengths}
        meshes = None if self.meshes is None else self.meshes.scaled(factor)
        return replace(self, **scaled, place=self.place * factor, meshes=meshes)


def rigged(prototype: Prototype | RiggedPrototype) -> RiggedPrototype:
    """Return a prototype as something that can be posed; one of one pose has no joints."""
    if isinstance(prototype, RiggedPrototype):
        return prototype
    none, nowhere = np.zeros((0, 3)), np.zeros(3)
    empty = np.zeros(0, np.int64)
    rig = Rig((), empty, none, np.zeros((0, 4)), none, none, nowhere, nowhere)

    def fixed(table: StickTable) -> RiggedSticks:
        on_frame = np.full(len(table), -1)
        return RiggedSticks.on(table, on_frame, on_frame, none)

    return RiggedPrototype(
        name=prototype.name,
        rig=rig,
        joint=np.full(len(prototype.hierarchy), -1),
        hierarchy=prototype.hierarchy,
        inner=fixed(prototype.inner),
        leaf=fixed(prototype.leaf),
        tints=prototype.tints,
        motion=rest_motion(rig),
        place=prototype.hierarchy.position,
        view_dependence=prototype.view_dependence,
        meshes=prototype.meshes,
    )


def build_hierarchy(
    rig: Rig,
    parent: Ints,
    level: Ints,
    joint: Ints,
    inner: RiggedSticks,
    leaf: RiggedSticks,
    tints: Float64[np.ndarray, "t 3"],
    twin: Ints,
) -> tuple[Hierarchy, Ints]:
    """Build the hierarchy by the rule of this file, and find the joint of each part's origin, (n,).

    joint (n,) where each would have its origin by itself; twin (n,) an earlier part that it is the
    mirror image of, or itself
    """
    n = len(parent)
    P = np.sqrt(_largest_areas(rig, leaf)[twin])
    one = representative(parent, P)
    joint = joint[one]
    own, R, separation = np.zeros(n), np.zeros(n), np.zeros(n)
    for row in np.flatnonzero(twin == np.arange(n)).tolist():
        parts = np.flatnonzero(parent == row)
        own[row] = _extent(rig, int(joint[row]), (inner, leaf), np.array([row]))
        R[row] = max(own[row], _extent(rig, int(joint[row]), (inner, leaf), parts))
        if row:
            origin = np.array([joint[row]]), np.zeros((1, 3)), np.zeros(1)
            separation[row] = reach_bound(rig, int(joint[parent[row]]), *origin)
    own, R, separation = own[twin], R[twin], separation[twin]
    position, B = rig.frames()[0][joint], bounds_of_all_below(parent, own, separation)
    lengths = max_over_tied(P, one), max_over_tied(R, one), B, separation
    contrasts = (each[one] for each in part_contrasts(parent, leaf.posed(*rig.frames()), tints))
    return Hierarchy(parent, level, position, *lengths, *contrasts), joint


def _extent(rig: Rig, joint: int, tables: tuple[RiggedSticks, ...], parts: Ints) -> float:
    """Bound how far any stick of these parts can be from a joint [m]."""
    some = [table.take(np.isin(table.owner, parts)) for table in tables]
    columns = [(table.joints, *table.spheres) for table in some]
    joints, points, radii = (np.concatenate(column) for column in zip(*columns, strict=True))
    return reach_bound(rig, joint, joints, points, radii)


def _largest_areas(rig: Rig, leaf: RiggedSticks) -> Reals:
    areas = largest_area(leaf.posed(*rig.frames()))
    # Of which parts the leaf appearance rides on more than one joint.
    n = len(leaf.first) - 1
    least, most = np.full(n, np.iinfo(np.int64).max), np.full(n, -2)
    for joints in (leaf.start_joint, leaf.end_joint):
        np.minimum.at(least, leaf.owner, joints)
        np.maximum.at(most, leaf.owner, joints)
    spans = most > least
    if spans.any():
        some = leaf.only(spans)
        straight = from_euler(np.clip(0.0, rig.low, rig.high))
        rng = np.random.Generator(np.random.Philox(0))
        for rotations in (straight, *rig.random_turns(rng, P_POSES)):
            areas = np.maximum(areas, largest_area(some.posed(*rig.frames(rotations))))
    return areas


CELLS = 24  # cells along the edge of the cube
STEP_DEG = 7.5  # largest step between angles


def reach_bound(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound the distance from a joint to the far side of spheres on other joints [m].

    joints (k,), points (k, 3) [m], radii (k,) [m]: the spheres, in the frames of their joints
        (−1 = the object's frame)
    """
    if not len(joints):
        return 0.0
    below, bound = _is_under(rig, joint)[joints + 1], 0.0
    if below.any():
        bound = _bound_below(rig, joint, joints[below], points[below], radii[below])
    for row in np.flatnonzero(~below):
        one = slice(int(row), int(row) + 1)
        bound = max(bound, _bound_across(rig, joint, joints[one], points[one], radii[one]))
    return bound * (1 + 1e-12)  # rounding, too, stays below it


def _bound_across(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound it for a sphere that does not ride on ``joint``, by the nearest joint of both [m]."""
    if joint >= 0 and rig.parent[joint] == -1 and joints[0] == -1:
        corners = np.stack(np.meshgrid(*zip(rig.shift_low, rig.shift_high, strict=True)), axis=-1)
        away = points[0] - rig.offset[joint] - corners.reshape(-1, 3)
        return float(np.linalg.norm(away, axis=1).max() + radii[0])
    common = joint
    while not _is_under(rig, common)[joints[0] + 1]:
        common = int(rig.parent[common])
    there = _bound_below(rig, common, joints, points, radii)
    return there + _bound_below(rig, common, np.array([joint]), np.zeros((1, 3)), np.zeros(1))


def _is_under(rig: Rig, joint: int) -> np.ndarray:
    under = np.zeros(len(rig) + 1, bool)
    under[joint + 1] = True
    for row, parent in enumerate(rig.parent):
        under[row + 1] |= under[parent + 1]
    return under


def _bound_below(rig: Rig, joint: int, joints: Ints, points: Points, radii: Reals) -> float:
    """Bound it for spheres that ride on ``joint``, or on joints below it [m]."""
    if joint == -1:
        moves = np.maximum(np.abs(rig.shift_low), np.abs(rig.shift_high))
        radii = radii + np.where(joints >= 0, np.linalg.norm(moves), 0.0)
    while joints[0] != joint and not points.any() and (joints == joints[0]).all():
        # Its own turn leaves a joint's origin where it is.
        points = np.broadcast_to(rig.offset[joints[0]], points.shape)
        joints = np.full_like(joints, rig.parent[joints[0]])
    if (joints == joint).all():
        return float((np.linalg.norm(points, axis=1) + radii).max())
    low, high = (frozen(np.radians(limit), np.float64) for limit in (rig.low, rig.high))
    tree = rig.parent, rig.offset, low, high
    spheres = frozen(joints, np.int64), frozen(points, np.float64), frozen(radii, np.float64)
    largest = _support(tree, joint, spheres, CELLS, math.radians(STEP_DEG))
    # The nearest direction that h is known in is at most half a cell's diagonal away.
    return float(largest / math.cos(math.atan(math.sqrt(2) / CELLS)))


@njit(cache=True)
def _support(tree, root, spheres, cells, step):  # type: ignore[no-untyped-def]
    """Compute the largest h(u)/|u| over the grid, of all spheres as seen from joint ``root``.

    tree: parents, offsets [m], least and greatest angles [rad] of a rig; spheres: their joints,
    centres and radii [m]
    """
    parent, offset, low, high = tree
    joints, points, radii = spheres
    grid = _directions(cells)
    size = len(grid)
    tables = np.full((len(parent) + 1, size), -np.inf)
    loaded = np.zeros(len(parent) + 1, np.bool_)
    for k in range(len(joints)):
        loaded[joints[k] + 1] = True
        for g in range(size):
            x, y, z = grid[g]
            reach = x * points[k, 0] + y * points[k, 1] + z * points[k, 2]
            reach += radii[k] * math.sqrt(x * x + y * y + z * z)
            tables[joints[k] + 1, g] = max(tables[joints[k] + 1, g], reach)
    for j in range(len(parent) - 1, root, -1):
        if not loaded[j + 1]:
            continue
        h = tables[j + 1]
        for axis in range(3):
            h = _sweep(h, grid, cells, axis, low[j, axis], high[j, axis], step)
        up = parent[j] + 1
        loaded[up] = True
        for g in range(size):
            x, y, z = grid[g]
            shifted = x * offset[j, 0] + y * offset[j, 1] + z * offset[j, 2] + h[g]
            tables[up, g] = max(tables[up, g], shifted)
    largest = 0.0
    for g in range(size):
        x, y, z = grid[g]
        largest = max(largest, tables[root + 1, g] / math.sqrt(x * x + y * y + z * z))
    return largest


@njit(cache=True)
def _sweep(h, grid, cells, axis, low, high, step):  # type: ignore[no-untyped-def]
    """Compute the support function of the set turned about an axis by every angle of a range."""
    steps = math.ceil((high - low) / step)
    if steps == 0 and low == 0.0:
        return h
    between = (high - low) / steps if steps else 0.0
    out = 1.0 / math.cos(between / 2)
    swept = np.full(len(grid), -np.inf)
    b, c = (axis + 1) % 3, (axis + 2) % 3
    for i in range(steps + 1):
        cos, sin = math.cos(low + i * between) * out, math.sin(low + i * between) * out
        for g in range(len(grid)):
            u, v, w = grid[g, axis], grid[g, b], grid[g, c]
            reach = _interpolated(h, cells, axis, u, cos * v + sin * w, cos * w - sin * v)
            swept[g] = max(swept[g], reach)
    return swept


@njit(cache=True, inline="always")
def _interpolated(h, cells, axis, u, v, w):  # type: ignore[no-untyped-def]
    """Bound h in a direction, bilinearly on the face of the cube that it points through.

    u, v, w: components of the direction along ``axis`` and the two axes that follow it
    """
    if abs(v) > abs(u) and abs(v) >= abs(w):
        axis, u, v, w = axis + 1, v, w, u
    elif abs(w) > abs(u):
        axis, u, v, w = axis + 2, w, u, v
    m = abs(u)
    half = 0.5 * cells / m
    s, t = v * half + 0.5 * cells, w * half + 0.5 * cells
    i, k = min(int(s), cells - 1), min(int(t), cells - 1)
    s, t = s - i, t - k
    face = 2 * (axis if axis < 3 else axis - 3) + (1 if u < 0 else 0)
    at = (face * (cells + 1) + i) * (cells + 1) + k
    low = h[at] * (1 - t) + h[at + 1] * t
    high = h[at + cells + 1] * (1 - t) + h[at + cells + 2] * t
    return m * (low * (1 - s) + high * s)


@njit(cache=True)
def _directions(cells):  # type: ignore[no-untyped-def]
    """Make the grid points on the six faces of the cube of half side 1, (6·(cells + 1)², 3)."""
    grid = np.empty((6 * (cells + 1) ** 2, 3))
    at = 0
    for face in range(6):
        axis, sign = face // 2, 1.0 - 2.0 * (face % 2)
        for i in range(cells + 1):
            for k in range(cells + 1):
                grid[at, axis] = sign
                grid[at, (axis + 1) % 3] = 2.0 * i / cells - 1.0
                grid[at, (axis + 2) % 3] = 2.0 * k / cells - 1.0
                at += 1
    return grid


def speed_bound(prototype: RiggedPrototype) -> float:
    """Bound the speed of any point of the object against where it stands [m/s], at any phase.

    A point on a joint moves with its joint's origin and with its turning, and the origin with the
    joint above: from the root down,

        speed of an origin ≤ speed of the origin above + rate of turn above · length of the offset,
        rate of a turn     ≤ rate of the turn above + angle between two keys · keys / period,

    and so for the ends of sticks. Feet that follow a slope (``leg_ik``) move faster: the body's own
    speed is added for it, which suffices for ground no steeper than 45°.
    """
    motion, rig = prototype.motion, prototype.rig
    if len(motion.rotations) == 1:
        return 0.0
    rate = len(motion.rotations) / motion.period
    after = np.roll(motion.rotations, -1, axis=0)
    cosine = np.abs((motion.rotations * after).sum(axis=-1))
    angle = 2 * np.arccos(np.clip(cosine, 0, 1)) * rate
    bob = np.linalg.norm(np.roll(motion.shift, -1, axis=0) - motion.shift, axis=-1) * rate
    speed, turning = np.zeros_like(angle), np.zeros_like(angle)
    for j, parent in enumerate(rig.parent.tolist()):
        length = float(np.linalg.norm(rig.offset[j]))
        speed[:, j] = bob if parent < 0 else speed[:, parent] + turning[:, parent] * length
        turning[:, j] = angle[:, j] + (0.0 if parent < 0 else turning[:, parent])
    # The greatest distance from each joint to what rides on it.
    reach = np.zeros(len(rig))
    ends = [(table.joints, table.spheres[0]) for table in (prototype.inner, prototype.leaf)]
    for joint, place in ((prototype.joint, prototype.place), *ends):
        on = joint >= 0
        np.maximum.at(reach, joint[on], np.linalg.norm(place[on], axis=1))
    fastest = float((speed + turning * reach).max())
    return fastest + (motion.speed if len(motion.feet) else 0.0)
