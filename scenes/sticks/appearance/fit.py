"""Fit of leaf appearances to what they hide: silhouette, gaps and colour, for any part hierarchy.

Level by level, every part that owns parts gets a few blobs (``simplification``), as thick as makes
them cover on average what they hide. Of its own sticks those stay that are mostly seen, such as the
clear trunk of a tree. Then all blobs of a level are made thicker or thinner, by one factor for each
elevation of the eye, so that the object displayed down to that level covers from there what it does
in full detail: neighbours overlap otherwise than what they stand for. Shapes that a model has
chosen for its parts (``PartSticks.chosen``) are fitted from there on. Tints are chosen so that the
mean albedo of all that is seen is the object's. How brightly they shine is another fit
(``scenes.sticks.appearance.tone``).
"""

from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from lod.arrays import Flags, Ints, Points, Reals
from lod.shapes import StickTable
from lod.threads import map_chunks
from scenes.processes.content_cache import kept
from scenes.processes.content_key import content_key
from scenes.processes.progress import tell
from scenes.sticks.appearance.crown_views import CrownViews, look_at
from scenes.sticks.appearance.overlap import LevelAppearance, overlaps
from scenes.sticks.appearance.part_sticks import PartSticks
from scenes.sticks.appearance.simplification import (
    blob_counts,
    cluster,
    error_diffusion,
    fit_radii,
    fitting_area,
)
from scenes.sticks.outline_area import mean_outline_areas
from scenes.sticks.shapes import Shapes
from scenes.sticks.view_angles import ELEVATIONS_DEG
from scenes.sticks.view_dependence import ViewDependence
from scenes.sticks.view_dependent_area import with_area_share

MOSTLY = 0.4
"""Share of a part's own stick that must be seen, over all directions, for the stick to stay."""

WORTH = 0.01
"""Least share of what a part covers that the sticks that stay have together."""

STEPS = 3
"""Steps to the right cover from each elevation."""


CODE = ("lod", "scenes.sticks", "scenes.terrain.colour")
"""Sources that a fit depends on."""

_COLUMNS = tuple(each.name for each in fields(StickTable))


@dataclass(frozen=True, eq=False)
class FittedAppearances:
    """Leaf appearances of the n parts of an object.

    leaf             sticks of each part; those of parts that own none are their own
    view_dependence  tables of the blobs among them, one row for each level
    overlap (n,)     as in Hierarchy
    """

    leaf: StickTable
    view_dependence: ViewDependence
    overlap: Reals


def fit_appearances(parts: PartSticks) -> FittedAppearances:
    """Fit the leaf appearances of all parts of an object, or find them where they are kept."""

    def make() -> dict[str, np.ndarray]:
        found = _fit(parts)
        tell(1.0)
        columns = dict(zip(_COLUMNS, (found.leaf.first, *found.leaf.columns), strict=True))
        views = found.view_dependence
        tables = {"table_row": views.table_row, "area_share": views.area_share}
        return {**columns, **tables, "overlap": found.overlap}

    own = parts.own.first, *parts.own.columns
    meshes = None if parts.meshes is None else (parts.meshes.first_face, *parts.meshes.surface)
    chosen = None if parts.chosen is None else (parts.chosen.first, *parts.chosen.columns)
    key = content_key(parts.parent, parts.level, own, parts.palette, meshes, chosen)
    arrays = kept("appearance", key, make, CODE)
    leaf = StickTable(*(arrays[name] for name in _COLUMNS))
    views = ViewDependence.of_area(arrays["table_row"], arrays["area_share"])
    return FittedAppearances(leaf, views, arrays["overlap"])


def _fit(parts: PartSticks) -> FittedAppearances:
    n = len(parts.parent)
    whole = parts.shown(np.ones(n, np.bool_))
    full, seen = look_at(whole), np.zeros(len(parts.own))
    seen[parts.shows_sticks] = full.seen[: len(whole.sticks)]
    mostly = seen >= MOSTLY * np.maximum(mean_outline_areas(parts.own), 1e-12)
    goal = _Goal(full, full.mean_colour(whole, parts.palette))
    levels = [_fit_level(parts, k, goal, mostly) for k in range(parts.finest)]
    ends = parts.own.only(~parts.owns)
    tables, rows = [ends], [np.full(len(ends), -1)]
    for k, each in enumerate(levels):
        at = parts.inner_rows(k)
        for row, table in ((-1, each.wood), (k, each.blobs)):
            tables.append(table.with_owner(n, at[table.owner]))
            rows.append(np.full(len(table), row))
    owner = np.concatenate([table.owner for table in tables])
    in_order = np.concatenate(rows)[np.argsort(owner, kind="stable")]
    shares = np.array([each.area_share for each in levels]).reshape(-1, len(ELEVATIONS_DEG))
    leaf, overlap = StickTable.merge(tables), overlaps(parts, levels, full)
    return FittedAppearances(leaf, ViewDependence.of_area(in_order, shares), overlap)


@dataclass(frozen=True, eq=False)
class _Goal:
    """What an object is to look like at every level: its views, and its mean albedo (3,)."""

    views: CrownViews
    colour: Reals


