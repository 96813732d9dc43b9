"""Areas that depend on the direction of view: sticks scaled to a share of their area, and the
largest area that a part covers when the share of its sticks changes with the elevation."""

import numpy as np
from numba import njit

from lod.arrays import Ints, Reals
from lod.crossfade import radius_factor
from lod.shapes import StickTable
from scenes.sticks.outline_area import directions, largest_area
from scenes.sticks.union_area import areas_of_parts
from scenes.sticks.view_angles import elevation_index, interpolate
from scenes.sticks.view_dependence import ViewDependence


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
