"""Which tables describe a kind of object: its joints, parts, sticks, rest pose and joint limits.

Each side is given once: a ``side_`` entry describes the left side, and its mirror image in the
plane y = 0 is the right side. x is forward, y to the left, z up.

How leaf appearances are fitted to what they hide, and cores of parts without a body (§2.4).

How tables of joints, parts and rods become a posable prototype of a person, animal or artifact.

Leaf appearances stand for what they hide (§2.4): their radii are fitted, in the pose
at rest, so that the mean area over directions is that of everything hidden. A part without a body
of its own keeps, as an inner node, its leaf appearance thinned to a core hidden inside its parts.
"""

from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from lod.arrays import Ints, Reals
from lod.shapes import StickTable
from scenes.appearance.fit import measure_overlap
from scenes.rig.rig import Rig, RiggedSticks, rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype, build_hierarchy
from scenes.rig.rotations import from_euler
from scenes.sticks.areas import mean_area, mean_outline_areas

Vector = tuple[float, float, float]
Limits = tuple[Vector, Vector]
Colour = tuple[float, float, float]

SIDES = {"left": 1.0, "right": -1.0}
"""Sign of y on each side."""

MEAN = "mean"
"""Material of a blob: the mean tint of everything that it replaces, by outline area."""


class Rod(NamedTuple):
    """A stick in a joint's frame: two ends, two radii, a material; ``pair``: its mirror too."""

    joint: str
    start: Vector
    end: Vector
    start_radius: float
    end_radius: float
    material: str
    pair: bool = False


class Joint(NamedTuple):
    """A joint of the modelling skeleton (§2.3): where it sits in the frame of its parent.

    rest    angles about x, y, z as the object stands [degrees]
    limits  (low, high) angles; None: the joint does not turn from rest
    """

    parent: str
    offset: Vector
    rest: Vector = (0.0, 0.0, 0.0)
    limits: Limits | None = None


class Part(NamedTuple):
    """A part of the detail hierarchy (figs 1, 2): its whole, its level, the joint at its origin.

    body  sticks of its own
    leaf  its leaf appearance; without one the part looks as it is, and the whole object is one
          upright stick as high as it
    core  sticks that a part without a body hides inside its parts; without them these are its leaf
          appearance, thinned, and for the whole object nothing
    """

    whole: str
    level: int
    joint: str
    body: tuple[Rod, ...] = ()
    leaf: tuple[Rod, ...] = ()
    core: tuple[Rod, ...] = ()


@dataclass(frozen=True)
class Anatomy:
    """Tables of one kind of object. ``side_`` entries are given for the left and mirrored.

    shift   (low, high) how far the whole may bob and sway, in the tables' lengths
    """

    joints: dict[str, Joint]
    side_joints: dict[str, Joint]
    parts: dict[str, Part]
    side_parts: dict[str, Part]
    shift: Limits

    @property
    def part_names(self) -> tuple[str, ...]:
        """Return the names of the parts, in the order of the hierarchy's rows."""
        return tuple(self.both_sides(self.parts, self.side_parts))

    def both_sides(self, trunk: dict[str, Any], side: dict[str, Any]) -> dict[str, Any]:
        """Return the trunk's entries, then those of the left side, then their mirror images."""
        sided = self.side_joints.keys() | self.side_parts.keys()
        named = dict(trunk)
        for hand in SIDES:

            def here(reference: str, hand: str = hand) -> str:
                return f"{hand} {reference}" if reference in sided else reference

            for name, entry in side.items():
                named[f"{hand} {name}"] = _with_references(entry, here)
        return named


@dataclass(frozen=True)
class Build:
    """How one object differs from the tables of its kind.

    height     of its highest point as it stands [m]
    materials  linear Rec.709 albedo of every material that the tables name
    girth      factor on every radius
    stretch    factors on how far out to the side a joint sits
    sizes      factors on all lengths in the frame of a joint: a child's head is larger
    """

    height: float
    materials: dict[str, Colour]
    girth: float = 1.0
    stretch: dict[str, float] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)


def side_of(name: str) -> tuple[float, str]:
    """Return the sign of a name's side (+1 on the left and in the middle), and the bare name."""
    hand, _, bare = name.partition(" ")
    return (SIDES[hand], bare) if hand in SIDES else (1.0, name)


def _with_references(entry, here):  # type: ignore[no-untyped-def]
    """Pass every name of a joint or part in an entry through ``here``."""
    if isinstance(entry, Joint):
        return entry._replace(parent=here(entry.parent))
    rods = (
        tuple(rod._replace(joint=here(rod.joint)) for rod in table)
        for table in (entry.body, entry.leaf, entry.core)
    )
    return Part(here(entry.whole), entry.level, here(entry.joint), *rods)


