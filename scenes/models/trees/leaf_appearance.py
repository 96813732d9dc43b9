"""Leaf appearances of a tree: few shapes that keep its silhouette, its gaps and its colour.

Level by level: blobs for every branch (``tree_blobs``), as thick as makes each cover on average
what it hides; then all of a level thicker or thinner by one factor, so that the tree displayed to
that level covers what the whole tree does, for neighbours overlap otherwise than what they stand
for; and tinted so that its mean colour, of what is seen, is that of the whole tree, but darker by
as much as what is hidden shades itself and its few smooth shapes do not.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints, Reals
from lod.stick_table import StickTable
from scenes.models.trees.growth import Branches, Leaves
from scenes.models.trees.parameters import TreeSpecies
from scenes.models.trees.simplification import (
    Blobs,
    blended_tints,
    fitted,
    fitting_area,
    gather,
    joined,
    radius_step,
)
from scenes.sticks.outline_area import directions, mean_outline_areas
from scenes.sticks.view_dependence import ElevationTable
from scenes.sticks.view_dependent_area import with_area_share
from scenes.sticks.visible_area import visible_areas

VIEWS = 12
"""Directions from which the tree as a whole is compared, half of them from below."""

LEVEL = 0.5
"""Sine of the height below which a view is from the side."""

UPRIGHT = 0.05
"""How much more or less upright than the tree its last shapes may be."""

RAYS = 300
"""Rays across the tree's largest extent there."""


@dataclass(frozen=True, eq=False)
class Grown:
    """A grown tree: branches of levels 0 (trunk) to twigs, leaves, and the tint of each leaf."""

    species: TreeSpecies
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

    def wood_tint(self, level: int) -> int:
        """Bark of the trunk, bark of branches; young twigs among leaves are half green."""
        young = 0 < level == len(self.levels) - 1 and len(self.leaves.twig) > 0
        return len(self.palette) - 1 if young else min(level, 1)

    def chains(self, level: int, keep: int | None = None) -> StickTable:
        """The chains of one level of branches as sticks, all of them or ``keep`` for each: of the
        trunk those below the crown.
        """
        branches = self.levels[level]
        segments = branches.nodes.shape[1] - 1
        keep = segments if keep is None else min(keep, segments)
        clear = self.species.leaf_appearance.clear_trunk_segments
        reach = segments if level or keep == segments else clear
        stops = np.rint(np.linspace(0, reach, keep + 1)).astype(np.int64)
        nodes, radii = branches.nodes[:, stops], branches.radii[:, stops]
        owner = np.repeat(np.arange(len(branches)), keep)
        ends = nodes[:, :-1].reshape(-1, 3), nodes[:, 1:].reshape(-1, 3)
        radii_of_ends = radii[:, :-1].ravel(), radii[:, 1:].ravel()
        tint = np.full(len(owner), self.wood_tint(level))
        return StickTable.of(len(branches), owner, *ends, *radii_of_ends, tint)

    def foliage(self) -> StickTable:
        """Leaves, each a part of its own."""
        leaves, n = self.leaves, len(self.leaves.twig)
        ends = leaves.start, leaves.end, leaves.start_radius, leaves.end_radius
        return StickTable.of(n, np.arange(n), *ends, self.leaf_tint)

    def grown_from(self, depth: int, own: bool = True) -> StickTable:
        """All sticks of each branch of one depth: its own, if asked, those of all that grow from
        it, leaves.
        """
        n, twigs = len(self.levels[depth]), len(self.levels) - 1
        tables = []
        for level in range(depth if own else depth + 1, twigs + 1):
            chains = self.chains(level)
            tables.append(owned(chains, self.ancestor(level, depth)[chains.owner], n))
        twig_owner = self.ancestor(twigs, depth)
        tables.append(owned(self.foliage(), twig_owner[self.leaves.twig], n))
        return joined(tuple(tables))


@dataclass(frozen=True, eq=False)
class Seen:
    """A tree from afar: rays that see it from all sides, its cover in each view (v,) and on average
    [m²], and mean colour (3,)."""

    views: np.ndarray
    spacing: float
    covers: np.ndarray
    colour: np.ndarray

    @property
    def cover(self) -> float:
        """The mean of all views [m²]."""
        return float(self.covers.mean())

    @property
    def uprightness(self) -> float:
        """What it covers from the side over what it covers from above and below."""
        return upright(self.views, self.covers)


def upright(views: np.ndarray, covers: Reals) -> float:
    """Mean cover of views from the side over that of the others."""
    level = np.abs(views[:, 2]) < LEVEL
    return float(covers[level].mean() / covers[~level].mean())


def leaf_appearances(tree: Grown) -> list[StickTable]:
    """Of the parts of every level, the finest last; those of one level in one table."""
    all_levels = [tree.chains(k) for k in range(len(tree.levels))]
    if len(tree.leaves.twig):
        all_levels.append(tree.foliage())
    seen = _seen(_as_one(tuple(all_levels)), tree.palette)
    looks = []
    for depth in range(len(all_levels) - 1):
        above = _as_one((_nothing(), *all_levels[:depth]))
        looks.append(_of_level(tree, depth, above, seen))
    return [*looks, all_levels[-1]]


