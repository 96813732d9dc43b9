"""How much of leaf appearances and of what they stand for lies in one another.

``python -m bench.calibrate.leaf_overlap [MODELS…]`` prints the overlaps that
``scenes.models.trees.species_tables`` and
``scenes.rig.build`` tell, level by level, of trees in leaf and bare, and of people and animals at
rest: while the parts of a level show a quarter, a half and three quarters of themselves, as when
they fade (``lod.pruning.crossfade``), the whole is to cover as much on average as with none and
with all of
them. After it: the cover with none and with all, over that of full detail; and in between over what
it is to be, without overlap and with.
"""

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from bench.calibrate.leaf_light import SIDES_DEG, VIEW_ELEVATIONS_DEG
from lod.pruning.crossfade import cross_fade
from lod.pruning.parts import BlendWeights
from scenes.far_cover.stand_appearance import unit_direction
from scenes.field.part_tables import PartTables
from scenes.models.animals.catalogue import ANIMALS
from scenes.models.catalogue import MODELS
from scenes.models.trees.weather import Weather
from scenes.rig.rigged_prototype import RiggedPrototype, rigid_prototype
from scenes.sticks.prototype import Prototype
from scenes.sticks.table import StickTable
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas

COUNT = 4
"""Different ones of a kind, all measured together; animals come in one build."""

DECIDUOUS = ("tree", "birch", "shrub")

SHOWN = (0.25, 0.5, 0.75)
"""Shares that parts show of themselves in between."""

RAYS = 250
"""Across an object's reach."""

ROUNDS, STEP, MOST, NEAR = 5, 0.2, 0.97, 5e-4
"""Steps to an overlap, the first of them, the greatest overlap, and how near its cover is to be."""


def shown_as(
    one: Prototype, part_tables: PartTables, level: int, share: float, height: float
) -> StickTable:
    """An object down to a level whose parts show this share of themselves, as one part; as seen
    from a height [degrees]."""
    h = one.hierarchy
    there = h.level <= level
    rows, number = np.flatnonzero(there), np.cumsum(there) - 1
    whole = np.where(h.parent[rows] < 0, -1, number[h.parent[rows]])
    shown = np.where(h.level[rows] == level, share, 1.0)
    inner, leaf, hidden = cross_fade(whole, h.share[rows], shown)
    rise = np.full(len(rows), np.sin(np.radians(height)))
    found, table = (
        part_tables.sticks_of(rows, BlendWeights(inner, leaf, rise, hidden_area=hidden)),
        part_tables.sticks,
    )
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = (getattr(table, name)[found.stick] for name in names)
    return with_area_share(StickTable(np.array((0, len(found.stick))), *columns), found.share)


def cover(objects: tuple[Prototype, ...], level: int, share: float) -> float:
    """What objects cover, down to a level whose parts show a share, in the mean over directions
    [m²]."""
    found = 0.0
    for one in objects:
        part_tables, spacing = PartTables.of((rigid_prototype(one),)), one.hierarchy.R[0] / RAYS
        for height in VIEW_ELEVATIONS_DEG:
            table = shown_as(one, part_tables, level, share, height)
            views = np.array([unit_direction(height, side) for side in SIDES_DEG])
            found += float(visible_areas(table, views, spacing).sum())
    return found / (len(VIEW_ELEVATIONS_DEG) * len(SIDES_DEG))


def lapped(one: Prototype, overlap: float) -> Prototype:
    """The same object with one overlap for all of its parts."""
    h = one.hierarchy
    return replace(one, hierarchy=replace(h, overlap=np.full(len(h), overlap)))


def between(objects: tuple[Prototype, ...], level: int, overlap: float | None = None) -> float:
    """Cover with parts of a level in between, over what it is to be, in the mean over SHOWN; with
    their own overlaps, or another."""
    none, every = cover(objects, level - 1, 1.0), cover(objects, level, 1.0)
    wanted = sum(none + share * (every - none) for share in SHOWN)
    laid = objects if overlap is None else tuple(lapped(one, overlap) for one in objects)
    return sum(cover(laid, level, share) for share in SHOWN) / wanted


def overlap_of(objects: tuple[Prototype, ...], level: int) -> float:
    """The overlap of parts of a level and the leaf appearances of their wholes (secants)."""
    before, now = 0.0, STEP
    off_before, off = (between(objects, level, each) - 1 for each in (before, now))
    for _ in range(ROUNDS):
        if abs(off) < NEAR or off == off_before:
            break
        step = off * (now - before) / (off - off_before)
        before, off_before, now = now, off, min(now - step, MOST)
        off = between(objects, level, now) - 1
    return now


def objects_of(model: str) -> Iterator[tuple[str, tuple[Prototype, ...]]]:
    """Objects of a model in each season in which they look otherwise, at rest."""
    for season in ("summer", "winter") if model in DECIDUOUS else ("summer",):
        made = MODELS[model](1, 1 if model in ANIMALS else COUNT, Weather(season))
        yield season, tuple(p.posed() if isinstance(p, RiggedPrototype) else p for p in made)


def main(models: list[str]) -> None:
    """Print the overlaps of every model, season by season and level by level."""
    for model in models or MODELS:
        for season, objects in objects_of(model):
            finest = int(max(one.hierarchy.level.max() for one in objects))
            whole = cover(objects, finest, 1.0)
            for level in range(1, finest + 1):
                found = overlap_of(objects, level)
                ends = ", ".join(
                    f"{cover(objects, k, 1.0) / whole:.3f}" for k in (level - 1, level)
                )
                middle = " → ".join(f"{between(objects, level, k):.3f}" for k in (0.0, found))
                what = f"{model}, {season}, level {level - 1}: {found:.2f}"
                print(f"{what}; cover {ends}; between {middle}", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