CORE = 0.75
"""Radius of the hidden core, as a share of the leaf appearance's."""


def sticks_below(parent: Ints, body: StickTable) -> StickTable:
    """Collect the sticks of every part's own body and of all parts below it, at rest."""
    owner, stick = body.owner, np.arange(len(body))
    owners, sticks = [], []
    while len(owner):
        owners.append(owner)
        sticks.append(stick)
        above = parent[owner]
        owner, stick = above[above >= 0], stick[above >= 0]
    rows = np.concatenate(sticks)
    columns = (column[rows] for column in body.columns)
    return StickTable.of(len(parent), np.concatenate(owners), *columns)


def fit_leaf_appearances(
    rig: Rig,
    body: RiggedSticks,
    given: RiggedSticks,
    full: StickTable,
    materials: dict[str, Colour],
) -> tuple[RiggedSticks, np.ndarray]:
    """Fit the leaf appearances of all parts; the palette (t, 3) gets the mean tint as its last row.

    given: sticks chosen for some parts, whose radii are fitted so that their mean area over
        directions is that of everything they hide (``full``); other parts look as their bodies do.
        The whole object without any is one upright stick of the mean tint.
    """
    palette = np.array(list(materials.values()))
    own = slice(full.first[0], full.first[1])
    weight = mean_outline_areas(full)[own]
    mean = (weight[:, None] * palette[full.tint[own]]).sum(axis=0) / weight.sum()
    target = mean_area(full)
    if given.first[1] == 0:
        given = RiggedSticks.merge((_upright_stick(full, float(target[0]), len(palette)), given))
    leaf = RiggedSticks.merge((_fit_radii(rig, given, target), body.only(given.count == 0)))
    return leaf, np.concatenate((palette, mean[None]))


def _upright_stick(full: StickTable, area: float, tint: int) -> RiggedSticks:
    """Make the whole one upright stick of mean area π·r·h/2, of radius r and height h."""
    own = slice(full.first[0], full.first[1])
    tops = (full.start[own, 2] + full.start_radius[own], full.end[own, 2] + full.end_radius[own])
    height = max(float(top.max()) for top in tops)
    radius = 2 * area / (np.pi * height)
    ends = np.array(((0.0, 0.0, radius),)), np.array(((0.0, 0.0, height - radius),))
    radii, none = np.array([radius]), np.array([-1])
    owner, tints = np.zeros(1, np.int64), np.array([tint])
    return RiggedSticks.of(len(full.count), owner, *ends, radii, radii, tints, none, none)


def _fit_radii(rig: Rig, given: RiggedSticks, target: Reals, rounds: int = 4) -> RiggedSticks:
    """Scale the radii of sticks part by part, so that mean areas at rest are the targets [m²]."""
    rows = np.flatnonzero(given.count)
    factor = np.ones(len(target))
    frames = rig.frames()
    for _ in range(rounds):
        area = mean_area(given.thickened(factor[given.owner]).posed(*frames))
        # Area is almost in proportion to the radius of a slender stick: this converges.
        factor[rows] *= target[rows] / area[rows]
    return given.thickened(factor[given.owner])


def inner_appearances(
    parent: Ints, body: RiggedSticks, leaf: RiggedSticks, given: RiggedSticks
) -> RiggedSticks:
    """Choose the inner appearances: bodies of parts that own parts, and cores where there is none.

    ``given`` holds cores chosen for some parts; elsewhere the core is the leaf appearance, thinned.
    The whole object has no core unless one is given.
    """
    owns = np.zeros(len(parent), bool)
    owns[parent[parent >= 0]] = True
    cores = owns & (body.count == 0) & (given.count == 0)
    cores[0] = False
    core = leaf.only(cores)
    return RiggedSticks.merge((body.only(owns), core.thickened(np.full(len(core), CORE)), given))


def build_prototype(name: str, anatomy: Anatomy, build: Build) -> RiggedPrototype:
    """Build a posable prototype at rest, without a motion."""
    parts = anatomy.both_sides(anatomy.parts, anatomy.side_parts)
    row = {part: i for i, part in enumerate(parts)} | {"": -1}
    parent = np.array([row[part.whole] for part in parts.values()])
    rig = _rig(anatomy, build)
    body, given, core = (_sticks(parts, key, rig, build) for key in ("body", "leaf", "core"))
    rig, (body, given, core) = _scale_to_height(rig, (body, given, core), build.height)
    full = sticks_below(parent, body.posed(*rig.frames()))
    leaf, tints = fit_leaf_appearances(rig, body, given, full, build.materials)
    inside = inner_appearances(parent, body, leaf, core)
    joint = np.array([rig.row(part.joint) for part in parts.values()])
    level = np.array([part.level for part in parts.values()])
    twin = _mirror_images(parts, row, rig)
    tables = inside, leaf, tints
    hierarchy, joint = build_hierarchy(rig, parent, level, joint, *tables, twin)
    at_rest = inside.posed(*rig.frames()), leaf.posed(*rig.frames())
    hierarchy = replace(hierarchy, overlap=measure_overlap(parent, level, *at_rest, tints))
    looks = inside, leaf, tints
    limbs = _limbs(parts, rig)
    return RiggedPrototype(name, rig, joint, hierarchy, *looks, rest_motion(rig), limbs=limbs)


