"""Prototypes of trees, still, and swaying in the wind.

Level 0 is the whole tree, and as an inner node the trunk; 1 limbs; 2 branches; then twigs, where a
species has them; last the foliage, leaf by leaf. A part's origin is the base of its branch, or the
middle of its leaf; the whole tree's is the foot of the trunk, on the ground. As an inner node a
branch is its own chain of sticks. Its leaf appearance is a few blobs and what is kept of that
chain, which cover on average over directions what the hidden branches and leaves would
(``scenes.appearance``).

Where a species says so, leaves are drawn flat, folded a little along the midrib and turned at
random about it. In the mean over directions each covers as much as the stick that it is counted as,
by which P, R, B and all shapes above it are fitted; their tone is fitted to the leaves.

In the wind the trunk bends at three joints, and each limb turns at its base with all that it bears;
branches, twigs and leaves ride on their limb. Angles are sums of a few harmonics of one long cycle,
so that a tree sways evenly and comes back to where it began. Drag grows as the square of the wind's
speed, and so do the angles; the amounts are chosen by eye. Without wind there are no joints at all.

How far anything can get is bounded in closed form. A turn by angle a about a joint moves a point r
from it by 2·r·sin(a/2); turns of joints further down carry that along unchanged. So what rides on
joints j of a chain moves, as seen from anything above them, at most Σⱼ 2·rⱼ·sin(aⱼ/2), with rⱼ of
the tree at rest. Only the range R and the bound B of the whole tree, and the separation of limbs
from it, are larger than those of the tree at rest. All else rides on one joint with its whole and
keeps R, B and the priority P, because the leaf appearance of the whole tree leans as one.

Growth of a tree: trunk, limbs, branches, twigs and leaves, level by level.

After Weber & Penn (SIGGRAPH 1995): equations for lengths, radii, flare and placement are theirs,
cited by section; tropism and random bending are simplified to a turn per segment. All branches of
a level grow at once.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals, expand
from lod.hierarchy import Hierarchy
from lod.shapes import MeshTable, StickTable
from scenes.appearance.fit import fit_appearances
from scenes.rig.rig import Motion, Rig, RiggedSticks, from_euler, key_phases
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import mean_outline_areas
from scenes.sticks.prototype import PartPlaces, PartSticks, Prototype, assemble_prototype
from scenes.trees.species import BranchLevel, Foliage, TreeSpecies

STEEPEST = -0.3
"""Least z of the direction in which a branch begins: lower ones would find no light."""


@dataclass(frozen=True, eq=False)
class Branches:
    """All branches of one level.

    parent  (n,) row of the parent in the level before; −1 for the trunk
    nodes   (n, s + 1, 3) points of the chain of s segments [m]
    radii   (n, s + 1) radii at these points [m]
    length  (n,) length of the chain [m]
    """

    parent: np.ndarray
    nodes: np.ndarray
    radii: np.ndarray
    length: np.ndarray

    def __len__(self) -> int:
        return len(self.parent)


@dataclass(frozen=True, eq=False)
class GrownFoliage:
    """The foliage that has grown: the single leaves of all twigs.

    twig                      (k,) row of the twig that bears each leaf, in rising order
    start, end                (k, 3) its two ends [m]
    start_radius, end_radius  (k,) its radii there [m]
    """

    twig: np.ndarray
    start: np.ndarray
    end: np.ndarray
    start_radius: np.ndarray
    end_radius: np.ndarray


def grow(species: TreeSpecies, rng: np.random.Generator) -> tuple[list[Branches], GrownFoliage]:
    """Grow a tree at the origin: its levels of branches from the trunk on, and its foliage."""
    levels = [_trunk(species, rng)]
    for number, level in enumerate(species.levels):
        shape = species.shape if number == 0 else None
        levels.append(_children(levels[-1], level, shape, species, rng))
    if species.foliage is None:
        nothing = np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0)
        return levels, GrownFoliage(np.zeros(0, np.int64), *nothing)
    return levels, _grow_foliage(levels[-1], species.foliage, rng)


def _trunk(species: TreeSpecies, rng: np.random.Generator) -> Branches:
    trunk = species.trunk
    height = species.scale + species.scale_v * float(np.clip(rng.normal(), -2, 2))
    length, segments = trunk.length * height, 7
    up = np.array([[0.0, 0.0, 1.0]])
    nodes = _chain(np.zeros((1, 3)), up, np.array([length]), segments, 0.15, trunk.curve_v, rng)
    z = np.linspace(0, 1, segments + 1)
    # §4.4: a linear taper, and near the ground a flare that falls off exponentially.
    flare = 1 + trunk.flare * (100.0 ** np.maximum(0, 1 - 8 * z) - 1) / 100
    radii = trunk.ratio * height * (1 - trunk.taper * z) * flare
    foot = nodes[:, :1] - (0.0, 0.0, trunk.root_depth)
    nodes = np.concatenate((foot, nodes), axis=1)
    radii = np.concatenate(([radii[0] * 1.08], radii))[None]
    return Branches(np.array([-1]), nodes, radii, np.array([length]))


def _children(
    parents: Branches,
    level: BranchLevel,
    shape: tuple[tuple[float, float], ...] | None,
    species: TreeSpecies,
    rng: np.random.Generator,
) -> Branches:
    """Grow the branches of one level along and around their parents (Weber & Penn 1995 §4.3)."""
    parent, along, around = _places(parents, level, rng)
    base, heading, radius = _at(parents, parent, along)
    down = level.down_angle_base + (level.down_angle_tip - level.down_angle_base) * along
    down = np.radians(down + level.angle_v * rng.normal(size=len(parent)))
    side, other = _across(heading)
    outward = np.cos(around)[:, None] * side + np.sin(around)[:, None] * other
    start = np.cos(down)[:, None] * heading + np.sin(down)[:, None] * outward
    start[:, 2] = np.maximum(start[:, 2], STEEPEST)
    start = _unit(start)
    if shape is None:
        share = 1 - level.length_falloff * along
    else:
        crown = (along - level.base_size) / (1 - level.base_size)
        height, limb = np.array(shape).T
        share = np.interp(crown, height, limb)
    length = level.length * share * parents.length[parent] * rng.uniform(0.94, 1.06, len(parent))
    snapped = rng.random(len(parent)) < species.broken_share
    length *= np.where(snapped, rng.uniform(0.25, 0.7, len(parent)), 1.0)
    nodes = _chain(base, start, length, level.curve_res, level.attraction_up, level.curve_v, rng)
    # §4.4: radius by the ratio of lengths, never thicker than what bears it.
    thick = (length / parents.length[parent]) ** level.ratio_power * parents.radii[
        parent, _skip(parents)
    ]
    thick = np.maximum(np.minimum(thick, 0.85 * radius), species.min_radius)
    tip = np.where(snapped, 0.75, 0.35)[:, None]
    taper = 1 - (1 - tip) * np.linspace(0, 1, level.curve_res + 1)
    radii = np.maximum(thick[:, None] * taper, species.min_radius)
    return Branches(parent, nodes, radii, length)


def _places(
    parents: Branches, level: BranchLevel, rng: np.random.Generator
) -> tuple[Ints, Reals, Reals]:
    # §4.3: short parents bear fewer children.
    mean = level.branches * (0.25 + 0.75 * parents.length / parents.length.max())
    count = np.maximum(2, np.floor(mean + rng.random(len(parents)))).astype(np.int64)
    parent, number = expand(count)
    step = (number + 0.5 + 0.35 * rng.uniform(-1, 1, len(parent))) / count[parent]
    along = level.base_size + (0.99 - level.base_size) * step
    if level.two_ranked:  # on either side in turn, level
        around = 180.0 * (number % 2)
    else:
        around = rng.uniform(0, 360, len(parents))[parent] + level.rotate * number
    return parent, along, np.radians(around + level.angle_v * rng.normal(size=len(parent)))


def _at(parents: Branches, parent: Ints, along: Reals) -> tuple[Points, Points, Reals]:
    nodes, radii = parents.nodes[:, _skip(parents) :], parents.radii[:, _skip(parents) :]
    segments = nodes.shape[1] - 1
    segment = np.minimum((along * segments).astype(np.int64), segments - 1)
    rest = along * segments - segment
    a, b = nodes[parent, segment], nodes[parent, segment + 1]
    radius = (1 - rest) * radii[parent, segment] + rest * radii[parent, segment + 1]
    return a + rest[:, None] * (b - a), _unit(b - a), radius


def _skip(branches: Branches) -> int:
    """Count the first segments that bear nothing: the trunk's first, which is under the ground."""
    return 1 if branches.parent[0] == -1 else 0


