"""What of an object depends on the direction of view: shares of area and tones, by tables.

A few smooth shapes that stand for hidden parts cover and shine otherwise than those parts do: the
gaps between a conifer's flat boughs open and close with the elevation of the eye, the parts shade
one another, and an eye between a tree and the sun sees less of that shade than one that looks
toward the sun. Tables that ``scenes.appearance`` fits correct it: which share of their area
(``lod.crossfade``) shapes show, and which multiple of their albedo they have. Area is the same from
below as from above; light from below is taken for that from the side.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals
from lod.crossfade import radius_factor
from lod.kernels import njit
from lod.shapes import StickTable
from scenes.sticks.areas import areas_of_parts, directions, largest_area

ELEVATIONS_DEG = tuple(range(0, 91, 15))
"""Elevations of the eye at which a table by elevation has its entries."""

AZIMUTHS_DEG = tuple(range(0, 181, 30))
"""Azimuths between eye and sun at which a table by azimuth has its entries."""


@njit(cache=True)
def elevation_index(sin_elevation):  # type: ignore[no-untyped-def]
    """Compute the fractional index of an elevation among ELEVATIONS_DEG, from its sine, 0 to 1."""
    return math.asin(min(sin_elevation, 1.0)) / math.radians(ELEVATIONS_DEG[1])


@njit(cache=True)
def azimuth_index(cos_azimuth):  # type: ignore[no-untyped-def]
    """Compute the fractional index of an azimuth among AZIMUTHS_DEG, from its cosine.

    It is −1 for NaN, which asks for the mean over all azimuths.
    """
    if math.isnan(cos_azimuth):
        return -1.0
    return math.acos(min(max(cos_azimuth, -1.0), 1.0)) / math.radians(AZIMUTHS_DEG[1])


@njit(cache=True)
def tone_steps_at(table, high, around):  # type: ignore[no-untyped-def]
    """Compute the entry of a table of ``ViewDependence.tone_steps``, (h, t + 1).

    ``high`` and ``around`` are what ``elevation_index`` and ``azimuth_index`` compute.
    """
    low = min(int(high), len(table) - 2)
    below, above = _around(table[low], around), _around(table[low + 1], around)
    return below + (high - low) * (above - below)


@njit(cache=True)
def _around(row, index):  # type: ignore[no-untyped-def]
    """Entry of a row of such a table: its last column holds the mean over all azimuths."""
    azimuths = len(row) - 1
    return interpolate(row[:azimuths], index) if index >= 0.0 else row[azimuths]


@njit(cache=True)
def interpolate(row, index):  # type: ignore[no-untyped-def]
    """Compute the entry of a row of a table at a fractional index: linear in the angle."""
    low = min(int(index), len(row) - 2)
    return row[low] + (index - low) * (row[low + 1] - row[low])


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


def with_area_share(table: StickTable, share: Reals | float) -> StickTable:
    """Thin sticks to a share of their area, one for each (k,) or one for all."""
    share = np.broadcast_to(share, len(table)).astype(np.float64)
    length = np.sqrt(((table.end - table.start) ** 2).sum(axis=1))
    return table.thickened(_radius_factors(table.start_radius, table.end_radius, length, share))


def area_shares_at(views: ViewDependence, rows: Ints, sin_elevation: float) -> Reals:
    """Compute which share of their area sticks show at an elevation of the eye, (k,).

    ``rows`` (k,) are as in ``ViewDependence.table_row``.
    """
    index = elevation_index(sin_elevation)
    shares: Reals = np.append([interpolate(row, index) for row in views.area_share], 1.0)[rows]
    return shares


def largest_area_in_view(table: StickTable, views: ViewDependence) -> Reals:
    """Measure the largest area that the sticks of each part cover over all directions, (n,) [m²].

    Each stick has the share of its area that it shows from there.
    """
    dependent, changing = np.zeros(len(table.count), np.bool_), (views.area_share != 1).any(axis=1)
    dependent[table.owner[np.append(changing, False)[views.rows(len(table))]]] = True
    if not dependent.any():
        return largest_area(table)
    largest = np.empty(len(dependent))
    largest[~dependent] = largest_area(table.of_parts(~dependent))
    some, rows = table.of_parts(dependent), views.rows(len(table))[dependent[table.owner]]
    areas = []
    for view in directions():
        shown = with_area_share(some, area_shares_at(views, rows, view[2]))
        areas.append(areas_of_parts(shown, view[None])[:, 0])
    largest[dependent] = np.max(areas, axis=0)
    return largest


@njit(cache=True)
def _radius_factors(r0, r1, length, share):  # type: ignore[no-untyped-def]
    factors = np.empty(len(r0))
    for k in range(len(r0)):
        factors[k] = radius_factor(r0[k], r1[k], length[k], share[k])
    return factors


def with_tone_steps(
    tint: Ints, tints: np.ndarray, views: ViewDependence
) -> tuple[Ints, Float64[np.ndarray, "t 3"]]:
    """Give sticks whose brightness depends on the view tints in a longer palette.

    Sticks have a row of a palette for a colour, and no brightness of their own. So each colour of a
    stick whose brightness depends on the view is followed by as many darker tones as it can need.
    Returns their tints (k,) and that palette: all tones of a stick, from the lightest to the
    darkest, follow the tint that it is given.
    """
    steps = np.ceil(views.tone_steps.max(axis=(1, 2), initial=0.0)).astype(np.int64)
    dependent = views.table_row >= 0
    pairs, pair = np.unique(
        np.stack((views.table_row[dependent], tint[dependent])), axis=1, return_inverse=True
    )
    blocks = [
        np.minimum(
            views.brightest[row] * tints[colour] * TONE_STEP ** np.arange(steps[row] + 1)[:, None],
            1.0,
        )
        for row, colour in pairs.T
    ]
    first = len(tints) + np.cumsum([0] + [len(block) for block in blocks])[:-1]
    toned = tint.copy()
    toned[dependent] = first[pair.reshape(-1)]
    return toned, np.concatenate((tints, *blocks))
