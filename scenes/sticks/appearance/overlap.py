"""How much of a leaf appearance and of the parts that it stands for lies in one another.

While the parts of a level show half of themselves, as when they fade (``lod.crossfade``),
the object is to cover what it does with all of them and with none, in the mean. The share s of the
leaf appearance that makes it so, with the inner appearance whole, gives the overlap c of
``lod.crossfade``: for a hidden share of a half s = ½/(1 − c/2), so that c = 2 − 1/s.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints, Reals
from lod.shapes import StickTable
from lod.threads import map_chunks
from scenes.sticks.appearance.crown_views import CrownViews, look_at
from scenes.sticks.appearance.part_sticks import PartSticks
from scenes.sticks.shapes import Shapes
from scenes.sticks.view_angles import ELEVATIONS_DEG
from scenes.sticks.view_dependent_area import with_area_share

SEEN_FROM = (0, 2, 4)
"""Elevations, as rows of ELEVATIONS_DEG, over which cover is compared."""

GREATEST, LEAST = 0.97, -1.5
"""Bounds on an overlap."""

TOLERANCE = 2e-3
"""How near its cover is to be, relative."""

_STEPS = 4
_NOTHING = 1e-6  # a share of area at which a stick is too thin to be met


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


def measure_overlap(
    parent: Ints, level: Ints, inner: StickTable, leaf: StickTable, palette: np.ndarray
) -> Reals:
    """Measure the overlap of every part of an object from its two appearances, (n,).

    Parts of one level have one overlap; it is 0 for parts that own none. The appearances look the
    same from everywhere.
    """
    owns = np.zeros(len(parent), np.bool_)
    owns[parent[parent >= 0]] = True
    own = StickTable.merge([inner.only(owns), leaf.only(~owns)])
    parts = PartSticks(parent, level, own, palette)
    always = np.ones(len(ELEVATIONS_DEG))
    levels = []
    for k in range(parts.finest):
        table = leaf.of_parts((level == k) & owns)
        levels.append(LevelAppearance(table.take(np.zeros(0, np.int64)), table, always))
    return overlaps(parts, levels, look_at(Shapes.of(own)))


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
