"""Measure how much of leaf appearances and of the parts they stand for lies in one another.

    python -m bench.calibrate.leaf_overlap [MODELS…]

measures the overlap of every level, of all models or those named: while the parts of a level show a
quarter, a half and three quarters of themselves, as when they fade (``lod.pruning.crossfade``), the
object is to cover as much on average as with none and with all of them. The overlaps of a species
of tree, in leaf and bare, are written to ``scenes/models/trees/species/NAME.csv``; those of people,
animals and boulders are printed, for one pair in ``scenes.rig.build`` stands for all of them.

Beside each overlap is printed the cover with none and with all of the parts, over that of full
detail; and the cover in between over what it is to be, without overlap and with it.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bench.calibrate.canopy_light import VIEW_ELEVATIONS_DEG
from bench.calibrate.leaf_light import COVER_AZIMUTHS_DEG
from bench.calibrate.write_species import update_tables
from lod.pruning.crossfade import cross_fade
from lod.pruning.parts import BlendWeights
from lod.stick_table import StickTable
from scenes.far_cover.stand_appearance import unit_direction
from scenes.field.part_tables import PartTables
from scenes.model_files.names import animal_names, model_names, tree_species_names
from scenes.models.catalogue import MODELS
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.weather import Weather
from scenes.rig.rigged_prototype import RiggedPrototype, rigid_prototype
from scenes.sticks.prototype import Prototype
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas

COUNT = 4
"""Prototypes of a model, all measured together; animals come in one build."""

SHOWN = (0.25, 0.5, 0.75)
"""Shares that parts show of themselves in between."""

RAYS = 250
"""Rays across an object's reach."""

STEPS, FIRST_STEP, GREATEST = 5, 0.2, 0.97
"""Steps to an overlap, the first of them, and the greatest overlap."""

TOLERANCE = 5e-4
"""How near its cover is to be, relative."""


def displayed_sticks(
    one: Prototype, part_tables: PartTables, level: int, share: float, elevation_deg: float
) -> StickTable:
    """An object down to a level whose parts show this share of themselves, as one part, as seen
    from an elevation."""
    h = one.hierarchy
    there = h.level <= level
    rows, number = np.flatnonzero(there), np.cumsum(there) - 1
    parent = np.where(h.parent[rows] < 0, -1, number[h.parent[rows]])
    shown = np.where(h.level[rows] == level, share, 1.0)
    inner, leaf, hidden = cross_fade(parent, h.share[rows], shown)
    rise = np.full(len(rows), np.sin(np.radians(elevation_deg)))
    weights = BlendWeights(inner, leaf, rise, hidden_area=hidden)
    found, table = part_tables.sticks_of(rows, weights), part_tables.sticks
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = (getattr(table, name)[found.stick] for name in names)
    return with_area_share(StickTable(np.array((0, len(found.stick))), *columns), found.share)


def mean_cover(objects: tuple[Prototype, ...], level: int, share: float) -> float:
    """Area that objects cover down to a level whose parts show a share, the mean over directions
    [m²]."""
    area = 0.0
    for one in objects:
        part_tables = PartTables.of((rigid_prototype(one),))
        spacing = one.hierarchy.R[0] / RAYS
        for elevation in VIEW_ELEVATIONS_DEG:
            table = displayed_sticks(one, part_tables, level, share, elevation)
            views = np.array([unit_direction(elevation, each) for each in COVER_AZIMUTHS_DEG])
            area += float(visible_areas(table, views, spacing).sum())
    return area / (len(VIEW_ELEVATIONS_DEG) * len(COVER_AZIMUTHS_DEG))


def with_overlap(one: Prototype, overlap: float) -> Prototype:
    """The object with one overlap for all of its parts."""
    h = one.hierarchy
    return replace(one, hierarchy=replace(h, overlap=np.full(len(h), overlap)))


def cover_ratio(objects: tuple[Prototype, ...], level: int, overlap: float | None = None) -> float:
    """Cover with parts of a level in between, over what it is to be, in the mean over SHOWN; with
    the objects' own overlaps, or another."""
    none, every = mean_cover(objects, level - 1, 1.0), mean_cover(objects, level, 1.0)
    wanted = sum(none + share * (every - none) for share in SHOWN)
    if overlap is not None:
        objects = tuple(with_overlap(one, overlap) for one in objects)
    return sum(mean_cover(objects, level, share) for share in SHOWN) / wanted


def fit_overlap(objects: tuple[Prototype, ...], level: int) -> float:
    """The overlap of parts of a level and the leaf appearances that stand for them, by the secant
    method."""
    before, now = 0.0, FIRST_STEP
    off_before, off = (cover_ratio(objects, level, each) - 1 for each in (before, now))
    for _ in range(STEPS):
        if abs(off) < TOLERANCE or off == off_before:
            break
        step = off * (now - before) / (off - off_before)
        before, off_before, now = now, off, min(now - step, GREATEST)
        off = cover_ratio(objects, level, now) - 1
    return now


def model_objects(model: str) -> Iterator[tuple[str, tuple[Prototype, ...]]]:
    """Objects of a model, at rest: of a tree in leaf and bare, as far as it is ever so, else
    alike "" in all seasons."""
    seasons = {"": "summer"}
    if model in tree_species_names():
        in_leaf = tree_species(model).foliage_colours
        seasons = {"leaf": "summer"} if in_leaf("summer") else {}
        seasons |= {} if in_leaf("winter") else {"bare": "winter"}
    for foliage, season in seasons.items():
        count = 1 if model in animal_names() else COUNT
        prototypes = MODELS[model](1, count, Weather(season))
        yield (
            foliage,
            tuple(p.posed() if isinstance(p, RiggedPrototype) else p for p in prototypes),
        )


def measure(model: str) -> None:
    """Measure the overlaps of a model, print them, and write those of a species of tree."""
    for foliage, objects in model_objects(model):
        finest = int(max(one.hierarchy.level.max() for one in objects))
        whole = mean_cover(objects, finest, 1.0)
        overlaps = []
        for level in range(1, finest + 1):
            overlaps.append(fit_overlap(objects, level))
            covers = (mean_cover(objects, k, 1.0) / whole for k in (level - 1, level))
            ends = ", ".join(f"{each:.3f}" for each in covers)
            ratios = (cover_ratio(objects, level, k) for k in (0.0, overlaps[-1]))
            middle = " → ".join(f"{each:.3f}" for each in ratios)
            what = f"{model} {foliage}, level {level - 1}: {overlaps[-1]:.2f}"
            print(f"{what}; cover {ends}; between {middle}", flush=True)
        if foliage:
            update_tables(model, foliage, overlap=overlaps)


def main(models: list[str]) -> None:
    """Run the command that the module's own text describes."""
    for model in models or model_names():
        measure(model)


if __name__ == "__main__":
    main(sys.argv[1:])
