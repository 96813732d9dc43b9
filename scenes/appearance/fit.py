"""Fit of leaf appearances to what they hide: silhouette, gaps and colour, for any part hierarchy.

``docs/appearance.md`` has the procedure, step by step. Blobs are a stochastic simplification, after
R. Cook, J. Halstead, M. Planck & D. Ryu, "Stochastic simplification of aggregate detail", SIGGRAPH
2007: of many like elements few are kept, enlarged so that they cover the same area. Here the few
are drawn evenly (a k-d tree), and each group becomes one stick along its longest spread. They stay
apart, so that the crown keeps its gaps. A flat spray, as a conifer's boughs are, is halved across
its width: sticks are round, and only several side by side cover much from above and little from the
side.

The overlap c of ``lod.pruner`` follows from the share s of the leaf appearance with which the
object, while the parts of a level show half of themselves, covers what it does with all of them and
with none, in the mean: for a hidden share of a half s = ½/(1 − c/2), so that c = 2 − 1/s.
"""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np
from jaxtyping import Bool, Float64, Int64

from lod.arrays import Ints, Points, Reals
from lod.kernels import map_chunks, njit
from lod.shapes import StickTable
from scenes.appearance.visible_area import CrownViews, look_at, seen_areas
from scenes.processes.cache import kept, rounded_key
from scenes.processes.progress import tell
from scenes.sticks.areas import (
    COARSE,
    ELEVATIONS_DEG,
    ViewDependence,
    directions,
    mean_area,
    mean_outline_areas,
    with_area_share,
)
from scenes.sticks.prototype import PartSticks, Shapes

MOSTLY = 0.4
"""Share of a part's own stick that must be seen, over all directions, for the stick to stay."""

WORTH = 0.01  # least share of what a part covers that the sticks that stay have together
STEPS = 3  # steps to the right cover from each elevation
CODE = ("lod", "scenes.sticks", "scenes.appearance")  # sources that a fit depends on

_COLUMNS = tuple(each.name for each in fields(StickTable))

FITTING_DIRECTIONS = 16

_FULLEST = 2.236
"""√5: half an axis of an even ellipsoid, as a share of its standard deviation along it."""

FLAT = 2.0
"""The square of a flat spray's width over its length times its thickness: more in a plate, 1 in a
ball, less in a rod."""

BLOBS_PER_DECADE = 1.2  # blobs for each tenfold of the sticks that they stand for

_STEP = 0.7
"""Power of the missing area by which radii grow: converges for thin sticks and for round blobs."""

SEEN_FROM = (0, 2, 4)  # elevations, as rows of ELEVATIONS_DEG, over which cover is compared

GREATEST, LEAST = 0.97, -1.5  # bounds on an overlap

TOLERANCE = 2e-3  # how near its cover is to be, relative

_STEPS = 4
_NOTHING = 1e-6  # a share of area at which a stick is too thin to be met


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


@dataclass(frozen=True, eq=False)
class LevelAppearance:
    """Leaf appearances of the m inner parts of one level.

    wood, blobs      what they keep of their own, and what stands for the rest, of m parts
    area_share (e,)  share of the blobs' area that shows from each of ELEVATIONS_DEG
    """

    wood: StickTable
    blobs: StickTable
    area_share: Reals

    def shown(self, share: float, elevation: int) -> tuple[StickTable, StickTable]:
        """Return a share of all of them, as they look from a row of ELEVATIONS_DEG."""
        wood = with_area_share(self.wood, max(share, _NOTHING))
        blobs = with_area_share(self.blobs, max(share * self.area_share[elevation], _NOTHING))
        return wood, blobs


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
    key = rounded_key(parts.parent, parts.level, own, parts.palette, meshes, chosen)
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
    colour = full.seen @ whole.albedos(parts.palette) / full.seen.sum()  # mean of what is seen
    levels = [_fit_level(parts, k, full, colour, mostly) for k in range(parts.finest)]
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


