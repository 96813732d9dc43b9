"""From tables of joints, parts and rods to a posable prototype: the same way for people, animals and artifacts.

The tables name each side once, as ``figure_tables`` do: the left is given, the right is its mirror image.
Leaf appearances stand for what they hide (§2.4): their radii are fitted, in the pose at rest, so that the
mean area over directions is that of everything hidden. A part without a body of its own keeps, as an inner
node, its leaf appearance thinned to a core hidden inside its parts.
"""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import Ints, Reals
from scenes.figure_tables import Joint, Part, Rod, Vector
from scenes.rig import Rig, RiggedSticks
from scenes.rig_motion import still
from scenes.rig_prototype import RiggedPrototype, hierarchy_of
from scenes.rig_turns import turns_of
from scenes.stick_area import mean_area, mean_outline_areas
from scenes.stick_table import StickTable

CORE = 0.75
"""Radius of the hidden core, as a share of the leaf appearance's."""

SIDES = {"left": 1.0, "right": -1.0}

Limits = tuple[Vector, Vector]
FIXED: Limits = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
MEAN = "mean"
"""Material of a blob: the mean tint of everything, by outline area."""


@dataclass(frozen=True)
class Anatomy:
    """Tables of one kind of object. ``side_`` entries are given for the left and mirrored.

    rest    degrees about x, y, z of joints as it stands; absent = (0, 0, 0)
    limits  (low, high) degrees of joints; absent = the joint does not turn from rest
    shift   (low, high) how far the whole may bob and sway, in the tables' lengths
    leaf    absent = looks as it is; the root's own absent = one upright stick, as high as the object
    """

    joints: dict[str, Joint]
    side_joints: dict[str, Joint]
    parts: dict[str, Part]
    side_parts: dict[str, Part]
    body: dict[str, list[Rod]]
    side_body: dict[str, list[Rod]]
    leaf: dict[str, list[Rod]]
    side_leaf: dict[str, list[Rod]]
    rest: dict[str, Vector]
    limits: dict[str, Limits]
    shift: Limits = field(default=((-0.1, -0.06, -0.1), (0.1, 0.06, 0.06)))


@dataclass(frozen=True)
class Build:
    """How one object differs from the tables of its kind.

    height     of its highest point as it stands [m]
    girth      factor on every radius
    stretch    factors on how far out to the side a joint sits
    sizes      factors on all lengths in the frame of a joint: a child's head is larger
    materials  linear Rec.709 albedo of every material that the tables name
    """

    height: float
    materials: dict[str, tuple[float, float, float]]
    girth: float = 1.0
    stretch: dict[str, float] = field(default_factory=dict)
    sizes: dict[str, float] = field(default_factory=dict)


def rigged(name: str, anatomy: Anatomy, build: Build) -> RiggedPrototype:
    """A posable prototype at rest, with no motion yet."""
    parts = _both_sides(anatomy, anatomy.parts, anatomy.side_parts)
    row = {part: i for i, part in enumerate(parts)} | {"": -1}
    whole = np.array([row[part.whole] for part in parts.values()])
    rig = _rig(anatomy, build)
    tables = [
        _sticks(_both_sides(anatomy, *pair), row, rig, build)
        for pair in ((anatomy.body, anatomy.side_body), (anatomy.leaf, anatomy.side_leaf))
    ]
    rig, body, given = _standing(rig, *tables, build.height)
    full = _under(whole, body.posed(*rig.frames()))
    leaf, tints = _leaves(rig, body, given, full, build)
    inner = _inner(whole, body, leaf)
    joint = np.array([rig.row(part.joint) for part in parts.values()])
    level = np.array([part.level for part in parts.values()])
    twin = _twins(parts, row, rig)
    hierarchy = hierarchy_of(rig, whole, level, joint, inner, leaf, twin)
    return RiggedPrototype(name, rig, joint, hierarchy, inner, leaf, tints, still(rig))


def _twins(parts: dict[str, Part], row: dict[str, int], rig: Rig) -> Ints:
    """For each part on the right its mirror image on the left; itself where the trunk is lopsided."""
    trunk = [j for j, name in enumerate(rig.name) if name.partition(" ")[0] not in SIDES]
    even = rig.low[trunk] == -rig.high[trunk]
    if not even[:, ::2].all():
        return np.arange(len(parts))
    left = {name: name.replace("right ", "left ", 1) for name in parts if name.startswith("right ")}
    return np.array([row[left.get(name, name)] for name in parts])


def part_names(anatomy: Anatomy) -> tuple[str, ...]:
    """Names of the parts, in the order of the hierarchy's rows."""
    return tuple(_both_sides(anatomy, anatomy.parts, anatomy.side_parts))