def _of_level(tree: Grown, depth: int, above: StickTable, seen: Seen) -> StickTable:
    """What every branch of one depth looks like when nothing of it is displayed but itself."""
    shapes, tables = tree.species.leaf_appearance, tree.species.tables
    hidden, n = tree.grown_from(depth), len(tree.levels[depth])
    wood = tree.chains(depth, shapes.kept_segments[depth])
    lost = tree.grown_from(depth, own=not len(wood))
    blobs, group = gather(lost, shapes.blob_count[depth])
    factor = fitted(blobs, wood, fitting_area(hidden))
    standing = joined((above, _as_one((wood,))))
    factor = factor * _in_place(blobs, factor, standing, seen)
    if depth == 0:
        blobs = _as_tall(blobs, factor, standing, seen)
        factor = factor * _in_place(blobs, factor, standing, seen)
    if tables.elevation:
        factor = factor * _in_place(blobs, factor, standing, seen, tables.elevation[depth])
    own = _mean_colours(lost, group, len(blobs.part), tree.palette)
    albedo = tables.albedo_factor[depth] if tables.albedo_factor else 1.0
    if tables.azimuth_tone:
        albedo *= max(1.0, *tables.azimuth_tone[depth])
    tint = _tints(blobs.table(n, factor), own, albedo, standing, seen, tree.palette)
    return joined((wood, blobs.table(n, factor, tint)))


def _in_place(
    blobs: Blobs,
    factor: Reals,
    standing: StickTable,
    seen: Seen,
    looks: ElevationTable | None = None,
) -> float:
    """One factor for all blobs so that the tree covers as much as all of it does, with what is left
    of them from each height."""
    scale = 1.0
    for _ in range(4):
        table = _as_one((blobs.table(len(factor), scale * factor),))
        covered = _covers(table, standing, seen, looks).mean()
        scale *= float(radius_step(np.array([seen.cover]), np.array([covered]))[0])
    return scale


def _covers(
    shapes: StickTable, standing: StickTable, seen: Seen, looks: ElevationTable | None
) -> Reals:
    """What the tree covers in each view with what is left of its shapes there, (v,) [m²]."""
    if looks is None:
        return visible_areas(joined((standing, shapes)), seen.views, seen.spacing).sum(axis=1)
    left = [with_area_share(shapes, looks.area_share_at(abs(view[2]))) for view in seen.views]
    return np.array(
        [
            visible_areas(joined((standing, each)), view[None], seen.spacing).sum()
            for each, view in zip(left, seen.views, strict=True)
        ]
    )


def _as_tall(blobs: Blobs, factor: Reals, standing: StickTable, seen: Seen) -> Blobs:
    """The crown as a whole, lower or taller, so that it covers as much from the side as from above:
    few shapes fill what is gaps between a spire's tiers."""
    share = 1.0
    for _ in range(4):
        table = joined((standing, _as_one((blobs.flattened(share).table(len(factor), factor),))))
        covers = visible_areas(table, seen.views, seen.spacing).sum(axis=1)
        missing = seen.uprightness / upright(seen.views, covers)
        if abs(missing - 1) < UPRIGHT:
            break
        share *= missing**1.3
    return blobs.flattened(share)


def _tints(
    blobs: StickTable,
    own: np.ndarray,
    albedo_factor: float,
    standing: StickTable,
    seen: Seen,
    palette: np.ndarray,
) -> Ints:
    """Tints of blobs about their own colours (g, 3), so that all that is seen has the tree's, less
    what hidden leaves shade one another."""
    table = joined((standing, _as_one((blobs,))))
    area = visible_areas(table, seen.views, seen.spacing).mean(axis=0)
    wooden, weight = area[: len(standing)], area[len(standing) :]
    left = area.sum() * seen.colour - wooden @ palette[standing.tint]
    wanted = own + (left - weight @ own) / weight.sum()
    wanted = albedo_factor * np.clip(wanted, 0, 1)
    return blended_tints(weight, wanted, palette, np.arange(1, len(palette)))


def _mean_colours(hidden: StickTable, group: Ints, groups: int, palette: np.ndarray) -> np.ndarray:
    """Mean colour of the sticks that each blob stands for, by their area, (g, 3)."""
    area, colour = mean_outline_areas(hidden), palette[hidden.tint]
    sums = [np.bincount(group, area * c, groups) for c in colour.T]
    return np.stack(sums, axis=1) / np.bincount(group, area, groups)[:, None]


def _seen(everything: StickTable, palette: np.ndarray) -> Seen:
    half = directions(VIEWS)
    views = half * np.where(np.arange(VIEWS) % 2, -1.0, 1.0)[:, None]
    ends = np.concatenate((everything.start, everything.end))
    spacing = float((ends.max(axis=0) - ends.min(axis=0)).max()) / RAYS
    areas = visible_areas(everything, views, spacing)
    area = areas.mean(axis=0)
    colour = area @ palette[everything.tint] / area.sum()
    return Seen(views, spacing, areas.sum(axis=1), colour)


def owned(table: StickTable, owner: Ints, n: int) -> StickTable:
    """The same sticks with other owners, among n parts."""
    columns = (table.start, table.end, table.start_radius, table.end_radius, table.tint)
    return StickTable.of(n, owner, *columns)


def _as_one(tables: tuple[StickTable, ...]) -> StickTable:
    """The sticks of all parts as one part."""
    return joined(tuple(owned(table, np.zeros(len(table), np.int64), 1) for table in tables))


def _nothing() -> StickTable:
    points, none = np.zeros((0, 3)), np.zeros(0)
    return StickTable(np.zeros(2, np.int64), points, points, none, none, none.astype(np.int64))
