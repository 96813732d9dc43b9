"""Prototypes of trees: trunk, limbs, branches, twigs and foliage, each a level of detail.

Level 0 is the whole tree, and as an inner node the trunk; 1 limbs; 2 branches; then twigs, where a
species has them; last the foliage, leaf by leaf. A part's origin is the base of its branch, or the
middle of its leaf; the whole tree's is the foot of the trunk, on the ground. As an inner node a
branch is its own chain of sticks. Its leaf appearance is a few blobs and what is kept of that
chain, which cover on average over directions what the hidden branches and leaves would
(``scenes.sticks.appearance``).
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from lod.errors import InputError
from lod.shapes import StickTable
from scenes.models.trees.grown_tree import GrownTree
from scenes.models.trees.growth import grow
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.weather import SEASONS
from scenes.sticks.appearance.fit import fit_appearances
from scenes.sticks.appearance.part_sticks import PartSticks
from scenes.sticks.prototype import PartPlaces, Prototype, assemble_prototype

_STREAM = 0x7EE


@lru_cache(maxsize=32)
def tree_prototypes(
    seed: int, count: int, species: TreeSpecies, season: str = "summer"
) -> tuple[Prototype, ...]:
    """Make ``count`` trees of a species; the k-th depends on the seed, the season and k only."""
    if count < 1:
        raise InputError(f"{species.name}: prototypes", count, "at least one prototype")
    if season not in SEASONS:
        raise InputError("season", season, f"one of {', '.join(SEASONS)}")
    return tuple(
        _prototype(f"{species.name} {k}", grow_tree(species, seed, k, season)) for k in range(count)
    )


def grow_tree(species: TreeSpecies, seed: int, k: int, season: str = "summer") -> GrownTree:
    """Grow the k-th tree of a seed; its wood is the same in every season."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    shades = species.foliage_colours(season)
    if species.foliage and not shades:
        species = species.bare()
    levels, foliage = grow(species, rng)
    bark = np.array(species.bark_albedo)
    if not shades:
        blends = [(1 - share) * bark[0] + share * bark[1] for share in (0.33, 0.67)]
        palette = np.vstack((bark, blends))
        return GrownTree(species, levels, foliage, np.zeros(0, np.int64), palette)
    # Every branch has its own shade, and every leaf its own about that.
    branch = np.arange(len(levels[-1]))
    for level in levels[:2:-1]:
        branch = level.parent[branch]
    of_branch = rng.normal(size=len(levels[2]))
    tone = 0.7 * of_branch[branch[foliage.twig]] + 0.7 * rng.normal(size=len(foliage.twig))
    middle = (len(shades) - 1) / 2
    shade = np.clip(np.rint(middle + tone), 0, len(shades) - 1).astype(np.int64)
    albedo = np.array(shades)
    blends = [(1 - s) * albedo[int(middle)] + s * bark[1] for s in (0.25, 0.5)]
    palette = np.vstack((bark, albedo, blends))
    return GrownTree(species, levels, foliage, len(bark) + shade, palette)


def _prototype(name: str, tree: GrownTree) -> Prototype:
    """Make the prototype of a grown tree, whose rows are parts, level by level."""
    counts = [len(level) for level in tree.levels]
    tables = [tree.branch_sticks(k) for k in range(len(tree.levels))]
    if len(tree.foliage.twig):
        counts.append(len(tree.foliage.twig))
        tables.append(tree.foliage_sticks())
    row = [0, *np.cumsum(counts).tolist()]  # first of each level, and the number of parts
    places = _places(tree, counts, row)
    own = StickTable.merge([_from_row(t, row[k], row[-1]) for k, t in enumerate(tables)])
    parts = PartSticks(places.parent, places.level, own, tree.palette)
    fitted = fit_appearances(parts)
    return assemble_prototype(
        name,
        replace(places, overlap=fitted.overlap),
        own.only(parts.owns),
        fitted.leaf,
        tints=tree.palette,
        view_dependence=fitted.view_dependence,
    )


def _places(tree: GrownTree, counts: list[int], row: list[int]) -> PartPlaces:
    """Place the parts: a branch at its base, a leaf of the foliage at its middle."""
    levels, foliage = tree.levels, tree.foliage
    branches = [row[k - 1] + levels[k].parent for k in range(1, len(levels))]
    bases = [level.nodes[:, 0] for level in levels[1:]]
    return PartPlaces(
        parent=np.concatenate(([-1], *branches, row[len(levels) - 1] + foliage.twig)),
        level=np.repeat(np.arange(len(counts)), counts),
        origin=np.concatenate((np.zeros((1, 3)), *bases, (foliage.start + foliage.end) / 2)),
    )


def _from_row(table: StickTable, row: int, n: int) -> StickTable:
    """Make a table of some parts one of n parts, as rows ``row`` and on."""
    return table.with_owner(n, table.owner + row)
