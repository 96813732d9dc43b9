"""Growth of a tree: trunk, limbs, branches, twigs and leaves, level by level.

After Weber & Penn (SIGGRAPH 1995): equations for lengths, radii, flare and placement are theirs,
cited by section; tropism and random bending are simplified to a turn per segment. All branches of
a level grow at once.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints, Points, Reals, expand
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