def _fit_level(
    parts: PartSticks,
    level: int,
    full: CrownViews,
    colour: Float64[np.ndarray, "3"],
    seen: Bool[np.ndarray, " k"],
) -> LevelAppearance:
    """Fit the leaf appearances of the parts of one level that own parts.

    full, colour: what the object is to look like at every level, and its mean albedo (3,)
    seen (k,)     which sticks are mostly seen
    """
    if parts.chosen is not None:
        blobs = parts.chosen.of_parts((parts.level == level) & parts.owns)
        wood, own = blobs.take(np.zeros(0, np.int64)), parts.palette[blobs.tint]
        kept = parts.shown(parts.above(level))
    else:
        rows, bearer = parts.inner_rows(level), parts.bearer(level)
        m = len(rows)
        borne = bearer >= 0
        target = fitting_area(parts.own.take(borne).with_owner(m, bearer[borne]))
        wood, stays = _kept_wood(parts, rows, seen, target)
        hides = borne & ~stays
        order = np.flatnonzero(hides)[np.argsort(bearer[hides], kind="stable")]
        hidden = parts.own.take(hides).with_owner(m, bearer[hides])
        tenfolds = np.log10(np.maximum(hidden.count, 2))
        counts = np.ceil(BLOBS_PER_DECADE * tenfolds).astype(np.int64)
        groups, blob_of_stick = cluster(hidden, counts)
        blobs = groups.table(m, fit_radii(groups, wood, target))
        kept = parts.shown(parts.above(level)).with_sticks(wood)
        # The mean albedo of the sticks that each blob stands for, by their area.
        area, albedo = mean_outline_areas(hidden), parts.palette[parts.own.tint[order]]
        sums = [np.bincount(blob_of_stick, area * c, len(blobs)) for c in albedo.T]
        own = np.stack(sums, axis=1) / np.bincount(blob_of_stick, area, len(blobs))[:, None]
    share = _fit_area_share(blobs, kept, full)
    thick = with_area_share(blobs, share.max())
    # Tints about the blobs' own albedos, so that all that is seen has the object's mean albedo.
    palette, sticks = parts.palette, len(kept.sticks)
    shown = kept.with_sticks(thick)
    area = full.weight @ seen_areas(shown, full.toward, full.spacing)
    is_blob = np.zeros(len(area), np.bool_)
    is_blob[sticks : sticks + len(thick)] = True
    of_kept, of_blobs = area[~is_blob], area[is_blob]
    left = area.sum() * colour - of_kept @ kept.albedos(palette)
    shift = (left - of_blobs @ own) / max(of_blobs.sum(), 1e-9)
    wanted = np.clip(own + shift, 0, 1)
    tint = error_diffusion(of_blobs, wanted, palette, np.unique(parts.own.tint))
    return LevelAppearance(wood, replace(thick, tint=tint), share / share.max())


