"""Tables by direction of view: the tabulated angles, and how a table is looked up between them.

The elevation is that of the eye above the horizon, as a part sees it. The azimuth is the angle on
the map between the eye and the sun, as a part sees them: at 0° the sun stands behind the eye.
"""

import math

from numba import njit

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