def _fit_level(parts: PartSticks, level: int, goal: _Goal, seen: Flags) -> LevelAppearance:
    """Fit the leaf appearances of the parts of one level that own parts."""
    if parts.chosen is not None:
        return _fit_chosen(parts, level, parts.chosen, goal)
    rows, bearer = parts.inner_rows(level), parts.bearer(level)
    m, borne = len(rows), bearer >= 0
    all_borne = parts.own.take(borne).with_owner(m, bearer[borne])
    target = fitting_area(all_borne)
    wood, stays = _kept_wood(parts, rows, bearer, seen, target)
    hides = borne & ~stays
    order = np.flatnonzero(hides)[np.argsort(bearer[hides], kind="stable")]
    hidden = parts.own.take(hides).with_owner(m, bearer[hides])
    blobs, blob_of_stick = cluster(hidden, blob_counts(hidden.count))
    factor = fit_radii(blobs, wood, target)
    kept = parts.shown(parts.above(level)).with_sticks(wood)
    share = _fit_area_share(blobs.table(m, factor), kept, goal.views)
    thick = with_area_share(blobs.table(m, factor), share.max())
    own = _mean_albedos(parts.own.tint[order], hidden, blob_of_stick, len(blobs.part), parts)
    tint = _tints(thick, own, kept, goal, parts)
    shown = replace(thick, tint=tint)
    return LevelAppearance(wood, shown, share / share.max())


def _fit_chosen(parts: PartSticks, level: int, chosen: StickTable, goal: _Goal) -> LevelAppearance:
    """Fit thickness and tints of the shapes that were chosen for the parts of one level."""
    blobs = chosen.of_parts((parts.level == level) & parts.owns)
    kept = parts.shown(parts.above(level))
    share = _fit_area_share(blobs, kept, goal.views)
    thick = with_area_share(blobs, share.max())
    tint = _tints(thick, parts.palette[blobs.tint], kept, goal, parts)
    nothing = blobs.take(np.zeros(0, np.int64))
    return LevelAppearance(nothing, replace(thick, tint=tint), share / share.max())


def _kept_wood(
    parts: PartSticks,
    rows: Int64[np.ndarray, " m"],
    bearer: Int64[np.ndarray, " k"],
    seen: Bool[np.ndarray, " k"],
    target: Float64[np.ndarray, " m"],
) -> tuple[StickTable, Bool[np.ndarray, " k"]]:
    """Choose what parts keep of their own sticks, as a table of m parts, and which those are, (k,).

    It is the run of sticks from the part's base on that are mostly seen, if that is worth it: two
    at most, along a chain of more.
    """
    own, m = parts.own, len(rows)
    stays, chosen = np.zeros(len(own), np.bool_), []
    outline = mean_outline_areas(own)
    for number, row in enumerate(rows):
        first, last = own.first[row], own.first[row + 1]
        hidden = np.flatnonzero(~seen[first:last])
        end = first + (hidden[0] if len(hidden) else last - first)
        if outline[first:end].sum() < WORTH * target[number]:
            continue
        stays[first:end] = True
        middle = (first + end) // 2 if end - first > 2 else end - 1
        chosen += [
            (number, a, b) for a, b in ((first, middle), (middle + 1, end - 1)) if first <= a <= b
        ]
    owner, a, b = np.array(chosen, np.int64).reshape(-1, 3).T
    columns = own.start[a], own.end[b], own.start_radius[a], own.end_radius[b], own.tint[a]
    return StickTable.of(m, owner, *columns), stays


def _fit_area_share(blobs: StickTable, kept: Shapes, full: CrownViews) -> Reals:
    """Find which share of their area blobs show from each elevation, (e,), over 1 or below.

    The object then covers as much as in full detail.
    """

    def at(e: int) -> float:
        bare, share, wanted = full.covered(kept, e) if len(kept) else 0.0, 1.0, full.covers[e]
        for _ in range(STEPS):
            shown = kept.with_sticks(with_area_share(blobs, share))
            ratio = (wanted - bare) / max(full.covered(shown, e) - bare, 1e-9)
            share = float(np.clip(share * np.clip(ratio, 0.3, 3.0) ** 1.2, 0.05, 8.0))
        return share

    found = map_chunks(lambda first, last: [at(e) for e in range(first, last)], len(full.covers), 1)
    return np.array([share for some in found for share in some])


def _mean_albedos(
    tint: Ints, hidden: StickTable, group: Ints, groups: int, parts: PartSticks
) -> Float64[np.ndarray, "g 3"]:
    """Compute the mean albedo of the sticks that each blob stands for, by their area, (g, 3)."""
    area, colour = mean_outline_areas(hidden), parts.palette[tint]
    sums = [np.bincount(group, area * c, groups) for c in colour.T]
    return np.stack(sums, axis=1) / np.bincount(group, area, groups)[:, None]


def _tints(blobs: StickTable, own: Points, kept: Shapes, goal: _Goal, parts: PartSticks) -> Ints:
    """Choose rows of the palette for blobs, about their own albedos (g, 3).

    All that is seen has the object's mean albedo then.
    """
    palette, sticks = parts.palette, len(kept.sticks)
    area = goal.views.weight @ goal.views.seen_areas(kept.with_sticks(blobs))
    is_blob = np.zeros(len(area), np.bool_)
    is_blob[sticks : sticks + len(blobs)] = True
    of_kept, of_blobs = area[~is_blob], area[is_blob]
    left = area.sum() * goal.colour - of_kept @ kept.albedos(palette)
    shift = (left - of_blobs @ own) / max(of_blobs.sum(), 1e-9)
    wanted = np.clip(own + shift, 0, 1)
    return error_diffusion(of_blobs, wanted, palette, np.unique(parts.own.tint))
