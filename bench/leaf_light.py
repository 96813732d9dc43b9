"""How much light the leaf appearances of trees send, over what the tree in full detail sends.

``python -m bench.leaf_light [--sides] [SPECIES…]`` prints the shares by which
``scenes.tree_species`` takes colour from the shapes that stand for hidden leaves, level by level:
what they hide shades itself, and one smooth shape does not. A stand of one species is looked at
from all sides, every tree cut at one level, in the light of a sun 40° up and an even sky
(``scenes.stand_light``). Paths of light and places of trees are the same at all levels. With
``--sides`` it prints instead the share that would be right for a whole tree's own shapes toward
each side, 0° with the sun behind the viewer, and toward each height.
"""

import math
import sys
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64

from scenes.prototype import Prototype
from scenes.sky_share import sky_share
from scenes.stand import stood, toward
from scenes.stand_light import DRAWS, GROUND, seen_along
from scenes.stick_grid import grid_of
from scenes.stick_table import StickTable
from scenes.tree import tree_prototypes
from scenes.tree_species import SPECIES, TreeSpecies

SUN_DEG, TURBIDITY = 40.0, 3.0
ELEVATIONS_DEG = (4.0, 10.0, 18.0, 30.0, 50.0)
TURNS_DEG = (0.0, 45.0, 90.0, 135.0, 180.0)
TREES, SPACING = 24, 1.0
"""In a stand; √ of the area that each has, as a share of its height."""

LINES = 1500
"""From each direction."""

_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


@dataclass(frozen=True, eq=False)
class Sent:
    """Luminance sent to each direction, (e, t): by the shapes that stand for what is hidden, and by
    all that is displayed as itself."""

    shapes: np.ndarray
    itself: np.ndarray


def cut_at(tree: Prototype, species: TreeSpecies, level: int) -> tuple[StickTable, np.ndarray]:
    """A tree displayed down to a level, as one part; and which sticks stand for others."""
    h, leaf, inner = tree.hierarchy, tree.leaf, tree.inner
    ends = (h.level == level) | ((h.level < level) & (h.part_count == 0))
    kept = np.array((*species.wood, 0))[h.level[leaf.owner]]
    hides = (np.arange(len(leaf)) - leaf.first[leaf.owner] >= kept) & (h.part_count[leaf.owner] > 0)
    rows = [(h.level < level)[inner.owner] & ~ends[inner.owner], ends[leaf.owner]]
    names = ("start", "end", "start_radius", "end_radius", "tint")
    tables = (inner, leaf)
    columns = [
        np.concatenate([getattr(t, k)[r] for t, r in zip(tables, rows, strict=True)]) for k in names
    ]
    flags = np.concatenate((np.zeros(rows[0].sum(), bool), hides[rows[1]]))
    return StickTable(np.array((0, len(flags))), *columns), flags


def sent(trees: tuple[Prototype, ...], species: TreeSpecies, level: int) -> Sent:
    """What a stand of these trees sends, every one displayed down to a level."""
    rng = np.random.Generator(np.random.Philox(0x1EAF))
    side, cuts = (
        species.height[0] * SPACING * math.sqrt(TREES),
        [cut_at(tree, species, level) for tree in trees],
    )
    tables, colours, flags = [], [], []
    for n in range(TREES):
        (table, hides), palette = cuts[n % len(trees)], trees[n % len(trees)].tints
        tables.append(stood(table, rng.random(2) * side, 2 * np.pi * rng.random()))
        colours.append(palette[table.tint])
        flags.append(hides)
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = [np.concatenate([getattr(table, name) for table in tables]) for name in names]
    plot = StickTable(np.array((0, len(columns[0]))), *columns)
    return _seen(plot, side, np.concatenate(colours), np.concatenate(flags), rng)


def _seen(
    plot: StickTable,
    side: float,
    colour: Float64[np.ndarray, "k 3"],
    hides: np.ndarray,
    rng: np.random.Generator,
) -> Sent:
    grid, light = grid_of(plot, side), (toward(SUN_DEG, 0.0), sky_share(SUN_DEG, TURBIDITY))
    found = np.zeros((2, len(ELEVATIONS_DEG), len(TURNS_DEG)))
    for row, column in np.ndindex(found.shape[1:]):
        start = np.zeros((LINES, 3))
        start[:, :2] = rng.random((LINES, 2)) * side
        direction = toward(ELEVATIONS_DEG[row], TURNS_DEG[column])
        seen = seen_along(grid, colour, light, start, direction, rng.random((LINES, DRAWS)))
        met = seen.stick != GROUND
        light_of = seen.sent @ _LUMINANCE
        shapes = met & hides[seen.stick]
        found[:, row, column] = light_of[shapes].sum(), light_of[met & ~shapes].sum()
    return Sent(*found)


def shares(species: TreeSpecies, season: str, seed: int = 1) -> list[float]:
    """Share of their colour that shapes of each level keep for the stand to send as much as in full
    detail, from trees whose shapes have it all."""
    trees = tree_prototypes(seed, 3, replace(species, lit=()), season)
    bare = not species.leafy.get(season)
    grown = species.bare() if bare and species.foliage else species
    finest = int(trees[0].hierarchy.level.max())
    full = sent(trees, grown, finest)
    whole = (full.shapes + full.itself).sum()
    made = []
    for level in range(finest):
        cut = sent(trees, grown, level)
        made.append(float((whole - cut.itself.sum()) / cut.shapes.sum()))
    return made


def sides(species: TreeSpecies, seed: int = 1) -> Float64[np.ndarray, "e t"]:
    """The share that would be right for the shapes of whole trees in summer, (e, t): toward each
    elevation and turn, 0° with the sun behind the viewer."""
    trees = tree_prototypes(seed, 3, replace(species, lit=()), "summer")
    full, cut = (sent(trees, species, k) for k in (int(trees[0].hierarchy.level.max()), 0))
    return (full.shapes + full.itself - cut.itself) / cut.shapes


def print_sides(names: list[str]) -> None:
    """Print for leafy species the mean share toward each side, and toward each height."""
    for name in names or [each for each, species in SPECIES.items() if species.leafy]:
        share = sides(SPECIES[name])
        for what, at, axis in (("turn", TURNS_DEG, 0), ("elevation", ELEVATIONS_DEG, 1)):
            pairs = zip(at, share.mean(axis=axis), strict=True)
            told = ", ".join(f"{deg:g}°: {each:.2f}" for deg, each in pairs)
            print(f"{name}, summer, by {what}: {told}", flush=True)


def print_shares(names: list[str]) -> None:
    """Print the shares of every species, leafy and bare."""
    for name in names or list(SPECIES):
        species = SPECIES[name]
        for season in ("summer", "winter") if species.leafy else ("winter",):
            found = ", ".join(f"{each:.3f}" for each in shares(species, season))
            print(f"{name}, {season}: ({found})", flush=True)


def main(arguments: list[str]) -> None:
    """What the module's own text says, for the species named, or all."""
    names = [each for each in arguments if each != "--sides"]
    (print_sides if "--sides" in arguments else print_shares)(names)


if __name__ == "__main__":
    main(sys.argv[1:])
