"""Fit of the leaf appearances of a tree: few shapes that keep its silhouette, gaps and colour.

Level by level, every branch gets a few blobs (``simplification``), as thick as makes them cover on
average what they hide. Then all blobs of a level are made thicker or thinner by one factor, so that
the tree displayed to that level covers what the whole tree does, for neighbours overlap otherwise
than what they stand for. Their tints are chosen so that the mean colour of all that is seen is that
of the whole tree, but darker by the measured share (``appearance_tables``): hidden parts shade one
another, and a few smooth shapes do not.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints, Points, Reals
from lod.stick_table import StickTable
from scenes.models.trees.grown_tree import GrownTree
from scenes.models.trees.simplification import (
    Blobs,
    cluster,
    error_diffusion,
    fit_radii,
    fitting_area,
    radius_step,
)
from scenes.sticks.outline_area import directions, mean_outline_areas
from scenes.sticks.view_dependence import ElevationTable
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas

VIEWS = 12
"""Directions from which the tree as a whole is compared, half of them from below."""

SIDE_VIEW = 0.5
"""Sine of the elevation below which a view counts as one from the side."""

UPRIGHTNESS_TOLERANCE = 0.05
"""How far the uprightness of the tree's coarsest shapes may be from its own, relative."""

RAYS = 300
"""Rays across the tree's largest extent in those views."""

STEPS = 4
"""Steps of each fit of the tree as a whole."""


@dataclass(frozen=True, eq=False)
class FullDetailViews:
    """A tree in full detail, seen from far off on all sides.

    views (v, 3)  unit vectors to the eye; spacing: of the rays [m]
    covers (v,)   area that the tree covers in each view [m²]
    colour (3,)   its mean albedo
    """

    views: np.ndarray
    spacing: float
    covers: np.ndarray
    colour: np.ndarray

    @property
    def cover(self) -> float:
        """Compute the mean area that the tree covers over all views [m²]."""
        return float(self.covers.mean())

    @property
    def uprightness(self) -> float:
        """Compute the uprightness of the tree."""
        return uprightness(self.views, self.covers)


def uprightness(views: Points, covers: Reals) -> float:
    """Compute the mean cover (v,) of views (v, 3) from the side over that from above and below."""
    side = np.abs(views[:, 2]) < SIDE_VIEW
    return float(covers[side].mean() / covers[~side].mean())


def leaf_appearances(tree: GrownTree) -> list[StickTable]:
    """Fit the leaf appearances of the parts of every level, the finest last: a table for each."""
    levels = [tree.branch_sticks(k) for k in range(len(tree.levels))]
    if len(tree.foliage.twig):
        levels.append(tree.foliage_sticks())
    full = _full_detail_views(StickTable.as_one_part(levels), tree.palette)
    appearances = []
    for depth in range(len(levels) - 1):
        above = StickTable.as_one_part([levels[0].take(np.zeros(0, np.int64)), *levels[:depth]])
        appearances.append(_level_appearance(tree, depth, above, full))
    return [*appearances, levels[-1]]


def _level_appearance(
    tree: GrownTree, depth: int, above: StickTable, full: FullDetailViews
) -> StickTable:
    """Fit the leaf appearances of the branches of one depth.

    That is how they look while nothing that they bear is displayed; ``above`` holds the sticks of
    all levels above theirs.
    """
    shapes, tables = tree.species.leaf_appearance, tree.species.tables
    borne, n = tree.borne_sticks(depth), len(tree.levels[depth])
    wood = tree.branch_sticks(depth, shapes.kept_segments[depth])
    hidden = tree.borne_sticks(depth, own=not len(wood))
    blobs, blob_of_stick = cluster(hidden, shapes.blob_count[depth])
    factor = fit_radii(blobs, wood, fitting_area(borne))
    kept = StickTable.merge([above, StickTable.as_one_part([wood])])
    factor = factor * _cover_factor(blobs, factor, kept, full)
    if depth == 0:
        blobs = _match_uprightness(blobs, factor, kept, full)
        factor = factor * _cover_factor(blobs, factor, kept, full)
    if tables.elevation:
        factor = factor * _cover_factor(blobs, factor, kept, full, tables.elevation[depth])
    own = _mean_albedos(hidden, blob_of_stick, len(blobs.part), tree.palette)
    albedo = tables.albedo_factor[depth] if tables.albedo_factor else 1.0
    if tables.azimuth_tone:
        albedo *= max(1.0, *tables.azimuth_tone[depth])
    wanted = _wanted_albedos(blobs.table(n, factor), own, kept, full, tree.palette)
    tint = _tints(wanted[0], albedo * wanted[1], tree.palette)
    return StickTable.merge([wood, blobs.table(n, factor, tint)])


