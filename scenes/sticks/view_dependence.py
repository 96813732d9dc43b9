"""View dependence of leaf appearances: their area and brightness by elevation and azimuth.

A few smooth shapes that stand for hidden parts cover and shine otherwise than those parts do: the
gaps between a conifer's flat boughs open and close with the elevation of the eye, the parts shade
one another, and an eye between a tree and the sun sees less of that shade than one that looks
toward the sun. Tables that ``scenes.sticks.appearance`` fits correct it: which share of their area
(``lod.crossfade``) shapes show, and which multiple of their albedo they have. Area is
the same from below as from above; light from below is taken for that from the side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals
from scenes.sticks.view_angles import AZIMUTHS_DEG, ELEVATIONS_DEG

TONE_STEP = 0.95
"""Ratio of the albedo of each tone of a colour to that of the next lighter one."""

_SHAPE = len(ELEVATIONS_DEG), len(AZIMUTHS_DEG) + 1


@dataclass(frozen=True, eq=False)
class ViewDependence(ArrayData):
    """The tables of an object's leaf appearances, and which stick uses which; by default none does.

    table_row (k,)     row of the tables below for each stick of a leaf appearance, −1 for none
    area_share (c, h)  share of their area that sticks show at ELEVATIONS_DEG, 0 to 1
    tone (c, h, t + 1) multiple of their albedo at ELEVATIONS_DEG and AZIMUTHS_DEG; the last column
                       holds the mean over all azimuths
    """

    table_row: IntArray = field(default_factory=lambda: np.zeros(0))
    area_share: FloatArray = field(default_factory=lambda: np.zeros((0, _SHAPE[0])))
    tone: FloatArray = field(default_factory=lambda: np.zeros((0, *_SHAPE)))

    @staticmethod
    def of_area(table_row: Ints, area_share: np.ndarray) -> "ViewDependence":
        """Make the view dependence of shapes whose albedo is the same from everywhere."""
        return ViewDependence(table_row, area_share, np.ones((len(area_share), *_SHAPE)))

    @staticmethod
    def concatenate(parts: Sequence["ViewDependence"], sticks: Sequence[int]) -> "ViewDependence":
        """Lay the tables of several stick tables, of so many ``sticks`` each, end to end."""
        first = np.cumsum([0] + [len(each.area_share) for each in parts])[:-1]
        rows = [each.rows(count) for each, count in zip(parts, sticks, strict=True)]
        moved = [np.where(row >= 0, row + f, -1) for row, f in zip(rows, first, strict=True)]
        tables = (np.concatenate([getattr(p, n) for p in parts]) for n in ("area_share", "tone"))
        return ViewDependence(np.concatenate(moved), *tables)

    def rows(self, sticks: int) -> Ints:
        """``table_row`` of a table of so many sticks, (sticks,), also where no stick uses one."""
        return self.table_row if len(self.table_row) else np.full(sticks, -1)

    @cached_property
    def brightest(self) -> Reals:
        """Return the greatest multiple of their albedo that sticks of each table have, (c,)."""
        return self.tone.max(axis=(1, 2), initial=0.0)

    @cached_property
    def tone_steps(self) -> Float64[np.ndarray, "c h t"]:
        """Return how many steps of TONE_STEP sticks darken by from their brightest tone."""
        return np.log(self.tone / self.brightest[:, None, None]) / math.log(TONE_STEP)
