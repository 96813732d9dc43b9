"""Trees: a trunk, four levels of branches and foliage, in six levels of detail.

Level 0 is the whole tree, and as an inner node the trunk; 1 limbs; 2 branches; 3 branchlets; 4
twigs; 5 the foliage of each twig. A part's origin is the base of its branch, of foliage its
middle; the whole tree's is the foot of the trunk, on the ground. As an inner node a branch is its
own chain of sticks. Its leaf appearance is that chain with fewer sticks and a few blobs, which
cover on average over directions what the hidden twigs and leaves would (``tree_blobs``).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from lod.arrays import Ints
from lod.errors import InputError
from scenes.prototype import Prototype, assemble
from scenes.stick_area import mean_outline_areas
from scenes.stick_table import StickTable
from scenes.tree_blobs import blended_tints, fitted, fitting_area, gather, joined
from scenes.tree_growth import Branches, Leaves, grow
from scenes.tree_species import BROADLEAF, TreeSpecies

BLOBS = (9, 5, 4, 3, 2)
"""Blobs in the leaf appearance of the tree, a limb, a branch, a branchlet, a twig."""

WOOD = (1, 2, 1, 1, 1)
"""Sticks that are left there of their own chains (for the tree, of the trunk's)."""

TWIGS = 4
"""Level of the branches that bear leaves; the foliage is one level further."""

_STREAM = 0x7EE


@dataclass(frozen=True, eq=False)
class Grown:
    """A grown tree: branches of levels 0 (trunk) to TWIGS, leaves, and the tint of each leaf."""

    levels: list[Branches]
    leaves: Leaves
    leaf_tint: np.ndarray
    palette: np.ndarray

    def ancestor(self, level: int, depth: int) -> Ints:
        """For each branch of a level, the branch of level ``depth`` that it has grown from."""
        rows = np.arange(len(self.levels[level]))
        for k in range(level, depth, -1):
            rows = self.levels[k].parent[rows]
        return rows


@lru_cache(maxsize=16)
def tree_prototypes(
    seed: int, count: int, species: TreeSpecies = BROADLEAF
) -> tuple[Prototype, ...]:
    """``count`` trees of a species; the k-th depends on the seed and on k only."""
    if count < 1:
        raise InputError("species.tree.prototypes", count, "at least one prototype")
    return tuple(_prototype(f"{species.name} {k}", grown(species, seed, k)) for k in range(count))


def grown(species: TreeSpecies, seed: int, k: int) -> Grown:
    """The k-th tree of that seed."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    levels, leaves = grow(species, rng)
    # Every branch has its own shade, and every leaf its own about that.
    shade = rng.normal(size=len(levels[2]))
    twig_branch = levels[3].parent[levels[4].parent]
    tone = 0.7 * shade[twig_branch[leaves.twig]] + 0.7 * rng.normal(size=len(leaves.twig))
    middle = (len(species.greens) - 1) / 2
    green = np.clip(np.rint(middle + tone), 0, len(species.greens) - 1).astype(np.int64)
    bark, greens = np.array(species.bark), np.array(species.greens)
    woody = [(1 - share) * greens[int(middle)] + share * bark[1] for share in (0.15, 0.35)]
    return Grown(levels, leaves, len(bark) + green, np.concatenate((bark, greens, woody)))


def _prototype(name: str, tree: Grown) -> Prototype:
    counts = [len(level) for level in tree.levels] + [len(tree.levels[TWIGS])]
    row = [0, *np.cumsum(counts).tolist()]  # first of each level, and the number of parts
    n = row[-1]
    inner = [_placed(_chains(tree, k), row[k], n) for k in range(TWIGS + 1)]
    leaf = [_placed(_leaf_appearance(tree, k), row[k], n) for k in range(TWIGS + 1)]
    leaf.append(_placed(_foliage(tree), row[-2], n))
    bases = [level.nodes[:, 0] for level in tree.levels]
    middles = _middles(tree)
    return assemble(
        name=name,
        whole=_wholes(tree, row),
        level=np.repeat(np.arange(len(counts)), counts),
        origin=np.concatenate((np.zeros((1, 3)), *bases[1:], middles)),
        inner=_merged(inner, n),
        leaf=_merged(leaf, n),
        tints=tree.palette,
    )


def _middles(tree: Grown) -> np.ndarray:
    """Middle of the leaves of each twig, (n, 3) [m]."""
    leaves, n = tree.leaves, len(tree.levels[TWIGS])
    count = np.bincount(leaves.twig, minlength=n)
    middle = (leaves.start + leaves.end) / 2
    return np.stack([np.bincount(leaves.twig, x, n) / count for x in middle.T], axis=1)


def _wholes(tree: Grown, row: list[int]) -> Ints:
    """The part that owns each part: that on which it has grown."""
    branches = [row[k - 1] + tree.levels[k].parent for k in range(1, TWIGS + 1)]
    return np.concatenate(([-1], *branches, row[TWIGS] + np.arange(len(tree.levels[TWIGS]))))


def _leaf_appearance(tree: Grown, depth: int) -> StickTable:
    """What every branch of one depth looks like when nothing of it is displayed but itself."""
    n = len(tree.levels[depth])
    hidden = _grown_from(tree, depth)
    wood = _chains(tree, depth, WOOD[depth])
    twig_owner = tree.ancestor(TWIGS, depth)
    owner = twig_owner[tree.leaves.twig]  # rises: children stand in the order of their parents
    first = np.searchsorted(owner, np.arange(n + 1))
    blobs, group = gather(first, tree.leaves.start, tree.leaves.end, BLOBS[depth])
    factor = fitted(blobs, wood, fitting_area(hidden))
    tint = _blob_tints(tree, depth, hidden, blobs.part, group)
    return joined(wood, blobs, factor, tint)


def _grown_from(tree: Grown, depth: int) -> StickTable:
    """All sticks of each branch of one depth: its own, those of all that grow from it, leaves."""
    n = len(tree.levels[depth])
    tables = []
    for level in range(depth, TWIGS + 1):
        chains = _chains(tree, level)
        tables.append(_owned(chains, tree.ancestor(level, depth)[chains.owner], n))
    foliage = _foliage(tree)
    tables.append(_owned(foliage, tree.ancestor(TWIGS, depth)[foliage.owner], n))
    return _merged(tables, n)


def _blob_tints(tree: Grown, depth: int, hidden: StickTable, part: Ints, group: np.ndarray) -> Ints:
    """Tints of blobs: as their own leaves, with as large a share of bark as the hidden wood."""
    foliage = _foliage(tree)
    area, colour = mean_outline_areas(foliage), tree.palette[foliage.tint]
    weight = np.bincount(group, area, len(part))
    green = (
        np.stack([np.bincount(group, area * c, len(part)) for c in colour.T], 1) / weight[:, None]
    )
    leafy = np.bincount(part, weight)
    everything = np.bincount(hidden.owner, mean_outline_areas(hidden))
    own = _chains(tree, depth)
    wooden = everything - leafy - np.bincount(own.owner, mean_outline_areas(own))
    share = (wooden / (wooden + leafy))[part, None]
    wanted = (1 - share) * green + share * tree.palette[1]
    return blended_tints(part, weight, wanted, tree.palette, np.arange(2, len(tree.palette)))


def _chains(tree: Grown, level: int, keep: int | None = None) -> StickTable:
    """The chains of one level of branches as sticks, all of them or ``keep`` for each."""
    branches = tree.levels[level]
    segments = branches.nodes.shape[1] - 1
    stops = np.rint(np.linspace(0, segments, (keep or segments) + 1)).astype(np.int64)
    nodes, radii = branches.nodes[:, stops], branches.radii[:, stops]
    owner = np.repeat(np.arange(len(branches)), len(stops) - 1)
    ends = nodes[:, :-1].reshape(-1, 3), nodes[:, 1:].reshape(-1, 3)
    tint = np.full(len(owner), min(level // 2, 1))
    return StickTable.of(
        len(branches), owner, *ends, radii[:, :-1].ravel(), radii[:, 1:].ravel(), tint
    )


def _foliage(tree: Grown) -> StickTable:
    leaves = tree.leaves
    ends = leaves.start, leaves.end, leaves.start_radius, leaves.end_radius
    return StickTable.of(len(tree.levels[TWIGS]), leaves.twig, *ends, tree.leaf_tint)


def _placed(table: StickTable, row: int, n: int) -> StickTable:
    """The table of parts ``row`` and on, among n."""
    return _owned(table, table.owner + row, n)


def _owned(table: StickTable, owner: Ints, n: int) -> StickTable:
    columns = (table.start, table.end, table.start_radius, table.end_radius, table.tint)
    return StickTable.of(n, owner, *columns)


def _merged(tables: list[StickTable], n: int) -> StickTable:
    names = ("owner", "start", "end", "start_radius", "end_radius", "tint")
    columns = [np.concatenate([getattr(table, name) for table in tables]) for name in names]
    return StickTable.of(n, *columns)