def _cover_factor(
    blobs: Blobs,
    factor: Reals,
    kept: StickTable,
    full: FullDetailViews,
    by_elevation: ElevationTable | None = None,
) -> float:
    """Find the factor on radii of blobs with which the tree covers as much as in full detail.

    The blobs show, from each elevation, the share of their area that ``by_elevation`` says.
    """
    scale = 1.0
    for _ in range(STEPS):
        table = StickTable.as_one_part([blobs.table(len(factor), scale * factor)])
        covered = _covers(table, kept, full, by_elevation).mean()
        scale *= float(radius_step(np.array([full.cover]), np.array([covered]))[0])
    return scale


def _covers(
    shapes: StickTable, kept: StickTable, full: FullDetailViews, by_elevation: ElevationTable | None
) -> Reals:
    """Measure the area that kept sticks and shapes cover together in each view, (v,) [m²]."""
    if by_elevation is None:
        table = StickTable.merge([kept, shapes])
        return visible_areas(table, full.views, full.spacing).sum(axis=1)
    covers = []
    for view in full.views:
        shown = with_area_share(shapes, by_elevation.area_share_at(abs(view[2])))
        table = StickTable.merge([kept, shown])
        covers.append(visible_areas(table, view[None], full.spacing).sum())
    return np.array(covers)


def _match_uprightness(
    blobs: Blobs, factor: Reals, kept: StickTable, full: FullDetailViews
) -> Blobs:
    """Make the crown as a whole lower or taller until its blobs are as upright as the tree.

    Few shapes would fill the gaps between a spire's tiers: it then covers as much from the side,
    over from above, as the tree does.
    """
    share = 1.0
    for _ in range(STEPS):
        shapes = StickTable.as_one_part([blobs.flattened(share).table(len(factor), factor)])
        missing = full.uprightness / uprightness(full.views, _covers(shapes, kept, full, None))
        if abs(missing - 1) < UPRIGHTNESS_TOLERANCE:
            break
        share *= missing**1.3
    return blobs.flattened(share)


def _wanted_albedos(
    blobs: StickTable, own: Points, kept: StickTable, full: FullDetailViews, palette: np.ndarray
) -> tuple[Reals, Points]:
    """Choose albedos of blobs, about their own, that give all that is seen the tree's colour.

    Returns the area that is seen of each blob (g,) [m²], and its albedo (g, 3).
    """
    table = StickTable.merge([kept, StickTable.as_one_part([blobs])])
    area = visible_areas(table, full.views, full.spacing).mean(axis=0)
    of_kept, of_blobs = area[: len(kept)], area[len(kept) :]
    left = area.sum() * full.colour - of_kept @ palette[kept.tint]
    return of_blobs, np.clip(own + (left - of_blobs @ own) / of_blobs.sum(), 0, 1)


def _tints(weight: Reals, wanted: Points, palette: np.ndarray) -> Ints:
    """Choose rows of the palette for blobs of these weights and albedos.

    The trunk's bark is for the trunk alone.
    """
    return error_diffusion(weight, wanted, palette, np.arange(1, len(palette)))


def _mean_albedos(hidden: StickTable, group: Ints, groups: int, palette: np.ndarray) -> np.ndarray:
    """Compute the mean albedo of the sticks that each blob stands for, weighted by area, (g, 3)."""
    area, colour = mean_outline_areas(hidden), palette[hidden.tint]
    sums = [np.bincount(group, area * c, groups) for c in colour.T]
    return np.stack(sums, axis=1) / np.bincount(group, area, groups)[:, None]


def _full_detail_views(everything: StickTable, palette: Points) -> FullDetailViews:
    """Measure the views of a tree whose sticks are all of one part."""
    half = directions(VIEWS)
    views = half * np.where(np.arange(VIEWS) % 2, -1.0, 1.0)[:, None]
    ends = np.concatenate((everything.start, everything.end))
    spacing = float((ends.max(axis=0) - ends.min(axis=0)).max()) / RAYS
    areas = visible_areas(everything, views, spacing)
    area = areas.mean(axis=0)
    colour = area @ palette[everything.tint] / area.sum()
    return FullDetailViews(views, spacing, areas.sum(axis=1), colour)
