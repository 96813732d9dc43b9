"""View dependence of leaf appearances: their area and brightness by elevation and azimuth.

A few smooth shapes that stand for hidden parts cover and shine otherwise than those parts do: the
gaps between a conifer's flat boughs open and close with the elevation of the eye, and the shade
beneath them is seen from the side and not from above. The shapes' area and brightness are right on
average over elevations alone. A species can correct them by tables (measured by
``bench.calibrate.leaf_light``): by the elevation of the eye, which share of their area
(``lod.pruning.area_scaling``) and of their albedo is left, and by the azimuth between eye and sun,
which share of their albedo, for an eye between a tree and the sun sees less of the shade among its
leaves than one that looks toward the sun. Area is the same from below as from above; light from
below is taken for that from the side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, Ints
from scenes.sticks.view_angles import (
    AZIMUTHS_DEG,
    ELEVATIONS_DEG,
    elevation_index,
    interpolate,
)

TONE_STEP = 0.95
"""Ratio of the albedo of each tone of a colour to that of the next lighter one."""


@dataclass(frozen=True)
class ElevationTable:
    """Correction of the shapes of one level of detail at ELEVATIONS_DEG.

    area_share     share of their area that they show, 0 to 1; the greatest is 1
    albedo_factor  share of their albedo, 0 to 1; the greatest is 1
    """

    area_share: tuple[float, ...]
    albedo_factor: tuple[float, ...] = (1.0,) * len(ELEVATIONS_DEG)

    def area_share_at(self, sin_elevation: float) -> float:
        """Compute the share of their area that the shapes show at an elevation of the eye."""
        share: float = interpolate(np.array(self.area_share), elevation_index(sin_elevation))
        return share


CONSTANT = ElevationTable((1.0,) * len(ELEVATIONS_DEG))
"""The table of shapes that look the same from all elevations."""


@dataclass(frozen=True, eq=False)
class ViewDependence(ArrayData):
    """The tables of an object's leaf appearances, and which stick uses which; by default none does.

    table_row (k,)         row of the tables below for each stick of a leaf appearance, −1 for none
    area_share (c, h)      share of their area that sticks show at ELEVATIONS_DEG
    elevation_steps (c, h) steps of TONE_STEP that they darken by at ELEVATIONS_DEG
    azimuth_steps (c, t)   steps that they darken by besides at AZIMUTHS_DEG; the last column holds
                           the mean over all azimuths
    """

    table_row: IntArray = field(default_factory=lambda: np.zeros(0))
    area_share: FloatArray = field(default_factory=lambda: np.zeros((0, len(ELEVATIONS_DEG))))
    elevation_steps: FloatArray = field(default_factory=lambda: np.zeros((0, len(ELEVATIONS_DEG))))
    azimuth_steps: FloatArray = field(default_factory=lambda: np.zeros((0, len(AZIMUTHS_DEG) + 1)))

    @staticmethod
    def from_tables(
        table_row: Ints,
        elevation: Sequence[ElevationTable],
        azimuth_tone: Sequence[Sequence[float]] = (),
    ) -> "ViewDependence":
        """Make the view dependence from the tables of each level of detail.

        table_row     level of each stick, (k,), −1 for a stick that looks the same from everywhere
        azimuth_tone  albedo at AZIMUTHS_DEG over its mean, level by level; () where it is constant
        """
        names = ("area_share", "albedo_factor")
        share, tone = (np.array([getattr(each, name) for each in elevation]) for name in names)
        around = np.ones((len(share), len(AZIMUTHS_DEG) + 1))
        if azimuth_tone:
            around[:, :-1] = azimuth_tone
        around /= around.max(axis=1, keepdims=True)
        steps = (np.log(each) / math.log(TONE_STEP) for each in (tone, around))
        return ViewDependence(table_row, share, *steps)

    @staticmethod
    def concatenate(parts: Sequence["ViewDependence"], sticks: Sequence[int]) -> "ViewDependence":
        """Lay the tables of several stick tables, of so many ``sticks`` each, end to end."""
        first = np.cumsum([0] + [len(each.area_share) for each in parts])[:-1]
        rows = [each.rows(count) for each, count in zip(parts, sticks, strict=True)]
        moved = [np.where(row >= 0, row + f, -1) for row, f in zip(rows, first, strict=True)]
        names = ("area_share", "elevation_steps", "azimuth_steps")
        tables = (np.concatenate([getattr(each, name) for each in parts]) for name in names)
        return ViewDependence(np.concatenate(moved), *tables)

    def rows(self, sticks: int) -> Ints:
        """``table_row`` of a table of so many sticks, (sticks,), also where no stick uses one."""
        return self.table_row if len(self.table_row) else np.full(sticks, -1)
