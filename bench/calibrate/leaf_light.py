"""How much light the leaf appearances of trees send, over what the tree in full detail sends.

``python -m bench.calibrate.leaf_light [--sides | --heights] [SPECIES…]`` prints the shares by which
``scenes.models.trees.species_tables`` takes colour from the shapes that stand for hidden leaves,
level by level:
what they hide shades itself, and one smooth shape does not. A stand of one species, of the very
trees that presets have, is looked at from all sides, every tree cut at one level, in the light of a
sun 40° up, its sky and the ground (``scenes.far_cover.stand_paths``). Paths of light and places of
trees are
the same at all levels. With ``--sides`` it prints instead how much more or less would be right
toward each side, 0° with the sun behind the viewer; with ``--heights`` what the shapes of a level
lack from each height, in cover and then in light (``scenes.sticks.view_dependence``).
"""

import sys
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from scenes.far_cover.sky import sky_at
from scenes.far_cover.stand_appearance import full_detail_sticks, unit_direction
from scenes.far_cover.stand_paths import GROUND, RANDOMS_PER_PATH, SunAndSky, trace_lines
from scenes.far_cover.stand_rays import stand_field
from scenes.models.catalogue import PROTOTYPE_SEED
from scenes.models.trees.species import TreeSpecies
from scenes.models.trees.species_tables import SPECIES
from scenes.models.trees.tree import tree_prototypes
from scenes.sticks.prototype import Prototype
from scenes.sticks.table import StickTable
from scenes.sticks.view_angles import AZIMUTHS_DEG, ELEVATIONS_DEG
from scenes.sticks.view_dependence import ElevationTable
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas
from scenes.terrain.colour import COVERS

SUN_DEG, TURBIDITY = 40.0, 3.0
VIEW_ELEVATIONS_DEG = (4.0, 10.0, 18.0, 30.0, 50.0)
TREES, FEW, SPACING = {"broadleaf": 4}, 3, 1.0
"""Different ones in a stand, as presets have, and no others: trees of a kind differ, and few stand
for all of them. √ of the area that each has, as a share of its height."""

BETWEEN = np.array((COVERS["grassy"].moist, COVERS["grassy"].dry)).mean(axis=0)
"""Albedo of the ground among the trees."""

LINES, MORE = 12000, 2
"""From each height; and times as many, where each is told by itself."""

LOWEST_DEG, ASIDE_DEG = 4.0, (22.5, 67.5, 112.5, 157.5)
"""From where light is looked at for what is level with the eye; and turns that stand for all, each
for the eighth of a circle about it: right before the sun nothing shows its shade, but there is
hardly anyone's eye."""

SIDES_DEG = (51.7, 111.7, 171.7, 231.7, 291.7, 351.7)
RAYS, ROUNDS = 400, 4
"""Across a tree's height, and steps to the right cover."""

_CIRCLE = np.array((0.5, *(1.0,) * (len(AZIMUTHS_DEG) - 2), 0.5)) / (len(AZIMUTHS_DEG) - 1)
"""Share of the circle that each of AZIMUTHS_DEG stands for."""

_LUMINANCE = np.array((0.2126, 0.7152, 0.0722))


@dataclass(frozen=True, eq=False)
class Sent:
    """Luminance sent to each direction, (e, t): by the shapes that stand for what is hidden, and by
    all that is displayed as itself."""

    shapes: np.ndarray
    itself: np.ndarray


def trees_of(species: TreeSpecies, season: str) -> tuple[Prototype, ...]:
    """Those that presets have, their shapes in all of their colour."""
    return tree_prototypes(PROTOTYPE_SEED, TREES.get(species.name, FEW), species.unshaded(), season)


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


def sent(
    trees: tuple[Prototype, ...],
    species: TreeSpecies,
    level: int,
    share: float = 1.0,
    elevations: tuple[float, ...] = VIEW_ELEVATIONS_DEG,
    turns: tuple[float, ...] = ASIDE_DEG,
    more: int = 1,
) -> Sent:
    """What a stand of these trees sends to each elevation and turn, every one displayed down to a
    level, if this share is left of its shapes. ``more``: times LINES."""
    rng = np.random.Generator(np.random.Philox(0x1EAF))
    tables, colours, flags = [], [], []
    for tree in trees:
        table, hides = cut_at(tree, species, level)
        tables.append(with_area_share(table, np.where(hides, share, 1.0)) if share != 1 else table)
        colours.append(tree.tints[table.tint])
        flags.append(hides)
    side = species.height[0] * SPACING
    stand = stand_field(tables, np.full(len(trees), 1 / (len(trees) * side**2)), side)
    light = SunAndSky.at_azimuths(SUN_DEG, turns, sky_at(SUN_DEG, TURBIDITY))
    colour, hides = np.concatenate(colours), np.concatenate(flags)
    found = np.zeros((2, len(elevations), len(turns)))
    for row, elevation in enumerate(elevations):
        draws = rng.random((more * LINES, RANDOMS_PER_PATH))
        seen = trace_lines(stand, colour, light, elevation, draws, row * len(draws))
        met = seen.stick != GROUND
        shapes = met & hides[seen.stick]
        light_of = seen.sent @ _LUMINANCE + seen.ground_bounce @ (BETWEEN * _LUMINANCE)
        found[:, row] = light_of[shapes].sum(axis=0), light_of[met & ~shapes].sum(axis=0)
    return Sent(*found)