def _kept_wood(
    parts: PartSticks,
    rows: Int64[np.ndarray, " m"],
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


@dataclass(frozen=True, eq=False)
class Blobs:
    """Sticks that stand for groups of hidden sticks, by their middles.

    part (g,)       part that owns each blob
    centre (g, 3)   its middle [m]; axis (g, 3): unit vector along it
    reach (g,)      half the length of the group along the axis; radius (g,): of it across [m]
    """

    part: np.ndarray
    centre: np.ndarray
    axis: np.ndarray
    reach: np.ndarray
    radius: np.ndarray

    def table(self, parts: int, factor: Reals, tint: np.ndarray | None = None) -> StickTable:
        """Return the blobs as sticks of ``parts`` parts, as long over all as their groups are.

        Their radii are multiplied by the factor of their part (n,).
        """
        radius = self.radius * factor[self.part]
        half = np.maximum(self.reach - radius, 0.25 * radius)[:, None] * self.axis
        # One end plumper than the other, as a bough of leaves is.
        radii = 1.1 * radius, 0.85 * radius
        tint = np.zeros(len(self.part), np.int64) if tint is None else tint
        return StickTable.of(parts, self.part, self.centre - half, self.centre + half, *radii, tint)


def cluster(hidden: StickTable, max_blobs: Ints) -> tuple[Blobs, Int64[np.ndarray, " k"]]:
    """Gather the hidden sticks of each part into at most ``max_blobs`` (n,) blobs.

    Returns the blobs, and the blob of each stick, (k,).
    """
    weight, owner = mean_outline_areas(hidden), hidden.owner
    # Sticks are split along their middles, those of a flat spray along how far these are aside.
    middle = (hidden.start + hidden.end) / 2
    centre, axes, extent = _ellipsoids(hidden, weight, owner, len(hidden.first) - 1)
    flat = extent[:, 1] ** 2 > FLAT * extent[:, 0] * extent[:, 2]
    aside = np.zeros_like(middle)
    aside[:, 0] = ((middle - centre[owner]) * axes[owner, :, 1]).sum(axis=1)
    points = np.where(flat[owner][:, None], aside, middle)
    group, part = _stratify(hidden.first, points, weight, max_blobs)
    centre, axes, extent = _ellipsoids(hidden, weight, group, len(part))
    radius = np.sqrt(extent[:, 0] * extent[:, 1])
    return Blobs(part, centre, axes[:, :, 2], extent[:, 2], radius), group


def _ellipsoids(
    hidden: StickTable, weight: Reals, group: Ints, groups: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit ellipsoids of even density to groups of sticks, by their covariance.

    Returns their centres (g, 3) [m], axes as columns (g, 3, 3), the longest last, and half their
    lengths (g, 3) [m].
    """
    points = np.concatenate((hidden.start, hidden.end))
    of, weights = np.concatenate((group, group)), np.concatenate((weight, weight))
    total = np.bincount(of, weights, groups)
    centre = _grouped_sums(of, points * weights[:, None], groups) / total[:, None]
    offset = points - centre[of]
    products = (offset[:, :, None] * offset[:, None, :]).reshape(-1, 9) * weights[:, None]
    spread = _grouped_sums(of, products, groups).reshape(-1, 3, 3) / total[:, None, None]
    values, axes = np.linalg.eigh(spread)
    return centre, axes, _FULLEST * np.sqrt(np.maximum(values, 1e-8))


def fit_radii(blobs: Blobs, wood: StickTable, target: Reals, rounds: int = 6) -> Reals:
    """Fit the factor (n,) on the radii of each part's blobs.

    They and the part's own wood then cover the target area (n,) [m²] on average over directions.
    """
    factor = np.full(len(target), 0.7)
    bare = fitting_area(wood)
    for _ in range(rounds):
        covered = fitting_area(StickTable.merge((wood, blobs.table(len(target), factor))))
        ratio = (target - bare) / np.maximum(covered - bare, 1e-12)
        factor *= np.clip(ratio, 0.1, 4.0) ** _STEP
    return factor


def fitting_area(table: StickTable) -> Reals:
    """Measure the mean area over directions that each part covers, in coarse rows, (n,) [m²]."""
    return mean_area(table, directions(FITTING_DIRECTIONS), COARSE)


def error_diffusion(
    weight: Reals,
    wanted: Points,
    palette: Float64[np.ndarray, "t 3"],
    allowed: Int64[np.ndarray, " a"],
) -> Ints:
    """Choose a tint of the palette for each blob, so that their weighted mean is as wanted.

    Error diffusion from blob to blob (after Floyd & Steinberg 1976).
    """
    return allowed[_diffuse_error(weight, wanted, palette[allowed])]


def _grouped_sums(group: Ints, values: np.ndarray, groups: int) -> np.ndarray:
    columns = [np.bincount(group, values[:, k], groups) for k in range(values.shape[1])]
    return np.stack(columns, axis=1)


@njit(cache=True)
def _stratify(first, centre, weight, max_blobs):  # type: ignore[no-untyped-def]
    """Halve the heaviest group of each part until it has ``max_blobs`` (n,) groups.

    Returns the group of each stick, and the part of each group.
    """
    group = np.empty(len(centre), np.int64)
    part = np.empty(max_blobs.sum(), np.int64)
    order = np.arange(len(centre))
    groups = 0
    low, high, heavy = (
        np.empty(max_blobs.max(), np.int64),
        np.empty(max_blobs.max(), np.int64),
        np.empty(max_blobs.max()),
    )
    for i in range(len(first) - 1):
        low[0], high[0], n = first[i], first[i + 1], 1
        heavy[0] = weight[first[i] : first[i + 1]].sum()
        while n < max_blobs[i]:
            widest = np.argmax(heavy[:n])
            a, b = low[widest], high[widest]
            if b - a < 2:
                break
            _sort_along_longest(order, centre, a, b)
            middle, half = a, 0.0
            while middle < b - 1 and (middle == a or half < heavy[widest] / 2):
                half += weight[order[middle]]
                middle += 1
            heavy[n], heavy[widest] = heavy[widest] - half, half
            high[widest], low[n], high[n] = middle, middle, b
            n += 1
        for k in range(n):
            if high[k] > low[k]:
                part[groups] = i
                group[order[low[k] : high[k]]] = groups
                groups += 1
    return group, part[:groups]


@njit(cache=True)
def _sort_along_longest(order, centre, a, b):  # type: ignore[no-untyped-def]
    """Sort order[a:b] along the axis on which those points reach furthest."""
    axis, longest = 0, -1.0
    for k in range(3):
        lowest = highest = centre[order[a], k]
        for i in range(a, b):
            value = centre[order[i], k]
            lowest, highest = min(lowest, value), max(highest, value)
        if highest - lowest > longest:
            axis, longest = k, highest - lowest
    for gap in (701, 301, 132, 57, 23, 10, 4, 1):  # Shell sort, gaps of Ciura 2001
        for i in range(a + gap, b):
            row, k = order[i], i
            while k >= a + gap and centre[order[k - gap], axis] > centre[row, axis]:
                order[k] = order[k - gap]
                k -= gap
            order[k] = row


@njit(cache=True)
def _diffuse_error(weight, wanted, palette):  # type: ignore[no-untyped-def]
    chosen = np.empty(len(weight), np.int64)
    owed = np.zeros(3)
    least = 0.1 * weight.mean()  # what is hardly seen cannot make up for the rest
    for g in range(len(weight)):
        best, smallest = 0, np.inf
        for t in range(len(palette)):
            error = 0.0
            for k in range(3):
                error += (wanted[g, k] + owed[k] / max(weight[g], least) - palette[t, k]) ** 2
            if error < smallest:
                best, smallest = t, error
        chosen[g] = best
        for k in range(3):
            owed[k] += weight[g] * (wanted[g, k] - palette[best, k])
    return chosen


def measure_overlap(
    parent: Ints, level: Ints, inner: StickTable, leaf: StickTable, palette: np.ndarray
) -> Reals:
    """Measure the overlap of every part of an object from its two appearances, (n,).

    Parts of one level have one overlap; it is 0 for parts that own none. The appearances look the
    same from everywhere. What was measured before is found where it is kept.
    """

    def make() -> dict[str, np.ndarray]:
        owns = np.zeros(len(parent), np.bool_)
        owns[parent[parent >= 0]] = True
        own = StickTable.merge([inner.only(owns), leaf.only(~owns)])
        parts = PartSticks(parent, level, own, palette)
        always = np.ones(len(ELEVATIONS_DEG))
        levels = []
        for k in range(parts.finest):
            table = leaf.of_parts((level == k) & owns)
            levels.append(LevelAppearance(table.take(np.zeros(0, np.int64)), table, always))
        return {"overlap": overlaps(parts, levels, look_at(Shapes.of(own)))}

    return kept("overlap", rounded_key(parent, level, inner, leaf, palette), make, CODE)["overlap"]


def overlaps(parts: PartSticks, levels: Sequence[LevelAppearance], views: CrownViews) -> Reals:
    """Find the overlap of every part, one for each level; 0 for parts that own none, (n,)."""
    found = np.zeros(len(parts.parent))
    for k in range(len(levels)):
        found[parts.inner_rows(k)] = _level_overlap(parts, k, levels, views)
    return found


def _level_overlap(
    parts: PartSticks, level: int, levels: Sequence[LevelAppearance], views: CrownViews
) -> float:
    """Find the overlap of the leaf appearances of a level and of the parts they stand for."""
    inner = _displayed(parts, level, levels, 0.5)

    def mean_cover(shown: dict[int, Shapes]) -> float:
        def run(first: int, last: int) -> list[float]:
            return [views.weight[e] * views.covered(shown[e], e) for e in SEEN_FROM[first:last]]

        return sum(each for some in map_chunks(run, len(SEEN_FROM), 1) for each in some)

    above = parts.shown(parts.above(level))
    without = {e: above.with_sticks(*levels[level].shown(1.0, e)) for e in SEEN_FROM}
    wanted = (mean_cover(_displayed(parts, level, levels, 1.0)) + mean_cover(without)) / 2

    def missing(share: float) -> float:
        shown = {e: inner[e].with_sticks(*levels[level].shown(share, e)) for e in SEEN_FROM}
        return 1 - mean_cover(shown) / wanted

    low, high = 1 / (2 - LEAST), 1 / (2 - GREATEST)
    lack, excess = missing(low), missing(high)
    for _ in range(_STEPS):  # cover grows with the share: regula falsi
        if lack <= 0 or excess >= 0:
            break
        middle = low + (high - low) * lack / (lack - excess)
        off = missing(middle)
        if abs(off) < TOLERANCE:
            return 2 - 1 / middle
        if off > 0:
            low, lack = middle, off
        else:
            high, excess = middle, off
    return 2 - 1 / (low if abs(lack) < abs(excess) else high)


def _displayed(
    parts: PartSticks, level: int, levels: Sequence[LevelAppearance], share: float
) -> dict[int, Shapes]:
    """Everything that shows while the parts of a level's parts show a share of themselves.

    The leaf appearances of the level are left out. There are shapes for each of SEEN_FROM.
    """
    finer = level + 1
    inner = parts.shown(parts.level <= level)
    shown = inner.merged(parts.shown((parts.level == finer) & ~parts.owns, share))
    if finer >= len(levels):
        return dict.fromkeys(SEEN_FROM, shown)
    return {e: shown.with_sticks(*levels[finer].shown(share, e)) for e in SEEN_FROM}
