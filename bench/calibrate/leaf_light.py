"""Measure the albedo of the leaf appearances of trees, and how it depends on the view.

    python -m bench.calibrate.leaf_light [--tables TABLE]… [SPECIES…]

writes, for every species or those named, tables of ``scenes/models/trees/species/NAME.csv``:

albedo     share of its albedo that a leaf appearance of each level has, so that a stand sends as
           much light as in full detail: what it hides shades itself, and one smooth shape does not
azimuth    its albedo by the angle between eye and sun, over the mean
elevation  share of its area and of its albedo by the elevation of the eye, for crowns whose gaps
           open and close with it; it takes the place of ``albedo`` for trees in leaf

By default all tables are measured, elevation only for a species that has it already. A species
takes some minutes. The seeds are fixed: the same species gives the same numbers.
"""

import argparse
import sys

import numpy as np
from jaxtyping import Float64

from bench.calibrate.canopy_light import (
    LINES,
    VIEW_AZIMUTHS_DEG,
    calibration_trees,
    cut_at_level,
    outgoing,
)
from bench.calibrate.write_species import update_tables
from lod.stick_table import StickTable
from scenes.far_cover.stand_appearance import full_detail_sticks, unit_direction
from scenes.model_files.names import tree_species_names
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.species_files import tree_species
from scenes.sticks.prototype import Prototype
from scenes.sticks.view_angles import AZIMUTHS_DEG, ELEVATIONS_DEG
from scenes.sticks.view_dependence import ElevationTable
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas

TABLES = ("albedo", "azimuth", "elevation")

MORE_LINES = 2 * LINES
"""Lines of sight where a direction has a value of its own."""

LOWEST_DEG = 4.0
"""Elevation from which light is measured for an eye level with the tree."""

COVER_AZIMUTHS_DEG = (51.7, 111.7, 171.7, 231.7, 291.7, 351.7)
"""Directions from which cover is measured at each elevation."""

RAYS, STEPS = 400, 4
"""Rays across a tree's height, and steps to the right cover."""

_CIRCLE = np.array((0.5, *(1.0,) * (len(AZIMUTHS_DEG) - 2), 0.5)) / (len(AZIMUTHS_DEG) - 1)
"""Share of the circle that each of AZIMUTHS_DEG stands for."""


def albedo_factors(species: TreeSpecies, season: str) -> list[float]:
    """Share of their albedo that leaf appearances of each level keep for the stand to send as much
    light as in full detail."""
    trees = calibration_trees(species, season)
    leafless = species.foliage is not None and not species.foliage_colours(season)
    grown = species.bare() if leafless else species
    finest = _finest(trees)
    wanted = outgoing(trees, grown, finest).total.sum()
    cuts = [outgoing(trees, grown, level) for level in range(finest)]
    return [float((wanted - cut.true_parts.sum()) / cut.leaf_appearances.sum()) for cut in cuts]


def azimuth_tones(
    species: TreeSpecies, level: int, lines: int = MORE_LINES
) -> Float64[np.ndarray, " a"]:
    """Albedo that is right for the leaf appearances of a level in summer at each of AZIMUTHS_DEG,
    over the one that is right for all azimuths together, (a,)."""
    trees = calibration_trees(species, "summer")
    full, cut = (
        outgoing(trees, species, each, azimuths_deg=AZIMUTHS_DEG, lines=lines)
        for each in (_finest(trees), level)
    )
    wanted = (full.total - cut.true_parts).sum(axis=0)
    shown = cut.leaf_appearances.sum(axis=0)
    return wanted / shown / ((wanted @ _CIRCLE) / (shown @ _CIRCLE))


def elevation_table(species: TreeSpecies, level: int) -> tuple[float, ElevationTable]:
    """Correction of the leaf appearances of a level by the elevation of the eye, and the share of
    their albedo that they keep where they are brightest.

    From each elevation a tree displayed down to the level covers what the whole tree does, and a
    stand sends as much light, in the mean over azimuths.
    """
    plain, trees = species.uncorrected(), calibration_trees(species, "summer")
    share, tone = [], []
    for elevation in ELEVATIONS_DEG:
        share.append(_fit_area_share(trees, plain, level, elevation))
        views = (float(max(elevation, LOWEST_DEG)),), VIEW_AZIMUTHS_DEG, MORE_LINES
        full = outgoing(trees, plain, _finest(trees), 1.0, *views)
        cut = outgoing(trees, plain, level, share[-1], *views)
        wanted = (full.total - cut.true_parts).sum()
        tone.append(float(wanted / cut.leaf_appearances.sum()))
    shares, tones = (tuple(each / max(column) for each in column) for column in (share, tone))
    return max(tone), ElevationTable(shares, tones)


def _fit_area_share(
    trees: tuple[Prototype, ...], species: TreeSpecies, level: int, elevation_deg: float
) -> float:
    """Share of the area of a level's leaf appearances with which trees cover, from an elevation,
    as much as in full detail."""
    views = np.array([unit_direction(elevation_deg, azimuth) for azimuth in COVER_AZIMUTHS_DEG])
    spacing = species.scale / RAYS
    cuts = [cut_at_level(tree, species, level) for tree in trees]

    def mean_cover(tables: list[StickTable]) -> float:
        return float(np.mean([visible_areas(t, views, spacing).sum() for t in tables]))

    def cover_with(share: float) -> float:
        tables = [with_area_share(table, np.where(hides, share, 1.0)) for table, hides in cuts]
        return mean_cover(tables)

    wanted = mean_cover([full_detail_sticks(tree)[0] for tree in trees])
    bare = cover_with(1e-6)
    share = 1.0
    for _ in range(STEPS):
        share *= (wanted - bare) / (cover_with(share) - bare)
    return share


def _finest(trees: tuple[Prototype, ...]) -> int:
    """The finest level of detail."""
    return int(trees[0].hierarchy.level.max())


def measure(name: str, tables: tuple[str, ...]) -> None:
    """Measure these tables of a species, and write them to its file."""
    species = tree_species(name)
    if species.foliage_colours("summer"):
        levels = range(len(species.levels) + 1)
        if "elevation" in tables:
            factors, by_elevation = zip(*(elevation_table(species, k) for k in levels), strict=True)
            update_tables(name, "leaf", albedo_factor=factors, elevation=by_elevation)
        elif "albedo" in tables and not species.tables.elevation:
            update_tables(name, "leaf", albedo_factor=albedo_factors(species, "summer"))
        if "azimuth" in tables:
            tones = [azimuth_tones(species, level) for level in levels]
            update_tables(name, "leaf", azimuth_tone=tones)
    if "albedo" in tables and not species.foliage_colours("winter"):
        update_tables(name, "bare", albedo_factor=albedo_factors(species, "winter"))


def main(arguments: list[str]) -> None:
    """Run the command that the module's own text describes."""
    parser = argparse.ArgumentParser(prog="python -m bench.calibrate.leaf_light")
    parser.add_argument("species", nargs="*", metavar="SPECIES", help="all by default")
    parser.add_argument("--tables", action="append", choices=TABLES, help="may be repeated")
    options = parser.parse_args(arguments)
    for name in options.species or tree_species_names():
        corrected = TABLES if tree_species(name).tables.elevation else ("albedo", "azimuth")
        measure(name, tuple(options.tables or corrected))


if __name__ == "__main__":
    main(sys.argv[1:])