def side_of(name: str) -> tuple[float, str]:
    """+1 on the left and in the middle, −1 on the right; and the name without its side."""
    hand, _, bare = name.partition(" ")
    return (SIDES[hand], bare) if hand in SIDES else (1.0, name)


def _both_sides(anatomy: Anatomy, trunk: dict, side: dict) -> dict:  # type: ignore[type-arg]
    """The trunk's entries, then those of the left side, then their mirror images on the right."""
    sided = anatomy.side_joints.keys() | anatomy.side_parts.keys()
    named = dict(trunk)
    for hand in SIDES:

        def here(reference: str, hand: str = hand) -> str:
            return f"{hand} {reference}" if reference in sided else reference

        for name, entry in side.items():
            named[f"{hand} {name}"] = _renamed(entry, here)
    return named


def _renamed(entry, here):  # type: ignore[no-untyped-def]
    if isinstance(entry, Joint):
        return entry._replace(parent=here(entry.parent))
    if isinstance(entry, Part):
        return entry._replace(whole=here(entry.whole), joint=here(entry.joint))
    return [rod._replace(joint=here(rod.joint)) for rod in entry]


def _rig(anatomy: Anatomy, build: Build) -> Rig:
    """Joints in the tables' lengths, both sides, with rest and limits."""
    joints = _both_sides(anatomy, anatomy.joints, anatomy.side_joints)
    row = {name: i for i, name in enumerate(joints)} | {"": -1}
    offset, rest, low, high = (np.zeros((len(joints), 3)) for _ in range(4))
    for i, (name, joint) in enumerate(joints.items()):
        side, bare = side_of(name)
        x, y, z = joint.offset
        size = build.sizes.get(side_of(joint.parent)[1], 1.0)
        offset[i] = np.array((x, side * y * build.stretch.get(bare, 1.0), z)) * size
        mirror = np.array((side, 1.0, side))
        rest[i] = np.array(_entry(anatomy.rest, name, (0.0, 0.0, 0.0))) * mirror
        limits = np.array(_entry(anatomy.limits, name, (rest[i] * mirror, rest[i] * mirror)))
        low[i], high[i] = np.sort(limits * mirror, axis=0)
    parent = np.array([row[joint.parent] for joint in joints.values()])
    shift = np.array(anatomy.shift)
    return Rig(tuple(joints), parent, offset, turns_of(rest), low, high, *shift)


def _entry(table: dict, name: str, default):  # type: ignore[no-untyped-def, type-arg]
    return table.get(name, table.get(side_of(name)[1], default))


def _sticks(
    table: dict[str, list[Rod]], row: dict[str, int], rig: Rig, build: Build
) -> RiggedSticks:
    """The rods of a table as sticks in the frames of joints."""
    material = {name: i for i, name in enumerate((*build.materials, MEAN))}
    columns = []
    for name, rods in table.items():
        side, _ = side_of(name)
        for rod in rods:
            joint = rig.row(rod.joint) if rod.joint else -1
            size = build.sizes.get(side_of(rod.joint)[1], 1.0)
            for mirror in (side, -side) if rod.pair else (side,):
                ends = [np.array((x, mirror * y, z)) * size for x, y, z in (rod.start, rod.end)]
                radii = [r * build.girth * size for r in (rod.start_radius, rod.end_radius)]
                tint = material[rod.material]
                columns.append((row[name], *ends, *radii, tint, joint, joint))
    if not columns:
        return _chosen(None, np.zeros(0, np.int64), np.zeros(0, np.int64), len(row) - 1)
    owner, *rest = (np.array(column) for column in zip(*columns, strict=True))
    return _grouped(owner, rest, len(row) - 1)


def _standing(
    rig: Rig, body: RiggedSticks, leaf: RiggedSticks, height: float
) -> tuple[Rig, RiggedSticks, RiggedSticks]:
    """All three with the lowest point on the ground and the highest at ``height`` [m]."""
    posed = body.posed(*rig.frames())
    lows = (posed.start[:, 2] - posed.start_radius, posed.end[:, 2] - posed.end_radius)
    tops = (posed.start[:, 2] + posed.start_radius, posed.end[:, 2] + posed.end_radius)
    lift, top = -min(low.min() for low in lows), max(high.max() for high in tops)
    offset = rig.offset.copy()
    offset[rig.parent < 0, 2] += lift
    lifted = Rig(
        rig.name, rig.parent, offset, rig.rest, rig.low, rig.high, rig.shift_low, rig.shift_high
    )
    factor = float(height / (top + lift))
    return lifted.scaled(factor), body.scaled(factor), leaf.scaled(factor)


_COLUMNS = ("start", "end", "start_radius", "end_radius", "tint", "start_joint", "end_joint")


def _grouped(owner: Ints, columns: list[np.ndarray], n: int) -> RiggedSticks:
    """Sticks in any order, sorted by owner."""
    order = np.argsort(owner, kind="stable")
    first = np.concatenate(([0], np.cumsum(np.bincount(owner, minlength=n))))
    return RiggedSticks(first, *(column[order] for column in columns))


