"""Area of a stick's silhouette: of its outline, seen from far off along a direction [m²].

A stick is the convex hull of two spheres, radii r₀ and r₁, a distance L apart. Along a direction
at an angle φ to its axis it looks like the convex hull of two discs whose centres are l = L·sin φ
apart. Where neither disc holds the other, both outer tangents touch, and with sin a = (r₀ − r₁)/l
the outline is two sectors of π ± 2a and, between each tangent and the axis, a trapezoid of height
l·cos a:

    A(l) = r₀²·(π/2 + a) + r₁²·(π/2 − a) + (r₀ + r₁)·l·cos a,         else A = π·max(r₀, r₁)².

It grows with l, so it is largest across the axis, l = L. The stick is convex, so by Cauchy's
theorem (Cauchy 1832; Santaló, "Integral Geometry and Geometric Probability", 1976, ch. 13) its
mean over all directions is a quarter of its surface, two caps and a frustum with sin α = (r₀ −
r₁)/L:

    S = 2π·r₀²·(1 + sin α) + 2π·r₁²·(1 − sin α) + π·(r₀ + r₁)·L·cos²α.

Several sticks hide one another: the area of the union of their outlines is measured by
``scenes.sticks.union_area``.
"""

from collections.abc import Callable
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from lod.shapes import StickTable
from scenes.sticks.union_area import FINE, areas_of_parts, largest_of_parts

Directions = Float64[np.ndarray, "d 3"]

DIRECTIONS = 64
"""Directions over which composites are measured: about 10° apart from any other."""

SEARCHED = 48
"""Directions from the best of which the largest area is searched."""


@lru_cache(maxsize=16)
def directions(count: int = DIRECTIONS) -> Directions:
    """Spread unit vectors evenly over a half sphere: an outline has no front and back.

    A Fibonacci lattice (Swinbank & Purser, "Fibonacci grids", QJRMS 132, 2006), cut to z > 0.
    """
    k = np.arange(count) + 0.5
    z = k / count
    turn = 2 * np.pi * k * (np.sqrt(5) - 1) / 2
    level = np.sqrt(1 - z * z)
    spread = np.stack((level * np.cos(turn), level * np.sin(turn), z), axis=1)
    spread.setflags(write=False)
    return spread


def outline_area(r0: Reals, r1: Reals, apart: Reals) -> Reals:
    """A(l) of the formula above: the convex hull of two discs with centres ``apart`` [m²]."""
    difference = r0 - r1
    slim = np.abs(difference) < apart
    sine = np.where(slim, difference / np.where(slim, apart, 1.0), 0.0)
    a = np.arcsin(sine)
    caps = r0 * r0 * (np.pi / 2 + a) + r1 * r1 * (np.pi / 2 - a)
    hull = caps + (r0 + r1) * apart * np.sqrt(1 - sine * sine)
    return np.where(slim, hull, np.pi * np.maximum(r0, r1) ** 2)


def largest_outline_areas(table: StickTable) -> Reals:
    """Return each stick's largest outline over all directions, (k,) [m²]."""
    return outline_area(table.start_radius, table.end_radius, _lengths(table))


def mean_outline_areas(table: StickTable) -> Reals:
    """Return each stick's mean outline over all directions, S/4, (k,) [m²]."""
    r0, r1, length = table.start_radius, table.end_radius, _lengths(table)
    slim = np.abs(r0 - r1) < length
    sine = np.where(slim, (r0 - r1) / np.where(slim, length, 1.0), 0.0)
    caps = 2 * np.pi * (r0 * r0 * (1 + sine) + r1 * r1 * (1 - sine))
    frustum = np.pi * (r0 + r1) * length * (1 - sine * sine)
    return np.where(slim, caps + frustum, 4 * np.pi * np.maximum(r0, r1) ** 2) / 4


def largest_area(table: StickTable, spread: Directions | None = None) -> Reals:
    """Measure the largest area that each part's sticks cover together, (n,) [m²].

    It is 0 for a part without sticks, in closed form for a part of one stick, and else searched
    from the best of ``spread`` (SEARCHED).
    """
    spread = directions(SEARCHED) if spread is None else spread
    return _exact_where_single(
        table, lambda some: largest_of_parts(some, spread), largest_outline_areas
    )


def mean_area(table: StickTable, spread: Directions | None = None, fineness: float = FINE) -> Reals:
    """Measure the mean over directions of the area that each part's sticks cover, (n,) [m²]."""
    spread = directions() if spread is None else spread
    return _exact_where_single(
        table, lambda some: areas_of_parts(some, spread, fineness).mean(axis=1), mean_outline_areas
    )


def _exact_where_single(
    table: StickTable,
    measured: Callable[[StickTable], Reals],
    closed_form: Callable[[StickTable], Reals],
) -> Reals:
    """Areas of parts, (n,): of one stick in closed form, of several measured, else 0."""
    areas, count = np.zeros(len(table.count)), table.count
    single, several = np.flatnonzero(count == 1), np.flatnonzero(count > 1)
    areas[single] = closed_form(table)[table.first[single]]
    if len(several):
        areas[several] = measured(table.of_parts(count > 1))
    return areas


def _lengths(table: StickTable) -> Reals:
    axis = table.end - table.start
    return np.sqrt((axis * axis).sum(axis=1))
