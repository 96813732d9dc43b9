"""Trees: a trunk, limbs, branches, twigs and leaves, each a level of detail of its own.

Level 0 is the whole tree, and as an inner node the trunk; 1 limbs; 2 branches; then twigs, where a
kind has them; last leaves, one by one. A part's origin is the base of its branch, of a leaf its
middle; the whole tree's is the foot of the trunk, on the ground. As an inner node a branch is its
own chain of sticks. Its leaf appearance is a few blobs and what is kept of that chain, which cover
on average over directions what the hidden branches and leaves would (``tree_looks``).
"""

import math
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points
from lod.errors import InputError
from lod.stick_table import StickTable
from scenes.models.trees.growth import grow
from scenes.models.trees.leaf_appearance import Grown, leaf_appearances, owned
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.simplification import joined
from scenes.models.trees.weather import SEASONS
from scenes.sticks.prototype import Prototype, assemble
from scenes.sticks.view_dependence import CONSTANT, ViewDependence

_STREAM = 0x7EE

DIMMER = 0.72
"""Step from each of the tints for what shades itself to the next darker one."""


@lru_cache(maxsize=32)
def tree_prototypes(
    seed: int, count: int, species: TreeSpecies, season: str = "summer"
) -> tuple[Prototype, ...]:
    """``count`` trees of a species; the k-th depends on the seed, season and k only."""
    if count < 1:
        raise InputError(f"{species.name}: prototypes", count, "at least one prototype")
    if season not in SEASONS:
        raise InputError("season", season, f"one of {', '.join(SEASONS)}")
    return tuple(
        _prototype(f"{species.name} {k}", grown(species, seed, k, season)) for k in range(count)
    )


def grown(species: TreeSpecies, seed: int, k: int, season: str = "summer") -> Grown:
    """The k-th tree of that seed: the same wood in every season."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    greens = species.leaf_colours(season)
    if species.foliage and not greens:
        species = species.bare()
    levels, leaves = grow(species, rng)
    bark = np.array(species.bark_albedo)
    if not greens:
        blends = [(1 - share) * bark[0] + share * bark[1] for share in (0.33, 0.67)]
        palette = np.vstack((bark, *_dimmed(species, bark), blends))
        return Grown(species, levels, leaves, np.zeros(0, np.int64), palette)
    # Every branch has its own shade, and every leaf its own about that.
    bough = np.arange(len(levels[-1]))
    for level in levels[:2:-1]:
        bough = level.parent[bough]
    shade = rng.normal(size=len(levels[2]))
    tone = 0.7 * shade[bough[leaves.twig]] + 0.7 * rng.normal(size=len(leaves.twig))
    middle = (len(greens) - 1) / 2
    green = np.clip(np.rint(middle + tone), 0, len(greens) - 1).astype(np.int64)
    leafy = np.array(greens)
    blends = [(1 - s) * leafy[int(middle)] + s * bark[1] for s in (0.25, 0.5)]
    palette = np.vstack((bark, leafy, *_dimmed(species, leafy), blends))
    return Grown(species, levels, leaves, len(bark) + green, palette)


def _dimmed(species: TreeSpecies, colours: Points) -> list[Float64[np.ndarray, "2 3"]]:
    """The darkest and the lightest of some colours, down to what the least lit shapes need."""
    factors = species.tables.albedo_factor
    least = 0.9 * min(factors, default=1.0)
    steps = math.ceil(math.log(least) / math.log(DIMMER)) if factors else 0
    return [DIMMER ** (k + 1) * colours[[0, -1]] for k in range(steps)]


def _prototype(name: str, tree: Grown) -> Prototype:
    counts = [len(level) for level in tree.levels]
    if len(tree.leaves.twig):
        counts.append(len(tree.leaves.twig))
    row = [0, *np.cumsum(counts).tolist()]  # first of each level, and the number of parts
    n = row[-1]
    looks = leaf_appearances(tree)
    inner = [_placed(tree.chains(k), row[k], n) for k in range(len(looks) - 1)]
    leaf = [_placed(look, row[k], n) for k, look in enumerate(looks)]
    overlap = tree.species.tables.overlap or (0.0,) * (len(counts) - 1)
    middles = (tree.leaves.start + tree.leaves.end) / 2
    bases = [level.nodes[:, 0] for level in tree.levels[1:]]
    return assemble(
        name=name,
        whole=_wholes(tree, row),
        level=np.repeat(np.arange(len(counts)), counts),
        origin=np.concatenate((np.zeros((1, 3)), *bases, middles)),
        inner=joined(tuple(inner)),
        leaf=joined(tuple(leaf)),
        tints=tree.palette,
        view_dependence=_view_dependence(tree.species, looks),
        overlap=np.repeat((*overlap, 0.0), counts),
    )


def _view_dependence(species: TreeSpecies, looks: list[StickTable]) -> ViewDependence | None:
    """The shapes of every level but the last: all that follows the wood that is kept."""
    tables, shapes = species.tables, species.leaf_appearance
    if not (tables.elevation or tables.azimuth_tone):
        return None
    rows = [np.full(len(look), -1) for look in looks]
    for level, look in enumerate(looks[:-1]):
        kept = np.arange(len(look)) - look.first[look.owner] < shapes.kept_segments[level]
        rows[level][~kept] = level
    elevation = tables.elevation or (CONSTANT,) * len(shapes.blob_count)
    return ViewDependence.from_tables(np.concatenate(rows), elevation, tables.azimuth_tone)


def _wholes(tree: Grown, row: list[int]) -> Ints:
    """The part that owns each part: that on which it has grown."""
    levels = tree.levels
    branches = [row[k - 1] + levels[k].parent for k in range(1, len(levels))]
    return np.concatenate(([-1], *branches, row[len(levels) - 1] + tree.leaves.twig))


def _placed(table: StickTable, row: int, n: int) -> StickTable:
    """The table of parts ``row`` and on, among n."""
    return owned(table, table.owner + row, n)
