"""Stochastic simplification: a few larger shapes in the place of many hidden sticks.

After R. Cook, J. Halstead, M. Planck & D. Ryu, "Stochastic simplification of aggregate detail",
SIGGRAPH 2007: of many like elements few are kept, enlarged so that they cover the same area. Here
the few are drawn evenly: what is hidden is halved by area again and again along its longest extent
(a k-d tree), and each group becomes one stick along its longest spread, as thick as it must be.
They stay apart, so that the crown keeps its gaps. A flat spray, as a conifer's boughs are, is
halved across its width: sticks are round, and only several side by side cover much from above and
little from the side.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.shapes import StickTable
from scenes.sticks.outline_area import directions, mean_area, mean_outline_areas
from scenes.sticks.union_area import COARSE

FITTING_DIRECTIONS = 16

_FULLEST = 2.236
"""√5: half an axis of an even ellipsoid, as a share of its standard deviation along it."""

FLAT = 2.0
"""The square of a flat spray's width over its length times its thickness: more in a plate, 1 in a
ball, less in a rod."""

BLOBS_PER_DECADE = 1.2
"""Blobs for each tenfold of the sticks that they stand for."""

_STEP = 0.7
"""Power of the missing area by which radii grow: converges for thin sticks and for round blobs."""


@dataclass(frozen=True, eq=False)
class Blobs:
    """Sticks that stand for groups of hidden sticks, by their middles.

    part (g,)       part that owns each blob
    centre (g, 3)   its middle [m]; axis (g, 3): unit vector along it
    reach (g,)      half the length of the group along the axis; radius (g,): of it across [m]
    """

    part: np.ndarray
    centre: np.ndarray
    axis: np.ndarray
    reach: np.ndarray
    radius: np.ndarray

    def table(self, parts: int, factor: Reals, tint: np.ndarray | None = None) -> StickTable:
        """Return the blobs as sticks of ``parts`` parts, as long over all as their groups are.

        Their radii are multiplied by the factor of their part (n,).
        """
        radius = self.radius * factor[self.part]
        half = np.maximum(self.reach - radius, 0.25 * radius)[:, None] * self.axis
        # One end plumper than the other, as a bough of leaves is.
        radii = 1.1 * radius, 0.85 * radius
        tint = np.zeros(len(self.part), np.int64) if tint is None else tint
        return StickTable.of(parts, self.part, self.centre - half, self.centre + half, *radii, tint)


def blob_counts(hidden: Ints) -> Ints:
    """Choose how many blobs stand for so many hidden sticks, (n,): a few more for each tenfold."""
    counts: Ints = np.ceil(BLOBS_PER_DECADE * np.log10(np.maximum(hidden, 2))).astype(np.int64)
    return counts


def cluster(hidden: StickTable, max_blobs: Ints) -> tuple[Blobs, Int64[np.ndarray, " k"]]:
    """Gather the hidden sticks of each part into at most ``max_blobs`` (n,) blobs.

    Returns the blobs, and the blob of each stick, (k,).
    """
    weight = mean_outline_areas(hidden)
    group, part = _stratify(hidden.first, _split_points(hidden, weight), weight, max_blobs)
    centre, axes, extent = _ellipsoids(hidden, weight, group, len(part))
    radius = np.sqrt(extent[:, 0] * extent[:, 1])
    return Blobs(part, centre, axes[:, :, 2], extent[:, 2], radius), group


def _split_points(hidden: StickTable, weight: Reals) -> Points:
    """Find the points (k, 3) along which the sticks of each part are split into groups [m].

    They are their middles, or of a flat spray how far those are aside.
    """
    owner, middle = hidden.owner, (hidden.start + hidden.end) / 2
    centre, axes, extent = _ellipsoids(hidden, weight, owner, len(hidden.first) - 1)
    flat = extent[:, 1] ** 2 > FLAT * extent[:, 0] * extent[:, 2]
    aside = np.zeros_like(middle)
    aside[:, 0] = ((middle - centre[owner]) * axes[owner, :, 1]).sum(axis=1)
    return np.where(flat[owner][:, None], aside, middle)


def _ellipsoids(
    hidden: StickTable, weight: Reals, group: Ints, groups: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Fit ellipsoids of even density to groups of sticks, by their covariance.

    Returns their centres (g, 3) [m], axes as columns (g, 3, 3), the longest last, and half their
    lengths (g, 3) [m].
    """
    points = np.concatenate((hidden.start, hidden.end))
    of, weights = np.concatenate((group, group)), np.concatenate((weight, weight))
    total = np.bincount(of, weights, groups)
    centre = _grouped_sums(of, points * weights[:, None], groups) / total[:, None]
    offset = points - centre[of]
    products = (offset[:, :, None] * offset[:, None, :]).reshape(-1, 9) * weights[:, None]
    spread = _grouped_sums(of, products, groups).reshape(-1, 3, 3) / total[:, None, None]
    values, axes = np.linalg.eigh(spread)
    return centre, axes, _FULLEST * np.sqrt(np.maximum(values, 1e-8))


