"""How tables of joints, parts and rods become a posable prototype of a person, animal or artifact.

Leaf appearances stand for what they hide (§2.4): their radii are fitted, in the pose
at rest, so that the mean area over directions is that of everything hidden. A part without a body
of its own keeps, as an inner node, its leaf appearance thinned to a core hidden inside its parts.
"""

from dataclasses import replace

import numpy as np

from lod.arrays import Ints
from scenes.rig.anatomy import MEAN, SIDES, Anatomy, Build, Part, side_of
from scenes.rig.keyframes import rest_motion
from scenes.rig.leaf_appearance import (
    fit_leaf_appearances,
    inner_appearances,
    sticks_below,
)
from scenes.rig.rig import Rig, RiggedSticks
from scenes.rig.rigged_prototype import RiggedPrototype, build_hierarchy
from scenes.rig.rotations import from_euler
from scenes.sticks.appearance.overlap import measure_overlap


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
