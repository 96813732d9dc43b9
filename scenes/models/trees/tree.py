"""Prototypes of trees: trunk, limbs, branches, twigs and foliage, each a level of detail.

Level 0 is the whole tree, and as an inner node the trunk; 1 limbs; 2 branches; then twigs, where a
species has them; last the foliage, leaf by leaf. A part's origin is the base of its branch, or the
middle of its leaf; the whole tree's is the foot of the trunk, on the ground. As an inner node a
branch is its own chain of sticks. Its leaf appearance is a few blobs and what is kept of that
chain, which cover on average over directions what the hidden branches and leaves would
(``leaf_appearance``).
"""

import math
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points
from lod.errors import InputError
from lod.stick_table import StickTable
from scenes.models.trees.grown_tree import GrownTree
from scenes.models.trees.growth import grow
from scenes.models.trees.leaf_appearance import leaf_appearances
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.weather import SEASONS
from scenes.sticks.prototype import PartPlaces, Prototype, assemble_prototype
from scenes.sticks.view_dependence import CONSTANT, ViewDependence

_STREAM = 0x7EE

DARKER = 0.72
"""Ratio of the albedo of each darker tint, for shapes that shade themselves, to the next lighter
one's."""


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
        palette = np.vstack((bark, *_darker_tints(species, bark), blends))
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
    palette = np.vstack((bark, albedo, *_darker_tints(species, albedo), blends))
    return GrownTree(species, levels, foliage, len(bark) + shade, palette)


def _darker_tints(species: TreeSpecies, colours: Points) -> list[Float64[np.ndarray, "2 3"]]:
    """Darken the darkest and the lightest of some colours, down to what leaf appearances need."""
    factors = species.tables.albedo_factor
    least = 0.9 * min(factors, default=1.0)
    steps = math.ceil(math.log(least) / math.log(DARKER)) if factors else 0
    return [DARKER ** (k + 1) * colours[[0, -1]] for k in range(steps)]


def _prototype(name: str, tree: GrownTree) -> Prototype:
    """Make the prototype of a grown tree, whose rows are parts, level by level."""
    counts = [len(level) for level in tree.levels]
    if len(tree.foliage.twig):
        counts.append(len(tree.foliage.twig))
    row = [0, *np.cumsum(counts).tolist()]  # first of each level, and the number of parts
    n = row[-1]
    tables = leaf_appearances(tree)
    inner = [_from_row(tree.branch_sticks(k), row[k], n) for k in range(len(tables) - 1)]
    leaf = [_from_row(table, row[k], n) for k, table in enumerate(tables)]
    return assemble_prototype(
        name,
        _places(tree, counts, row),
        StickTable.merge(inner),
        StickTable.merge(leaf),
        tints=tree.palette,
        view_dependence=_view_dependence(tree.species, tables),
    )


def _places(tree: GrownTree, counts: list[int], row: list[int]) -> PartPlaces:
    """Place the parts: a branch at its base, a leaf of the foliage at its middle."""
    levels, foliage = tree.levels, tree.foliage
    branches = [row[k - 1] + levels[k].parent for k in range(1, len(levels))]
    bases = [level.nodes[:, 0] for level in levels[1:]]
    overlap = tree.species.tables.overlap or (0.0,) * (len(counts) - 1)
    return PartPlaces(
        parent=np.concatenate(([-1], *branches, row[len(levels) - 1] + foliage.twig)),
        level=np.repeat(np.arange(len(counts)), counts),
        origin=np.concatenate((np.zeros((1, 3)), *bases, (foliage.start + foliage.end) / 2)),
        overlap=np.repeat((*overlap, 0.0), counts),
    )


def _view_dependence(species: TreeSpecies, appearances: list[StickTable]) -> ViewDependence | None:
    """Collect the tables of the leaf appearances of every level but the last.

    They are of the blobs, which follow the wood that is kept.
    """
    tables, shapes = species.tables, species.leaf_appearance
    if not (tables.elevation or tables.azimuth_tone):
        return None
    rows: list[Ints] = [np.full(len(table), -1) for table in appearances]
    for level, table in enumerate(appearances[:-1]):
        kept = np.arange(len(table)) - table.first[table.owner] < shapes.kept_segments[level]
        rows[level][~kept] = level
    elevation = tables.elevation or (CONSTANT,) * len(shapes.blob_count)
    return ViewDependence.from_tables(np.concatenate(rows), elevation, tables.azimuth_tone)


def _from_row(table: StickTable, row: int, n: int) -> StickTable:
    """Make a table of some parts one of n parts, as rows ``row`` and on."""
    return table.with_owner(n, table.owner + row)
