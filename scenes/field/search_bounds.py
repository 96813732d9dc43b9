"""Bounds of where objects of a field can be displayed at all, and which cells lie within them."""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Reals
from lod.pruning.compiled_test import sphere_in_frustum
from lod.pruning.view import View
from lod.pruning.view_geometry import search_radius


class SearchBounds(NamedTuple):
    """Where wholes of a species can pass their tests, whatever else is known of them.

    limit, limit_offscreen  (v,) greatest true distance of the eye from the origin of a whole of
            each prototype, in view and out of it [m]; bound (v,) its B [m]
    radius  greatest such distance in view of any prototype [m]
    max_offset  how far in plan that origin can be from the object's place in its cell [m]
    low, high   heights that it cannot be beyond [m]
    half_window half the side of the world; inf = no edge [m]
    """

    limit: np.ndarray
    limit_offscreen: np.ndarray
    bound: np.ndarray
    radius: float
    max_offset: float
    low: float
    high: float
    half_window: float


def search_bounds(
    view: View,
    limits: tuple[Reals, Reals],
    bound: Reals,
    max_offset: float,
    heights: tuple[float, float],
    extent: float | None,
) -> SearchBounds:
    """Find the bounds of a search for wholes with these limit distances and bounds.

    limits  (v,) D of each prototype's whole, in view and out of it [m]; bound (v,) its B [m]
    heights that the origin of a whole cannot be beyond [m]; extent: side of the world, None = no
            edge
    """
    inside, outside = limits
    pairs = zip(inside.tolist(), bound.tolist(), strict=True)
    limit = np.array([search_radius(view, each, radius) for each, radius in pairs])
    radius = search_radius(view, float(inside.max()), float(bound.max()))
    half_window = math.inf if extent is None else extent / 2
    return SearchBounds(limit, outside, bound, radius, max_offset, *heights, half_window)


class CellReach(NamedTuple):
    """Which cells may hold a displayed whole: all lengths in metres.

    horizontal  greatest distance of a cell from the eye, in plan
    limit, limit_offscreen  greatest true distances of a whole, in view and out of it
    max_offset  how far in plan the origin of a whole can be from its place in the cell
    height_gap  how far the eye is above all origins, or below them
    mid_height, radius  middle of the heights of all that a cell holds, and radius about it
    """

    horizontal: float
    limit: float
    limit_offscreen: float
    max_offset: float
    height_gap: float
    mid_height: float
    radius: float


def cell_reach(view: View, bounds: SearchBounds, side: float) -> CellReach:
    """Compute the reach of a search among square cells of that side [m]."""
    low, high, eye_z = bounds.low, bounds.high, view.camera.eye[2]
    gap = max(0.0, eye_z - high, low - eye_z)
    horizontal = math.sqrt(max(bounds.radius**2 - gap**2, 0.0)) + bounds.max_offset
    bound, outside = float(bounds.bound.max()), float(bounds.limit_offscreen.max())
    radius = side / math.sqrt(2) + (high - low) / 2 + bounds.max_offset + bound
    lengths = horizontal, bounds.radius, outside, bounds.max_offset, gap
    return CellReach(*lengths, (low + high) / 2, radius)


@njit(cache=True)
def cell_in_reach(view, east, north, side, reach):  # type: ignore[no-untyped-def]
    """Tell whether the cell about that middle may hold a displayed whole, in view or out of it."""
    near = horizontal_distance(view, east, north, side)
    if near > reach.horizontal:
        return False
    if view.look_around:
        return True
    away = min_distance(near, reach.max_offset, reach.height_gap)
    if away > reach.limit:
        return False
    if not away > reach.limit_offscreen:
        return True
    return sphere_in_frustum(view, east, north, reach.mid_height, reach.radius)


@njit(cache=True)
def horizontal_distance(view, east, north, side):  # type: ignore[no-untyped-def]
    """Compute the distance in plan from the eye to the cell about that middle [m]; 0 inside it."""
    aside_x = max(abs(east - view.eye_x) - side / 2, 0.0)
    aside_y = max(abs(north - view.eye_y) - side / 2, 0.0)
    return math.sqrt(aside_x * aside_x + aside_y * aside_y)


@njit(cache=True, inline="always")
def min_distance(horizontal, max_offset, height_gap):  # type: ignore[no-untyped-def]
    """Least true distance from the eye of anything that may be ``max_offset`` nearer in plan than
    ``horizontal``, and is at least ``height_gap`` higher or lower [m].
    """
    nearer = max(horizontal - max_offset, 0.0)
    return math.sqrt(nearer * nearer + height_gap * height_gap)
