"""The metric family: how far away a part of given P and R is still displayed (Blake 1987 §2.4).

Each member is a pure function, part by part, to a limit distance D [m]; a part is displayed while
its distance d < D. Its arguments are

    P  priority [m]: √ of the largest cross-section that the part can present as a leaf
    R  range [m]: how far its extremes, or its parts' ends, can be from its origin
    m  the detail angle [rad]

``Metric.along_axis`` says which distance d is, and ``Metric.by_contrast`` whether D is weighted by
contrast. The law's prediction has formulas of its own (``lod.law``); docs/extend.md says how to add
a metric.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from lod.arrays import frozen
from lod.errors import InputError
from lod.hierarchy import Hierarchy
from lod.viewing import MIN_EXTINCTION, ViewingConditions, perceptual_limits


def blake(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
    """P + R > m·d, as printed in §2.4; the K(P+R)² law follows from it."""
    return (P + R) / m


def bounded(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
    """P > m·(d − R): R read as a bound on position, so that the nearest extreme decides (§2.4)."""
    return P / m + R


def solid_angle(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
    """P > m·d: what the part itself subtends, without a bound (§2.1)."""
    return P / m + 0.0 * R  # of the shape that P and R have together


def full(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
    """No pruning: the unpruned reference, which needs a finite world."""
    return np.full(np.broadcast_shapes(np.shape(P), np.shape(R)), np.inf)


@dataclass(frozen=True)
class Metric:
    """A named member of the family.

    name, about  what ``lodbench list`` shows
    limit        its formula
    along_axis   d is the depth along the camera's axis, and parts out of view are dropped, which
                 the paper argues against (§2.1); otherwise d is the true distance from the eye
    finite       its limits are finite; otherwise it needs a world with an edge
    by_contrast  D is weighted by the contrast of what would be lost (``seen_by_contrast``)
    """

    name: str
    limit: Callable[[np.ndarray, np.ndarray, float], np.ndarray]
    about: str
    along_axis: bool = False
    finite: bool = True
    by_contrast: bool = False

    @property
    def finer(self) -> float:
        """Return the factor on τ at which it displays about as many parts as its formula does.

        By contrast it is the mean contrast of parts of trees to their wholes, by area.
        """
        return 0.25 if self.by_contrast else 1.0


@cache
def within_reach(metric: Metric, reach_m: float) -> Metric:
    """Return the metric by which nothing is displayed beyond a distance [m]."""

    def limit(P: np.ndarray, R: np.ndarray, m: float) -> np.ndarray:
        return np.minimum(metric.limit(P, R, m), reach_m)

    return replace(metric, limit=limit)


METRICS: dict[str, Metric] = {
    metric.name: metric
    for metric in (
        Metric("blake", blake, "P + R > m·d, as printed in §2.4 (default)"),
        Metric("bounded", bounded, "P > m·(d − R): the nearest extreme decides"),
        Metric("solid_angle", solid_angle, "P > m·d: no bound on position"),
        Metric(
            "depth", blake, "P + R > m·(depth along the view axis), in view only", along_axis=True
        ),
        Metric(
            "contrast_weighted",
            blake,
            "C·exp(−βd)·(P + R) > m·d: blake by the contrast C of what would be lost, and haze",
            by_contrast=True,
        ),
        Metric("full", full, "the unpruned reference; needs a finite world", finite=False),
    )
}


def seen_by_contrast(D: np.ndarray, contrast: np.ndarray | float, extinction: float) -> np.ndarray:
    """Compute the d at which contrast·exp(−βd)·D is d itself, of limit distances D (n,) [m].

    d·exp(βd) = C·D, so that βd is Lambert's W of β·C·D. ``contrast`` C is 0 to 1, ``extinction`` β
    [1/m]. docs/method.md ("Contrast in the priority") derives it.
    """
    if extinction < MIN_EXTINCTION:
        return contrast * D
    from scipy.special import lambertw  # expensive to import, and few metrics ask for it

    return np.asarray(lambertw(extinction * contrast * D).real / extinction)


MAX_CACHED = 128
"""Limit distances kept for each hierarchy: both sides of the view at every step of motion."""

_CACHE: WeakKeyDictionary[Hierarchy, dict[Any, np.ndarray]] = WeakKeyDictionary()
"""By hierarchy, oldest first; an entry goes with its hierarchy."""


def limit_distances(
    hierarchy: Hierarchy, metric: Metric, m: float, conditions: ViewingConditions | None = None
) -> np.ndarray:
    """Compute the D of every part, clamped once so that every cut is connected, (n,) [m].

    Through air and eye (``conditions``) a part's own D is first W⁻¹ of that in clear air, which may
    be weighted by contrast, W by its class of contrast; ``full`` keeps everything all the same, and
    along an axis it is the depth that W weighs. Then D_part = max(0, min(D_part, D_whole −
    separation)): a part within its D has, by the triangle inequality, its whole within the whole's
    D. 0 means never displayed. The last MAX_CACHED results are kept while the hierarchy lives.
    Raises InputError unless m is finite and above 0.
    """
    cached = _CACHE.setdefault(hierarchy, {})
    key = metric, m, conditions
    if key in cached:
        return cached[key]
    if not (np.isfinite(m) and m > 0):
        raise InputError("m", m, "the detail angle is finite and above 0 rad", "check the detail")
    D = np.array(metric.limit(hierarchy.P, hierarchy.R, m), np.float64)
    if metric.by_contrast:
        beta = conditions.extinction if conditions else 0.0
        D = seen_by_contrast(D, hierarchy.contrast_to_whole, beta)
    if conditions is not None and metric.finite:
        D = perceptual_limits(conditions, D, hierarchy.contrast, m)
    for depth in range(1, int(hierarchy.depth.max()) + 1):
        rows = np.flatnonzero(hierarchy.depth == depth)
        reach = D[hierarchy.parent[rows]] - hierarchy.separation[rows]
        D[rows] = np.maximum(0.0, np.minimum(D[rows], reach))
    if len(cached) >= MAX_CACHED:
        del cached[next(iter(cached))]
    cached[key] = frozen(D, np.float64)
    return cached[key]
