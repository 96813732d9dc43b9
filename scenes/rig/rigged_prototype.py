"""A posable object: its part hierarchy holds for every pose that the joint limits allow (§2.4).

    separation  farthest that a part's origin can be from its whole's origin, over all poses
    extent      farthest that a part's own sticks, of either appearance, can be from a point, over
        all poses
    P           √ of the largest area over directions that the leaf appearance covers; where a leaf
        appearance spans joints, the largest over the poses of ``P_POSES`` as well
    R           the greater of the extent of the part and the extents of its direct parts, from its
        origin
    B           the greater of the extent of the part and, over its parts, separation + B of the
        part

An only part that is no smaller than its whole is one with it (``lod.hierarchy``): its
origin is that of the whole, and the two share the greater P and R.

"Over all poses" is the bound of ``reach_bound``: never exceeded, and reached within a few per cent.
It is the rule of ``scenes.sticks.prototype`` with poses; a rig that cannot move gives the same
numbers.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals, freeze
from lod.errors import InputError
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.shapes import MeshTable, StickTable
from scenes.rig.keyframes import Motion, rest_motion
from scenes.rig.reach_bound import reach_bound
from scenes.rig.rig import Rig, RiggedSticks, to_object_frame
from scenes.rig.rotations import Quaternions, Vectors, from_euler
from scenes.sticks.contrast import part_contrast
from scenes.sticks.outline_area import largest_area
from scenes.sticks.prototype import Prototype
from scenes.sticks.view_dependence import ViewDependence

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
        meshes = self._posed_meshes(origin, turn)
        looks = self.tints, self.view_dependence, meshes
        return Prototype(self.name, hierarchy, inner, leaf, *looks)

    def _posed_meshes(self, origin: Vectors, turn: Quaternions) -> MeshTable | None:
        meshes = self.meshes
        if meshes is None:
            return None
        joint = self.joint[meshes.vertex_owner]
        at = to_object_frame(origin, turn, joint, meshes.vertices)
        ahead = to_object_frame(np.zeros_like(origin), turn, joint, meshes.normals)
        return replace(meshes, vertices=at, normals=ahead)

    def full_detail_sticks(self) -> tuple[RiggedSticks, RiggedSticks]:
        """Return what is shown while all parts are displayed: inner sticks, and leaf sticks of
        ends.
        """
        owns = np.zeros(len(self.joint), bool)
        owns[self.hierarchy.parent[1:]] = True
        return self.inner.only(owns), self.leaf.only(~owns)

    def with_motion(self, motion: Motion) -> "RiggedPrototype":
        """Return the same object with another motion."""
        return replace(self, motion=motion)

    def scaled(self, factor: float) -> "RiggedPrototype":
        """Return the object ``factor`` times as large, moving in a dynamically similar way."""
        return RiggedPrototype(
            self.name,
            self.rig.scaled(factor),
            self.joint,
            self.hierarchy.scaled(factor),
            self.inner.scaled(factor),
            self.leaf.scaled(factor),
            self.tints,
            self.motion.scaled(factor),
            self.place * factor,
            self.view_dependence,
            self.limbs,
            None if self.meshes is None else self.meshes.scaled(factor),
        )


def rigid_prototype(prototype: Prototype) -> RiggedPrototype:
    """Rig a prototype of one pose without joints: everything rides on the object's frame."""
    none, nowhere = np.zeros((0, 3)), np.zeros(3)
    empty = np.zeros(0, np.int64)
    rig = Rig((), empty, none, np.zeros((0, 4)), none, none, nowhere, nowhere)

    def fixed(table: StickTable) -> RiggedSticks:
        on_frame = np.full(len(table), -1)
        columns = *table.columns, on_frame, on_frame
        return RiggedSticks.of(len(table.count), table.owner, *columns)

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


def rigged(prototype: Prototype | RiggedPrototype) -> RiggedPrototype:
    """Return a prototype as something that can be posed, if only in one way."""
    return rigid_prototype(prototype) if isinstance(prototype, Prototype) else prototype


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
    B = own.copy()
    for row in range(n - 1, 0, -1):
        B[parent[row]] = max(B[parent[row]], separation[row] + B[row])
    position = rig.frames()[0][joint]
    lengths = max_over_tied(P, one), max_over_tied(R, one), B, separation
    contrast = part_contrast(parent, leaf.posed(*rig.frames()), tints)[one]
    return Hierarchy(parent, level, position, *lengths, contrast), joint


def _extent(rig: Rig, joint: int, tables: tuple[RiggedSticks, ...], parts: Ints) -> float:
    """Bound how far any stick of these parts can be from a joint [m]."""
    columns: list[tuple[Ints, Points, Reals]] = []
    for table in tables:
        rows = np.flatnonzero(np.isin(table.owner, parts))
        columns.append((table.start_joint[rows], table.start[rows], table.start_radius[rows]))
        columns.append((table.end_joint[rows], table.end[rows], table.end_radius[rows]))
    joints, points, radii = (np.concatenate(column) for column in zip(*columns, strict=True))
    return reach_bound(rig, joint, joints, points, radii)


def _largest_areas(rig: Rig, leaf: RiggedSticks) -> Reals:
    areas = largest_area(leaf.posed(*rig.frames()))
    spans = _spans_joints(leaf)
    if spans.any():
        some = leaf.only(spans)
        straight = from_euler(np.clip(0.0, rig.low, rig.high))
        rng = np.random.Generator(np.random.Philox(0))
        for rotations in (straight, *rig.random_turns(rng, P_POSES)):
            areas = np.maximum(areas, largest_area(some.posed(*rig.frames(rotations))))
    return areas


def _spans_joints(leaf: RiggedSticks) -> np.ndarray:
    """Tell of which parts the leaf appearance rides on more than one joint, (n,)."""
    n = len(leaf.first) - 1
    least, most = np.full(n, np.iinfo(np.int64).max), np.full(n, -2)
    for joints in (leaf.start_joint, leaf.end_joint):
        np.minimum.at(least, leaf.owner, joints)
        np.maximum.at(most, leaf.owner, joints)
    return most > least