def _limbs(parts: dict[str, Part], rig: Rig) -> tuple[str, ...]:
    """Name what each joint carries: its first part below the whole object, or else the joint."""
    below = reversed([(name, part) for name, part in parts.items() if part.whole])
    carried = {part.joint: name for name, part in below}
    return tuple(carried.get(joint, joint) for joint in rig.name)


def _mirror_images(parts: dict[str, Part], row: dict[str, int], rig: Rig) -> Ints:
    """Find the mirror image on the left of each part on the right; all others have themselves.

    Where limits of the trunk are not symmetric, no part is the mirror image of another.
    """
    trunk = [j for j, name in enumerate(rig.name) if name.partition(" ")[0] not in SIDES]
    even = rig.low[trunk] == -rig.high[trunk]
    if not even[:, ::2].all():
        return np.arange(len(parts))
    left = {name: name.replace("right ", "left ", 1) for name in parts if name.startswith("right ")}
    return np.array([row[left.get(name, name)] for name in parts])


def _rig(anatomy: Anatomy, build: Build) -> Rig:
    """Make the joints of both sides in the tables' lengths, with rest and limits."""
    joints = anatomy.both_sides(anatomy.joints, anatomy.side_joints)
    row = {name: i for i, name in enumerate(joints)} | {"": -1}
    offset, rest, low, high = (np.zeros((len(joints), 3)) for _ in range(4))
    for i, (name, joint) in enumerate(joints.items()):
        side, bare = side_of(name)
        x, y, z = joint.offset
        size = build.sizes.get(side_of(joint.parent)[1], 1.0)
        offset[i] = np.array((x, side * y * build.stretch.get(bare, 1.0), z)) * size
        mirror = np.array((side, 1.0, side))
        rest[i] = np.array(joint.rest) * mirror
        limits = np.array(joint.limits or (joint.rest, joint.rest))
        low[i], high[i] = np.sort(limits * mirror, axis=0)
    parent = np.array([row[joint.parent] for joint in joints.values()])
    shift = np.array(anatomy.shift)
    return Rig(tuple(joints), parent, offset, from_euler(rest), low, high, *shift)


def _sticks(parts: dict[str, Part], key: str, rig: Rig, build: Build) -> RiggedSticks:
    """Make the rods that parts have under one key sticks in the frames of joints."""
    material = {name: i for i, name in enumerate((*build.materials, MEAN))}
    columns: list[tuple] = []
    for row, (name, part) in enumerate(parts.items()):
        side, _ = side_of(name)
        for rod in getattr(part, key):
            joint = rig.row(rod.joint) if rod.joint else -1
            size = build.sizes.get(side_of(rod.joint)[1], 1.0)
            for mirror in (side, -side) if rod.pair else (side,):
                ends = [np.array((x, mirror * y, z)) * size for x, y, z in (rod.start, rod.end)]
                radii = [r * build.girth * size for r in (rod.start_radius, rod.end_radius)]
                tint = material[rod.material]
                columns.append((row, *ends, *radii, tint, joint, joint))
    if not columns:
        point, none = np.zeros((0, 3)), np.zeros(0)
        return RiggedSticks.of(len(parts), none, point, point, *(none,) * 5)
    owner, *rest = (np.array(column) for column in zip(*columns, strict=True))
    return RiggedSticks.of(len(parts), owner, *rest)


def _scale_to_height(
    rig: Rig, tables: tuple[RiggedSticks, ...], height: float
) -> tuple[Rig, tuple[RiggedSticks, ...]]:
    """Scale rig and tables: the lowest point of the first is at 0, the highest at ``height`` m."""
    posed = tables[0].posed(*rig.frames())
    lows = (posed.start[:, 2] - posed.start_radius, posed.end[:, 2] - posed.end_radius)
    tops = (posed.start[:, 2] + posed.start_radius, posed.end[:, 2] + posed.end_radius)
    lift, top = -min(low.min() for low in lows), max(high.max() for high in tops)
    offset = rig.offset.copy()
    offset[rig.parent < 0, 2] += lift
    lifted = Rig(
        rig.name, rig.parent, offset, rig.rest, rig.low, rig.high, rig.shift_low, rig.shift_high
    )
    factor = float(height / (top + lift))
    return lifted.scaled(factor), tuple(table.scaled(factor) for table in tables)
