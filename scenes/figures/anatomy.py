"""How tables of joints, parts and sticks become posable prototypes of people, animals, artifacts.

Each side is given once: a ``side_`` entry describes the left side, and its mirror image in the
plane y = 0 is the right side. x is forward, y to the left, z up.

Leaf appearances stand for what they hide (§2.4): their radii are fitted, in the pose at rest, so
that the mean area over directions is that of everything hidden. A part without a body of its own
keeps, as an inner node, its leaf appearance thinned to a core hidden inside its parts.
"""

import math
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from lod.arrays import Ints, Reals
from lod.shapes import StickTable
from scenes.appearance.fit import measure_overlap
from scenes.rig.rig import Rig, RiggedSticks, from_euler, rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype, build_hierarchy
from scenes.sticks.areas import mean_area, mean_outline_areas

Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
Positive = Annotated[Number, Field(gt=0)]
Share = Annotated[Number, Field(ge=0, le=1)]
Triple = tuple[Number, Number, Number]
Colour = tuple[Share, Share, Share]

SIDES = {"left": 1.0, "right": -1.0}  # sign of y on each side
MEAN = "mean"  # material of a blob: the mean tint of everything that it replaces, by outline area


class Table(BaseModel):
    """A table of a figure's file: frozen, and closed to keys that it does not know."""

    model_config = ConfigDict(frozen=True, extra="forbid")


class Joint(Table):
    """A joint of the modelling skeleton (§2.3).

    parent  the joint that carries it; "" = the animal's own frame
    at      its origin in the frame of its parent, where everything hangs at angles 0
    rest    angles about x, y, z as the animal stands [degrees]
    limits, free or hinge: (low, high) angles; as many degrees to either side; low and high about y
        alone. Without any of them the joint does not turn.
    """

    parent: str = ""
    at: Triple
    rest: Triple = (0.0, 0.0, 0.0)
    limits: tuple[Triple, Triple] | None = None
    free: Triple | None = None
    hinge: tuple[Number, Number] | None = None

    @model_validator(mode="after")
    def _one_kind_of_limit(self) -> "Joint":
        if sum(each is not None for each in (self.limits, self.free, self.hinge)) > 1:
            raise ValueError("at most one of limits, free and hinge")
        return self

    @property
    def angles(self) -> tuple[Triple, Triple]:
        """Return the lowest and the highest angles about x, y, z."""
        if self.free is not None:
            x, y, z = self.free
            return (0.0 - x, 0.0 - y, 0.0 - z), self.free
        if self.hinge is not None:
            low, high = self.hinge
            return (0.0, low, 0.0), (0.0, high, 0.0)
        return self.limits or (self.rest, self.rest)


class Rod(Table):
    """A stick: a cone with round ends in the frame of a joint.

    joint   by default that of its part
    radii   at start and end; material: a row of ``materials``, or "mean"
    pair    whether its mirror image in y = 0 is there too
    around  how many copies of it stand evenly around z
    """

    joint: str | None = None
    start: Triple
    end: Triple
    radii: tuple[Positive, Positive]
    material: str
    pair: bool = False
    around: Annotated[int, Field(ge=1)] = 1


class Part(Table):
    """A part of the detail hierarchy (figs 1, 2).

    whole  the part that owns it; only the first part of the file has none
    level  of detail; joint: the joint that its origin rides on
    body   sticks of its own, shown beside its parts
    leaf   sticks that stand for all of it; without them the part looks as it is, and the whole
           object is one upright stick as high as it
    core   sticks that a part without a body hides inside its parts; without them these are its leaf
           appearance, thinned, and for the whole object nothing
    """

    whole: str = ""
    level: Annotated[int, Field(ge=0)]
    joint: str
    body: tuple[Rod, ...] = ()
    leaf: tuple[Rod, ...] = ()
    core: tuple[Rod, ...] = ()


class Anatomy(Table):
    """Tables of one kind of object, in any one unit of length.

    shift   (low, high) how far it may sway and bob as it walks on the spot
    joints, parts  those of the trunk; ``side_``: those of the left side, mirrored on the right
    """

    shift: tuple[Triple, Triple]
    joints: dict[str, Joint]
    side_joints: dict[str, Joint] = {}
    parts: dict[str, Part]
    side_parts: dict[str, Part] = {}

    @property
    def part_names(self) -> tuple[str, ...]:
        """Return the names of the parts, in the order of the hierarchy's rows."""
        return tuple(self.both_sides(self.parts, self.side_parts))

    def both_sides(self, trunk: dict[str, Any], side: dict[str, Any]) -> dict[str, Any]:
        """Return the trunk's entries, then those of the left side, then their mirror images."""
        sided = self.side_joints.keys() | self.side_parts.keys()
        named = dict(trunk)
        for hand in SIDES:

            def here(entry: Any, *keys: str, hand: str = hand) -> dict[str, str]:
                names = {key: getattr(entry, key) for key in keys}
                return {key: f"{hand} {name}" for key, name in names.items() if name in sided}

            for name, entry in side.items():
                if isinstance(entry, Joint):
                    named[f"{hand} {name}"] = entry.model_copy(update=here(entry, "parent"))
                    continue
                rods = {
                    key: tuple(
                        rod.model_copy(update=here(rod, "joint")) for rod in getattr(entry, key)
                    )
                    for key in ("body", "leaf", "core")
                }
                changed = here(entry, "whole", "joint")
                named[f"{hand} {name}"] = entry.model_copy(update={**changed, **rods})
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


CORE = 0.75  # radius of the hidden core, as a share of the leaf appearance's


