"""What foliage looks like from further off: a few larger blobs that cover as much.

Stochastic simplification after R. Cook, J. Halstead, M. Planck & D. Ryu, "Stochastic
simplification of aggregate detail", SIGGRAPH 2007: of many like elements keep few, enlarged so
that the area they cover is kept. Here the few are drawn evenly: the leaves are halved again and
again along their longest extent (a k-d tree), and each group becomes one stick along its longest
spread. They stay apart, so that the crown keeps its gaps.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from numba import njit

from lod.arrays import Ints, Points, Reals
from scenes.stick_area import directions, mean_area
from scenes.stick_raster import COARSE
from scenes.stick_table import StickTable

FITTING_DIRECTIONS = 16

_FULLEST = 2.236
"""√5: half an axis of an even ellipsoid, as a share of its standard deviation along it."""


@dataclass(frozen=True, eq=False)
class Blobs:
    """Sticks by their middle: part (g,), centre and half-axis (g, 3), radius (g,) [m]."""

    part: np.ndarray
    centre: np.ndarray
    half: np.ndarray
    radius: np.ndarray

    def sticks(self, factor: Reals) -> tuple[np.ndarray, ...]:
        """Owner, start, end and both radii, each part's blobs enlarged by its factor (n,)."""
        f = factor[self.part]
        half, radius = self.half * f[:, None], self.radius * f
        # One end plumper than the other, as a bough of leaves is.
        return self.part, self.centre - half, self.centre + half, 1.1 * radius, 0.85 * radius


def gather(
    first: Int64[np.ndarray, " parts"], start: Points, end: Points, most: int
) -> tuple[Blobs, Ints]:
    """At most ``most`` blobs for each part's leaves, and the blob that each leaf falls to (k,).

    Leaves of part i are rows first[i]:first[i + 1].
    """
    group, part = _strata(first, (start + end) / 2, most)
    points, groups = np.concatenate((start, end)), np.concatenate((group, group))
    count = np.bincount(groups, minlength=len(part))
    centre = _sums(groups, points, len(part)) / count[:, None]
    offset = points - centre[groups]
    spread = _sums(groups, (offset[:, :, None] * offset[:, None, :]).reshape(-1, 9), len(part))
    values, axes = np.linalg.eigh(spread.reshape(-1, 3, 3) / count[:, None, None])
    extent = _FULLEST * np.sqrt(np.maximum(values, 1e-8))
    radius = np.sqrt(extent[:, 0] * extent[:, 1])
    half = np.maximum(extent[:, 2] - radius, 0.25 * radius)
    return Blobs(part, centre, axes[:, :, 2] * half[:, None], radius), group


def fitted(blobs: Blobs, wood: StickTable, target: Reals, rounds: int = 4) -> Reals:
    """Factor on each part's blobs so that they and its own wood cover the target on average (n,).

    A fixed-point step: what blobs cover beyond the wood grows about as the square of their size.
    """
    bare = fitting_area(wood)
    factor = np.full(len(target), 0.7)
    for _ in range(rounds):
        covered = fitting_area(joined(wood, blobs, factor))
        ratio = (target - bare) / np.maximum(covered - bare, 1e-12)
        factor *= np.sqrt(np.clip(ratio, 0.25, 4.0))
    return factor


def fitting_area(table: StickTable) -> Reals:
    """Mean area of each part, (n,) [m²], as blobs are fitted: few directions, coarse rows."""
    return mean_area(table, directions(FITTING_DIRECTIONS), COARSE)


def joined(
    wood: StickTable, blobs: Blobs, factor: Reals, tint: np.ndarray | None = None
) -> StickTable:
    """Wood and blobs of each part in one table; blobs have the given tints, or 0."""
    owner, *lengths = blobs.sticks(factor)
    tint = np.zeros(len(owner), np.int64) if tint is None else tint
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = [
        np.concatenate((getattr(wood, name), column))
        for name, column in zip(names, (*lengths, tint), strict=True)
    ]
    return StickTable.of(len(wood.first) - 1, np.concatenate((wood.owner, owner)), *columns)


def blended_tints(
    part: Ints,
    weight: Reals,
    wanted: Points,
    palette: Float64[np.ndarray, "t 3"],
    allowed: Int64[np.ndarray, " a"],
) -> Ints:
    """A tint of the palette for each blob, so that the weighted mean of a part's blobs is as
        wanted.

    Error diffusion from blob to blob of one part (after Floyd & Steinberg 1976).
    """
    return allowed[_diffuse(part, weight, wanted, palette[allowed])]


def _sums(group: Ints, values: np.ndarray, groups: int) -> np.ndarray:
    columns = [np.bincount(group, values[:, k], groups) for k in range(values.shape[1])]
    return np.stack(columns, axis=1)


@njit(cache=True)
def _strata(first, centre, most):  # type: ignore[no-untyped-def]
    """Group of each leaf, part of each group: the largest group is halved until ``most``."""
    group = np.empty(len(centre), np.int64)
    part = np.empty((len(first) - 1) * most, np.int64)
    order = np.arange(len(centre))
    groups = 0
    low, high = np.empty(most, np.int64), np.empty(most, np.int64)
    for i in range(len(first) - 1):
        low[0], high[0], n = first[i], first[i + 1], 1
        while n < most:
            widest = np.argmax(high[:n] - low[:n])
            a, b = low[widest], high[widest]
            if b - a < 2:
                break
            _sort_along_longest(order, centre, a, b)
            middle = (a + b) // 2
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
def _diffuse(part, weight, wanted, palette):  # type: ignore[no-untyped-def]
    chosen = np.empty(len(part), np.int64)
    owed = np.zeros(3)
    for g in range(len(part)):
        if g == 0 or part[g] != part[g - 1]:
            owed[:] = 0.0
        best, smallest = 0, np.inf
        for t in range(len(palette)):
            error = 0.0
            for k in range(3):
                error += (wanted[g, k] + owed[k] / weight[g] - palette[t, k]) ** 2
            if error < smallest:
                best, smallest = t, error
        chosen[g] = best
        for k in range(3):
            owed[k] += weight[g] * (wanted[g, k] - palette[best, k])
    return chosen