def from_heights(species: TreeSpecies, level: int) -> tuple[float, ElevationTable]:
    """Looks of the shapes of a level from each height, and the share of their colour that they keep
    where they are brightest (``TreeSpecies.lit``): for a tree displayed down to the level to cover
    what the whole does, and for a stand to send as much light, in the mean over sides."""
    plain, trees = species.unshaded(), trees_of(species, "summer")
    finest = int(trees[0].hierarchy.level.max())
    share, tone = [], []
    for height in ELEVATIONS_DEG:
        share.append(_share_left(trees, plain, level, height))
        sides = (float(max(height, LOWEST_DEG)),), ASIDE_DEG, MORE
        full, cut = (
            sent(trees, plain, finest, 1.0, *sides),
            sent(trees, plain, level, share[-1], *sides),
        )
        tone.append(float((full.shapes + full.itself - cut.itself).sum() / cut.shapes.sum()))
    shares, tones = (tuple(round(each / max(all_), 3) for each in all_) for all_ in (share, tone))
    return max(tone), ElevationTable(shares, tones)


def _share_left(
    trees: tuple[Prototype, ...], species: TreeSpecies, level: int, height: float
) -> float:
    """What is to be left of a level's shapes, from a height [degrees], for them to cover as much as
    what they hide."""
    views = np.array([unit_direction(height, side) for side in SIDES_DEG])
    spacing = species.height[0] / RAYS

    def covered(tables: list[StickTable]) -> float:
        return float(np.mean([visible_areas(t, views, spacing).sum() for t in tables]))

    cuts = [cut_at(tree, species, level) for tree in trees]
    wanted = covered([full_detail_sticks(tree)[0] for tree in trees])
    bare = covered([with_area_share(table, np.where(hides, 1e-6, 1.0)) for table, hides in cuts])
    share = 1.0
    for _ in range(ROUNDS):
        now = covered(
            [with_area_share(table, np.where(hides, share, 1.0)) for table, hides in cuts]
        )
        share *= (wanted - bare) / (now - bare)
    return share


def shares(species: TreeSpecies, season: str) -> list[float]:
    """Share of their colour that shapes of each level keep for the stand to send as much as in full
    detail, from trees whose shapes have it all."""
    trees = trees_of(species, season)
    bare = not species.leafy.get(season)
    grown = species.bare() if bare and species.foliage else species
    finest = int(trees[0].hierarchy.level.max())
    full = sent(trees, grown, finest)
    whole = (full.shapes + full.itself).sum()
    cuts = [sent(trees, grown, level) for level in range(finest)]
    return [float((whole - cut.itself.sum()) / cut.shapes.sum()) for cut in cuts]


def sides(species: TreeSpecies, level: int) -> Float64[np.ndarray, " t"]:
    """Share that would be right for the shapes of a level in summer toward each of AZIMUTHS_DEG,
    over that for all sides, (t,)."""
    trees = trees_of(species, "summer")
    finest = int(trees[0].hierarchy.level.max())
    full, cut = (
        sent(trees, species, each, turns=AZIMUTHS_DEG, more=MORE) for each in (finest, level)
    )
    wanted, shown = (full.shapes + full.itself - cut.itself).sum(axis=0), cut.shapes.sum(axis=0)
    return wanted / shown / ((wanted @ _CIRCLE) / (shown @ _CIRCLE))


def print_sides(names: list[str]) -> None:
    """Print, for leafy species, the table of ``TreeSpecies.sides``."""
    for name in names or [each for each, species in SPECIES.items() if species.leafy]:
        for level in range(len(SPECIES[name].porous)):
            found = ", ".join(f"{each:.2f}" for each in sides(SPECIES[name], level))
            print(f"{name}, level {level}: ({found})", flush=True)


def print_shares(names: list[str]) -> None:
    """Print the shares of every species, leafy and bare."""
    for name in names or list(SPECIES):
        species = SPECIES[name]
        for season in ("summer", "winter") if species.leafy else ("winter",):
            found = ", ".join(f"{each:.3f}" for each in shares(species, season))
            print(f"{name}, {season}: ({found})", flush=True)


def print_heights(names: list[str]) -> None:
    """Print, for leafy species, the tables of ``TreeSpecies.heights``, and ``lit`` that goes with
    them."""
    for name in names or [each for each, species in SPECIES.items() if species.leafy]:
        for level in range(len(SPECIES[name].porous)):
            lit, looks = from_heights(SPECIES[name], level)
            print(f"{name}, level {level}: lit {lit:.3f}, {looks}", flush=True)


def main(arguments: list[str]) -> None:
    """What the module's own text says, for the species named, or all."""
    names = [each for each in arguments if not each.startswith("--")]
    how = {"--sides": print_sides, "--heights": print_heights}
    asked = [each for each in arguments if each in how]
    (how[asked[0]] if asked else print_shares)(names)


if __name__ == "__main__":
    main(sys.argv[1:])
