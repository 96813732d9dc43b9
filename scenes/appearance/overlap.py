"""How much of a leaf appearance and of the parts that it stands for lies in one another.

While the parts of a level show half of themselves, as when they fade (``lod.pruning.crossfade``),
the object is to cover as much as before and after. The share s of the leaf appearance that makes
it so, with the inner appearance whole, gives the overlap c of ``lod.pruning.area_scaling``: for a
hidden share of a half s = ½/(1 − c/2), so that c = 2 − 1/s.
"""

from typing import TYPE_CHECKING

import numpy as np

from lod.stick_table import StickTable
from scenes.appearance.crown_views import CrownViews
from scenes.appearance.part_sticks import PartSticks
from scenes.sticks.view_dependent_area import with_area_share

if TYPE_CHECKING:
    from scenes.appearance.fit import LevelAppearance

SEEN_FROM = (0, 2, 4)
"""Elevations, as rows of ELEVATIONS_DEG, over which cover is compared."""

GREATEST, LEAST = 0.97, -1.5
"""Bounds on an overlap."""

TOLERANCE = 2e-3
"""How near its cover is to be, relative."""

_STEPS = 4


def level_overlap(
    parts: PartSticks,
    level: int,
    leaf: "LevelAppearance",
    finer: "LevelAppearance | None",
    full: CrownViews,
) -> float:
    """Find the overlap of the leaf appearances of a level and of the parts that they stand for.

    finer  leaf appearances of those parts that own parts themselves; None where none does
    """
    shown = {e: _half_shown(parts, level, finer, e) for e in SEEN_FROM}
    weight = {e: full.weight[e] for e in SEEN_FROM}
    wanted = sum(weight[e] * full.covers[e] for e in SEEN_FROM)

    def missing(share: float) -> float:
        covered = 0.0
        for e in SEEN_FROM:
            blobs = with_area_share(leaf.blobs, max(share * leaf.area_share[e], 1e-6))
            wood = with_area_share(leaf.wood, share)
            table = StickTable.merge([shown[e], *(_one(each) for each in (blobs, wood))])
            covered += weight[e] * full.covered(table, e)
        return float(1 - covered / wanted)

    low, high = 1 / (2 - LEAST), 1 / (2 - GREATEST)
    lack, excess = missing(low), missing(high)
    for _ in range(_STEPS):  # cover grows with the share: regula falsi
        if lack <= 0 or excess >= 0:
            break
        middle = low + (high - low) * lack / (lack - excess)
        off = missing(middle)
        if abs(off) < TOLERANCE:
            return 2 - 1 / middle
        low, lack, high, excess = (
            (middle, off, high, excess) if off > 0 else (low, lack, middle, off)
        )
    nearest = low if abs(lack) < abs(excess) else high
    return 2 - 1 / nearest


def _half_shown(
    parts: PartSticks, level: int, finer: "LevelAppearance | None", elevation: int
) -> StickTable:
    """Everything that shows while the parts of a level's parts show half of themselves, but for
    its leaf appearances."""
    of = parts.own.owner
    inner = parts.own.take((parts.level <= level)[of])
    ends = parts.own.take(((parts.level == level + 1) & ~parts.owns)[of])
    tables = [_one(inner), _one(with_area_share(ends, 0.5))]
    if finer is not None:
        shares = 0.5, 0.5 * finer.area_share[elevation]
        for table, share in zip((finer.wood, finer.blobs), shares, strict=True):
            tables.append(_one(with_area_share(table, max(share, 1e-6))))
    return StickTable.merge(tables)


def _one(table: StickTable) -> StickTable:
    return table.with_owner(1, np.zeros(len(table), np.int64))