def fit_radii(blobs: Blobs, wood: StickTable, target: Reals, rounds: int = 6) -> Reals:
    """Fit the factor (n,) on the radii of each part's blobs.

    They and the part's own wood then cover the target area (n,) [m²] on average over directions.
    """
    factor = np.full(len(target), 0.7)
    bare = fitting_area(wood)
    for _ in range(rounds):
        covered = fitting_area(StickTable.merge((wood, blobs.table(len(target), factor))))
        factor *= radius_step(target - bare, covered - bare)
    return factor


def radius_step(target: Reals, covered: Reals) -> Reals:
    """Compute a factor on radii for the covered area to come nearer to the target, (n,)."""
    return np.clip(target / np.maximum(covered, 1e-12), 0.1, 4.0) ** _STEP


def fitting_area(table: StickTable) -> Reals:
    """Measure the mean area over directions that each part covers, in coarse rows, (n,) [m²]."""
    return mean_area(table, directions(FITTING_DIRECTIONS), COARSE)


def error_diffusion(
    weight: Reals,
    wanted: Points,
    palette: Float64[np.ndarray, "t 3"],
    allowed: Int64[np.ndarray, " a"],
) -> Ints:
    """Choose a tint of the palette for each blob, so that their weighted mean is as wanted.

    Error diffusion from blob to blob (after Floyd & Steinberg 1976).
    """
    return allowed[_diffuse_error(weight, wanted, palette[allowed])]


def _grouped_sums(group: Ints, values: np.ndarray, groups: int) -> np.ndarray:
    columns = [np.bincount(group, values[:, k], groups) for k in range(values.shape[1])]
    return np.stack(columns, axis=1)


@njit(cache=True)
def _stratify(first, centre, weight, max_blobs):  # type: ignore[no-untyped-def]
    """Halve the heaviest group of each part until it has ``max_blobs`` (n,) groups.

    Returns the group of each stick, and the part of each group.
    """
    group = np.empty(len(centre), np.int64)
    part = np.empty(max_blobs.sum(), np.int64)
    order = np.arange(len(centre))
    groups = 0
    low, high, heavy = (
        np.empty(max_blobs.max(), np.int64),
        np.empty(max_blobs.max(), np.int64),
        np.empty(max_blobs.max()),
    )
    for i in range(len(first) - 1):
        low[0], high[0], n = first[i], first[i + 1], 1
        heavy[0] = weight[first[i] : first[i + 1]].sum()
        while n < max_blobs[i]:
            widest = np.argmax(heavy[:n])
            a, b = low[widest], high[widest]
            if b - a < 2:
                break
            _sort_along_longest(order, centre, a, b)
            middle, half = a, 0.0
            while middle < b - 1 and (middle == a or half < heavy[widest] / 2):
                half += weight[order[middle]]
                middle += 1
            heavy[n], heavy[widest] = heavy[widest] - half, half
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
def _diffuse_error(weight, wanted, palette):  # type: ignore[no-untyped-def]
    chosen = np.empty(len(weight), np.int64)
    owed = np.zeros(3)
    least = 0.1 * weight.mean()  # what is hardly seen cannot make up for the rest
    for g in range(len(weight)):
        best, smallest = 0, np.inf
        for t in range(len(palette)):
            error = 0.0
            for k in range(3):
                error += (wanted[g, k] + owed[k] / max(weight[g], least) - palette[t, k]) ** 2
            if error < smallest:
                best, smallest = t, error
        chosen[g] = best
        for k in range(3):
            owed[k] += weight[g] * (wanted[g, k] - palette[best, k])
    return chosen