def _chain(
    base: Points,
    heading: Points,
    length: Reals,
    segments: int,
    lift: float,
    wander: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Make chains (n, s + 1, 3) that turn up by ``lift`` and at random by ``wander`` [°]."""
    nodes = np.empty((len(base), segments + 1, 3))
    nodes[:, 0] = base
    for k in range(segments):
        bend = np.radians(wander) * rng.normal(size=heading.shape)
        bend[:, 2] += lift / segments
        heading = _unit(heading + bend) if k else heading
        nodes[:, k + 1] = nodes[:, k] + heading * (length / segments)[:, None]
    return nodes


def _grow_foliage(twigs: Branches, f: Foliage, rng: np.random.Generator) -> GrownFoliage:
    """Grow leaves along the outer part of each twig, which stand off it and turn to the light."""
    share = twigs.length / twigs.length.max()
    count = np.maximum(3, np.rint(f.leaves * np.sqrt(share))).astype(np.int64)
    twig, number = expand(count)
    n = len(twig)
    step = (number + 0.5) / count[twig]
    along = np.clip(0.10 + 0.95 * step + 0.06 * rng.normal(size=n), 0, 1)
    point, heading, _ = _at(twigs, twig, along)
    side, other = _across(heading)
    turn, loose, scatter = (180.0, 12.0, 0.15) if f.two_ranked else (137.5, 40.0, 0.35)
    around = np.radians(turn * number + loose * rng.normal(size=n))
    outward = np.cos(around)[:, None] * side + np.sin(around)[:, None] * other
    pointing = outward + f.forward_lean * heading + scatter * rng.normal(size=(n, 3))
    pointing[:, 2] += f.upturn
    pointing = _unit(pointing)
    size = rng.uniform(0.75, 1.25, n)
    start = point + f.offset * rng.uniform(0.2, 1.0, n)[:, None] * outward
    end = start + pointing * (f.length * size)[:, None]
    return GrownFoliage(twig, start, end, f.base_radius * size, f.tip_radius * size)


def _across(heading: Points) -> tuple[Points, Points]:
    """Make two unit vectors across each heading, the first horizontal unless that is vertical."""
    upright = np.abs(heading[:, 2:]) > 0.999
    side = _unit(np.cross(np.where(upright, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), heading))
    return side, _unit(np.cross(heading, side))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt((vectors**2).sum(axis=-1, keepdims=True))


@dataclass(frozen=True, eq=False)
class GrownTree:
    """A grown tree with its colours.

    levels    branches of each level, from the trunk (0) to the twigs
    foliage   leaves of all twigs; foliage_tint (k,) row of the palette of each leaf
    palette   (t, 3) linear Rec.709 albedo; rows 0 and 1 are the bark of trunk and of branches, the
              last one that of young twigs
    """

    species: TreeSpecies
    levels: list[Branches]
    foliage: GrownFoliage
    foliage_tint: np.ndarray
    palette: np.ndarray


_STREAM, _SWAY_STREAM = 0x7EE, 0x5A7


@lru_cache(maxsize=32)
def tree_prototypes(
    seed: int, count: int, species: TreeSpecies, season: str = "summer"
) -> tuple[Prototype, ...]:
    """Make ``count`` trees of a species; the k-th depends on the seed, the season and k only."""
    return tuple(
        _prototype(f"{species.name} {k}", grow_tree(species, seed, k, season)) for k in range(count)
    )


def grow_tree(species: TreeSpecies, seed: int, k: int, season: str = "summer") -> GrownTree:
    """Grow the k-th tree of a seed; its wood is the same in every season."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    shades = species.foliage_colours(season)
    if not shades:
        species = replace(species, foliage=None)
    levels, foliage = grow(species, rng)
    bark = np.array(species.bark_albedo)
    if not shades:
        blends = [(1 - share) * bark[0] + share * bark[1] for share in (0.33, 0.67)]
        palette = np.vstack((bark, blends))
        return GrownTree(species, levels, foliage, np.zeros(0, np.int64), palette)
    # Every branch has its own shade, and every leaf its own about that.
    branch, limbs = np.arange(len(levels[-1])), min(2, len(levels) - 1)
    for level in levels[:limbs:-1]:
        branch = level.parent[branch]
    of_branch = rng.normal(size=len(levels[limbs]))
    tone = 0.7 * of_branch[branch[foliage.twig]] + 0.7 * rng.normal(size=len(foliage.twig))
    middle = (len(shades) - 1) / 2
    shade = np.clip(np.rint(middle + tone), 0, len(shades) - 1).astype(np.int64)
    albedo = np.array(shades)
    blends = [(1 - s) * albedo[int(middle)] + s * bark[1] for s in (0.25, 0.5)]
    palette = np.vstack((bark, albedo, blends))
    return GrownTree(species, levels, foliage, len(bark) + shade, palette)


def _prototype(name: str, tree: GrownTree) -> Prototype:
    levels, foliage = tree.levels, tree.foliage
    counts = [len(level) for level in levels]
    tables, leaves = [], len(foliage.twig)
    for k, each in enumerate(levels):  # every branch a part, twigs among leaves half green
        young = 0 < k == len(levels) - 1 and leaves > 0
        owner = np.repeat(np.arange(len(each)), each.nodes.shape[1] - 1)
        ends = each.nodes[:, :-1].reshape(-1, 3), each.nodes[:, 1:].reshape(-1, 3)
        radii = each.radii[:, :-1].ravel(), each.radii[:, 1:].ravel()
        tint = np.full(len(owner), len(tree.palette) - 1 if young else min(k, 1))
        tables.append(StickTable.of(len(each), owner, *ends, *radii, tint))
    if leaves:  # and every leaf
        counts.append(leaves)
        columns = foliage.start, foliage.end, foliage.start_radius, foliage.end_radius
        grown = StickTable.of(leaves, np.arange(leaves), *columns, tree.foliage_tint)
        tables.append(grown)
    row = [0, *np.cumsum(counts).tolist()]  # first of each level, and the number of parts
    above = [row[k - 1] + levels[k].parent for k in range(1, len(levels))]
    bases = [level.nodes[:, 0] for level in levels[1:]]
    parent = np.concatenate(([-1], *above, row[len(levels) - 1] + foliage.twig))
    level = np.repeat(np.arange(len(counts)), counts)
    origin = np.concatenate((np.zeros((1, 3)), *bases, (foliage.start + foliage.end) / 2))
    own = StickTable.merge([t.with_owner(row[-1], t.owner + row[k]) for k, t in enumerate(tables)])
    parts = PartSticks(parent, level, own, tree.palette)
    fitted = fit_appearances(parts)
    counted = assemble_prototype(
        name,
        PartPlaces(parent, level, origin, fitted.overlap),
        own.only(parts.owns),
        fitted.leaf,
        tints=tree.palette,
        view_dependence=fitted.view_dependence,
    )
    if not leaves or tree.species.foliage is None or not tree.species.foliage.flat:
        return counted
    return replace(counted, meshes=_flat_leaves(grown, tree.palette, counted.hierarchy))


_OUTLINE = np.array(((0, 0), (0.3, -1), (0.3, 1), (0.72, -0.95), (0.72, 0.95), (1, 0)))
_HALVES = np.array(((0, 1, 3), (0, 3, 5), (0, 4, 2), (0, 5, 4)))
"""Corners of a leaf, along it over its length and across it over half its width, and triangles."""

_OUTLINE_AREA = 1.385
_FOLD = math.radians(15)
"""Area of the outline, and how far either half of a leaf is turned up about its midrib [rad]."""


def _flat_leaves(sticks: StickTable, palette: Points, h: Hierarchy) -> MeshTable:
    """Make a folded leaf of each stick; those are the last parts of a hierarchy."""
    n, first, (x, y) = len(sticks), len(h) - len(sticks), _OUTLINE.T[:, None, :, None]
    along = sticks.end - sticks.start
    length = np.linalg.norm(along, axis=1) + sticks.start_radius + sticks.end_radius
    along = _unit(along)
    # Of a folded leaf (1 + cos)/4 of the area is seen on average over directions.
    width = 4 * mean_outline_areas(sticks) / (_OUTLINE_AREA * (1 + math.cos(_FOLD)) * length)
    base = (sticks.start - sticks.start_radius[:, None] * along)[:, None]
    spine = base + x * length[:, None, None] * along[:, None]
    side, other = _across(along)
    turn = 2 * np.pi * ((np.arange(n) * (math.sqrt(5) - 1) / 2) % 1)[:, None]  # evenly (Weyl)
    across, twig = np.cos(turn) * side + np.sin(turn) * other, h.parent[first:]
    from_twig = spine.mean(axis=1) - h.position[twig]
    for _ in range(2):
        face = np.cross(along, across)[:, None]
        aside = y * math.cos(_FOLD) * across[:, None] + np.abs(y) * math.sin(_FOLD) * face
        vertices = spine + width[:, None, None] * aside
        reach = np.linalg.norm(vertices - h.position[twig][:, None], axis=2).max(axis=1)
        # A leaf that would reach beyond the R of its twig is turned across the way from there.
        across = np.where((reach > h.R[twig])[:, None], _unit(np.cross(along, from_twig)), across)
    normals = _unit(face - np.sign(y) * math.tan(_FOLD) * across[:, None])
    corners, faces = len(_OUTLINE), len(_HALVES)
    own = np.maximum(np.arange(len(h) + 1) - first, 0)
    return MeshTable(
        corners * own,
        faces * own,
        vertices.reshape(-1, 3),
        spine.reshape(-1, 3),
        normals.reshape(-1, 3),
        np.repeat(palette[sticks.tint], corners, axis=0),
        (_HALVES + corners * np.arange(n)[:, None, None]).reshape(-1, 3),
    )


TRUNK_DEG, LIMB_DEG = 0.6, 2.5
"""Most that a joint of the trunk, and a limb, turns about either level axis at GALE_M_S."""

GALE_M_S = 10.0
"""Wind's speed at which the angles are TRUNK_DEG and LIMB_DEG [m/s]."""

TRUNK_JOINTS = 3

CYCLE_S = 20.0
"""Cycle of a tree 10 m high [s]; it grows with the root of the height, as a pendulum's."""

TRUNK_BEATS, LIMB_BEATS = (4, 5, 7), (5, 6, 8, 11)
"""Harmonics of the cycle: a trunk 10 m high sways at 0.2 to 0.35 Hz, its limbs up to 0.55 Hz."""

KEYS = 256
"""Key poses in a cycle."""


@lru_cache(maxsize=32)
def swaying_trees(
    seed: int, count: int, species: TreeSpecies, season: str, wind: float
) -> tuple[RiggedPrototype, ...]:
    """Make the trees of ``tree_prototypes`` sway in a wind of that speed [m/s]."""
    trees = tree_prototypes(seed, count, species, season)
    seeds = (np.random.SeedSequence((seed, _SWAY_STREAM, k)) for k in range(count))
    rngs = (np.random.Generator(np.random.Philox(each)) for each in seeds)
    return tuple(swaying(tree, wind, rng) for tree, rng in zip(trees, rngs, strict=True))


def swaying(
    tree: Prototype,
    wind: float,
    rng: np.random.Generator,
    most_deg: tuple[float, float] = (TRUNK_DEG, LIMB_DEG),
    feet: Points | None = None,
) -> RiggedPrototype:
    """Make the trunk and the limbs of a tree sway in a wind of that speed [m/s].

    most_deg  most that a joint of the trunk, and a limb, turns at GALE_M_S
    feet      points (l, 3) about which the limbs turn; by default their origins [m]
    """
    h = tree.hierarchy
    limbs = np.flatnonzero(h.level == 1)
    # The trunk's joints stand evenly along it, from its foot on the ground up.
    trunk = tree.inner.start[1 : tree.inner.first[1]]  # its first stick is under the ground
    trunk = trunk[np.arange(TRUNK_JOINTS) * len(trunk) // TRUNK_JOINTS]
    at = np.concatenate((trunk, h.position[limbs] if feet is None else feet))
    # A limb's parent is the trunk's highest joint that is not above it.
    below = np.searchsorted(trunk[:, 2], at[TRUNK_JOINTS:, 2] + 1e-9) - 1
    parent = np.concatenate((np.arange(TRUNK_JOINTS) - 1, np.maximum(below, 0)))
    most = np.where(np.arange(len(at)) < TRUNK_JOINTS, *most_deg)
    rig = _rig(at, parent, most * (wind / GALE_M_S) ** 2)
    # All else rides with its limb; the whole tree rides on the trunk's first joint.
    joint = np.zeros(len(h), np.int64)
    joint[limbs] = TRUNK_JOINTS + np.arange(len(limbs))
    for level in range(2, int(h.level.max()) + 1):
        rows = np.flatnonzero(h.level == level)
        joint[rows] = joint[h.parent[rows]]
    # As the trunk bends, each end of its sticks rides on the joint below.
    ends = []
    for points in (tree.inner.start, tree.inner.end):
        on = joint[tree.inner.owner]
        own = tree.inner.owner == 0
        on[own] = np.maximum(np.searchsorted(trunk[:, 2], points[own, 2] - 1e-9) - 1, 0)
        ends.append(on)
    of_leaf, meshes = joint[tree.leaf.owner], tree.meshes
    if meshes is not None:
        own = at[joint][meshes.vertex_owner]
        meshes = replace(meshes, vertices=meshes.vertices - own, spine=meshes.spine - own)
    return RiggedPrototype(
        tree.name,
        rig,
        joint,
        replace(h, **_reaches(tree, rig, joint, at)),
        RiggedSticks.on(tree.inner, ends[0], ends[1], at),
        RiggedSticks.on(tree.leaf, of_leaf, of_leaf, at),
        tree.tints,
        _motion(rig, float(h.position[:, 2].max()), rng),
        h.position - at[joint],
        tree.view_dependence,
        meshes=meshes,
    )


def _rig(at: Points, parent: Ints, most_deg: Reals) -> Rig:
    offset = at - np.where((parent >= 0)[:, None], at[parent], 0.0)
    high = np.stack((most_deg, most_deg, np.zeros(len(at))), axis=1)
    names = [f"trunk {k}" for k in range(TRUNK_JOINTS)]
    names += [f"limb {k}" for k in range(len(at) - TRUNK_JOINTS)]
    rest = from_euler(np.zeros((len(at), 3)))
    return Rig(tuple(names), parent, offset, rest, -high, high, np.zeros(3), np.zeros(3))


def _reaches(
    tree: Prototype, rig: Rig, joint: Ints, at: Float64[np.ndarray, "j 3"]
) -> dict[str, np.ndarray]:
    """Compute R, B and separation for every pose.

    They grow for the whole tree and its limbs only, which move as seen from the tree's foot.
    """
    h = tree.hierarchy
    limbs = np.flatnonzero(h.level == 1)
    # 2·sin(a/2) of each joint's largest turn a: of Ry·Rx, cos(a/2) = cos(x/2)·cos(y/2).
    cosine = np.cos(np.radians(rig.high[:, 0]) / 2) * np.cos(np.radians(rig.high[:, 1]) / 2)
    moves = 2 * np.sqrt(1 - cosine**2)
    direct = np.zeros(len(h), bool)
    direct[0] = direct[limbs] = True
    reach = 0.0
    for table in (tree.inner, tree.leaf):
        owner = np.tile(table.owner, 2)
        rows = np.flatnonzero(direct[owner])
        points, radii = (column[rows] for column in table.spheres)
        on = np.where(owner[rows] == 0, TRUNK_JOINTS - 1, joint[owner[rows]])
        far = _farthest(points, on, rig.parent, at, moves) + radii
        reach = max(reach, float(far.max()))
    if tree.meshes is not None:
        owner = tree.meshes.vertex_owner
        rows = np.flatnonzero(direct[owner])
        far = _farthest(tree.meshes.vertices[rows], joint[owner[rows]], rig.parent, at, moves)
        reach = max(reach, float(far.max(initial=0.0)))
    separation, R, B = h.separation.copy(), h.R.copy(), h.B.copy()
    separation[limbs] = _farthest(h.position[limbs], joint[limbs], rig.parent, at, moves)
    R[0] = max(R[0], reach)
    B[0] = max(B[0], reach, float((separation[limbs] + B[limbs]).max()))
    return {"R": R, "B": B, "separation": separation}


def _farthest(
    points: Points, on: Ints, parent: np.ndarray, at: np.ndarray, moves: np.ndarray
) -> Reals:
    """Bound how far points (n, 3) riding on joints (n,) get from the tree's foot, (n,) [m]."""
    far, joint = np.linalg.norm(points - at[0], axis=1), on.copy()
    while (joint > 0).any():  # joint 0 is the foot itself
        up = joint > 0
        arm = np.linalg.norm(points - at[joint], axis=1)
        far[up] += (moves[joint] * arm)[up]
        joint[up] = parent[joint[up]]
    return far


def _motion(rig: Rig, height: float, rng: np.random.Generator) -> Motion:
    """Make one cycle: each joint turns about an axis of its own, mostly along the tree's."""
    heading = rng.uniform(0, 2 * np.pi)
    degrees = np.zeros((KEYS, len(rig), 3))
    trunk = _wave(TRUNK_BEATS, rng), _wave(TRUNK_BEATS, rng)
    for j, most in enumerate(rig.high[:, 0]):
        way, waves = heading, trunk
        if j >= TRUNK_JOINTS:
            way = heading + 0.6 * rng.normal()
            waves = _wave(LIMB_BEATS, rng), _wave(LIMB_BEATS, rng)
        main, cross = waves[0], 0.4 * waves[1]
        about = (
            math.cos(way) * main - math.sin(way) * cross,
            math.sin(way) * main + math.cos(way) * cross,
        )
        degrees[:, j, :2] = np.stack(about, axis=1) * most / math.hypot(1.0, 0.4)
    return Motion(from_euler(degrees), np.zeros((KEYS, 3)), 0.0, CYCLE_S * math.sqrt(height / 10.0))


def _wave(beats: tuple[int, ...], rng: np.random.Generator) -> Reals:
    """Sum harmonics within ±1, the lower ones stronger, (K,)."""
    weight = rng.uniform(0.5, 1.0, len(beats)) / np.array(beats)
    phase = rng.random(len(beats))
    turns = key_phases(KEYS)[:, None] * np.array(beats) + phase
    return np.asarray(np.sin(2 * np.pi * turns) @ weight / weight.sum())