def build_prototype(name: str, anatomy: Anatomy, build: Build) -> RiggedPrototype:
    """Build a posable prototype at rest, without a motion."""
    parts = anatomy.both_sides(anatomy.parts, anatomy.side_parts)
    row = {part: i for i, part in enumerate(parts)} | {"": -1}
    parent = np.array([row[part.whole] for part in parts.values()])
    rig = _rig(anatomy, build)
    body, given, core = (_sticks(parts, key, rig, build) for key in ("body", "leaf", "core"))
    # Scaled so that the lowest point is at 0, and the highest where it is asked for.
    centre, radius = body.posed(*rig.frames()).spheres
    lift, top = -(centre[:, 2] - radius).min(), (centre[:, 2] + radius).max()
    offset = rig.offset.copy()
    offset[rig.parent < 0, 2] += lift
    factor = float(build.height / (top + lift))
    rig = replace(rig, offset=offset).scaled(factor)
    body, given, core = (table.scaled(factor) for table in (body, given, core))
    full = _sticks_below(parent, body.posed(*rig.frames()))
    leaf, tints = _fit_leaf_appearances(rig, body, given, full, build.materials)
    # Inner appearances: bodies of parts that own parts, and cores where there is none.
    owns = np.zeros(len(parent), bool)
    owns[parent[parent >= 0]] = True
    thinned = owns & (body.count == 0) & (core.count == 0)
    thinned[0] = False
    cores = leaf.only(thinned)
    cores = cores.thickened(np.full(len(cores), CORE))
    inside = RiggedSticks.merge((body.only(owns), cores, core))
    joint = np.array([rig.row(part.joint) for part in parts.values()])
    level = np.array([part.level for part in parts.values()])
    looks = inside, leaf, tints
    twin = _mirror_images(parts, row, rig)
    hierarchy, joint = build_hierarchy(rig, parent, level, joint, *looks, twin)
    at_rest = inside.posed(*rig.frames()), leaf.posed(*rig.frames())
    hierarchy = replace(hierarchy, overlap=measure_overlap(parent, level, *at_rest, tints))
    # What a joint carries is named for its first part below the whole object, or else the joint.
    below = reversed([(name, part) for name, part in parts.items() if part.whole])
    carried = {part.joint: name for name, part in below}
    limbs = tuple(carried.get(each, each) for each in rig.name)
    return RiggedPrototype(name, rig, joint, hierarchy, *looks, rest_motion(rig), limbs=limbs)


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
    joints = anatomy.both_sides(anatomy.joints, anatomy.side_joints)
    row = {name: i for i, name in enumerate(joints)} | {"": -1}
    offset, rest, low, high = (np.zeros((len(joints), 3)) for _ in range(4))
    for i, (name, joint) in enumerate(joints.items()):
        side, bare = side_of(name)
        x, y, z = joint.at
        size = build.sizes.get(side_of(joint.parent)[1], 1.0)
        offset[i] = np.array((x, side * y * build.stretch.get(bare, 1.0), z)) * size
        mirror = np.array((side, 1.0, side))
        rest[i] = np.array(joint.rest) * mirror
        low[i], high[i] = np.sort(np.array(joint.angles) * mirror, axis=0)
    parent = np.array([row[joint.parent] for joint in joints.values()])
    shift = np.array(anatomy.shift)
    return Rig(tuple(joints), parent, offset, from_euler(rest), low, high, *shift)


def _sticks(parts: dict[str, Part], key: str, rig: Rig, build: Build) -> RiggedSticks:
    material = {name: i for i, name in enumerate((*build.materials, MEAN))}
    columns: list[tuple] = []
    for row, (name, part) in enumerate(parts.items()):
        side, _ = side_of(name)
        for rod in getattr(part, key):
            on = part.joint if rod.joint is None else rod.joint
            joint = rig.row(on) if on else -1
            size = build.sizes.get(side_of(on)[1], 1.0)
            radii = [r * build.girth * size for r in rod.radii]
            shape = *radii, material[rod.material], joint, joint
            for k in range(rod.around):
                turn = math.radians(360.0 * k / rod.around)
                around = [_turned(point, turn) for point in (rod.start, rod.end)]
                for mirror in (side, -side) if rod.pair else (side,):
                    ends = [np.array((x, mirror * y, z)) * size for x, y, z in around]
                    columns.append((row, *ends, *shape))
    if not columns:
        point, none = np.zeros((0, 3)), np.zeros(0)
        return RiggedSticks.of(len(parts), none, point, point, *(none,) * 5)
    owner, *rest = (np.array(column) for column in zip(*columns, strict=True))
    return RiggedSticks.of(len(parts), owner, *rest)


def _turned(point: Triple, angle: float) -> Triple:
    x, y, z = point
    cos, sin = math.cos(angle), math.sin(angle)
    return cos * x - sin * y, sin * x + cos * y, z


def _sticks_below(parent: Ints, body: StickTable) -> StickTable:
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


def _fit_leaf_appearances(
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
        # One upright stick of mean area π·r·h/2, of radius r and height h.
        tops = full.start[own, 2] + full.start_radius[own], full.end[own, 2] + full.end_radius[own]
        height = max(float(top.max()) for top in tops)
        radius = 2 * float(target[0]) / (np.pi * height)
        ends = np.array(((0.0, 0.0, radius),)), np.array(((0.0, 0.0, height - radius),))
        radii, none, tint = np.array([radius]), np.array([-1]), np.array([len(palette)])
        owner = np.zeros(1, np.int64)
        columns = *ends, radii, radii, tint, none, none
        upright = RiggedSticks.of(len(full.count), owner, *columns)
        given = RiggedSticks.merge((upright, given))
    leaf = RiggedSticks.merge((_fit_radii(rig, given, target), body.only(given.count == 0)))
    return leaf, np.concatenate((palette, mean[None]))


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