def _chosen(table: RiggedSticks | None, stick: Ints, owner: Ints, n: int) -> RiggedSticks:
    if table is None:
        empty = (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
        return RiggedSticks(np.zeros(n + 1, np.int64), *empty, *(stick,) * 3)
    return _grouped(owner, [getattr(table, name)[stick] for name in _COLUMNS], n)


def _under(whole: Ints, body: StickTable) -> StickTable:
    """For every part, the bodies of itself and of everything below it, at rest."""
    owner, stick = body.owner, np.arange(len(body))
    owners, sticks = [], []
    while len(owner):
        owners.append(owner)
        sticks.append(stick)
        above = whole[owner]
        owner, stick = above[above >= 0], stick[above >= 0]
    rows = np.concatenate(sticks)
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = (getattr(body, name)[rows] for name in names)
    return StickTable.of(len(whole), np.concatenate(owners), *columns)


def _leaves(
    rig: Rig, body: RiggedSticks, given: RiggedSticks, full: StickTable, build: Build
) -> tuple[RiggedSticks, np.ndarray]:
    """Leaf appearances: the blob; those given, fitted to what they hide; the rest look as they are."""
    n = len(full.first) - 1
    materials = np.array(list(build.materials.values()))
    own = slice(full.first[0], full.first[1])
    weight = mean_outline_areas(full)[own]
    mean = (weight[:, None] * materials[full.tint[own]]).sum(axis=0) / weight.sum()
    target = mean_area(full)
    if given.first[1] == 0:
        given = _joined(n, (_upright(full, float(target[0]), len(materials)), given))
    fitted = _fitted(rig, given, target)
    given_count = np.bincount(given.owner, minlength=n)
    plain = np.flatnonzero(given_count[body.owner] == 0)
    leaf = _joined(n, (fitted, _chosen(body, plain, body.owner[plain], n)))
    return leaf, np.concatenate((materials, mean[None]))


def _upright(full: StickTable, area: float, tint: int) -> RiggedSticks:
    """The whole as one upright stick: of even radius r and height h over all, its mean area is π·r·h/2."""
    own = slice(full.first[0], full.first[1])
    tops = (full.start[own, 2] + full.start_radius[own], full.end[own, 2] + full.end_radius[own])
    height = max(float(top.max()) for top in tops)
    radius = 2 * area / (np.pi * height)
    first = np.ones(len(full.first), np.int64)
    first[0] = 0
    ends = np.array(((0.0, 0.0, radius),)), np.array(((0.0, 0.0, height - radius),))
    none = np.array([-1])
    radii = np.array([radius])
    return RiggedSticks(first, *ends, radii, radii, np.array([tint]), none, none)


def _joined(n: int, tables: tuple[RiggedSticks, ...]) -> RiggedSticks:
    owner = np.concatenate([table.owner for table in tables])
    return _grouped(
        owner, [np.concatenate([getattr(t, name) for t in tables]) for name in _COLUMNS], n
    )


def _fitted(rig: Rig, given: RiggedSticks, target: Reals, rounds: int = 4) -> RiggedSticks:
    """The same sticks with each part's radii scaled alike, so that its mean area at rest is the target."""
    rows = np.flatnonzero(np.bincount(given.owner, minlength=len(target)))
    factor = np.ones(len(target))
    frames = rig.frames()
    for _ in range(rounds):
        area = mean_area(_thickened(given, factor).posed(*frames))
        # Area grows almost in proportion to the radius of a slender stick: a fixed-point step converges.
        factor[rows] *= target[rows] / area[rows]
    return _thickened(given, factor)


def _thickened(table: RiggedSticks, factor: Reals) -> RiggedSticks:
    scale = factor[table.owner]
    radii = table.start_radius * scale, table.end_radius * scale
    joints = (table.tint, table.start_joint, table.end_joint)
    return RiggedSticks(table.first, table.start, table.end, *radii, *joints)


def _inner(whole: Ints, body: RiggedSticks, leaf: RiggedSticks) -> RiggedSticks:
    """Bodies of the parts that own parts; a thinned core for those that have no body but the blob."""
    n = len(whole)
    owns = np.zeros(n, bool)
    owns[whole[whole >= 0]] = True
    kept = np.flatnonzero(owns[body.owner])
    cores = owns & (np.bincount(body.owner, minlength=n) == 0)
    cores[0] = False
    core = np.flatnonzero(cores[leaf.owner])
    thin = _thickened(leaf, np.full(n, CORE))
    pieces = (_chosen(body, kept, body.owner[kept], n), _chosen(thin, core, leaf.owner[core], n))
    return _joined(n, pieces)
