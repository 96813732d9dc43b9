"""The law of §4.1 on flat ground, with its prefactor, derived without the pruner.

Objects of density K [1/m²] stand isotropically on flat ground; the eye is h above a part's origin;
a part is displayed within its limit distance D. Through a full turn that is a disc of area π(D² −
h²).
"""

from collections.abc import Callable

import numpy as np

from lod.arrays import Ints, Reals
from lod.metric.family import Metric
from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from lod.vision.contrast import CONTRAST_CLASSES
from lod.vision.defocus import Defocus, defocus_width
from lod.vision.viewer import ViewingConditions
from lod.vision.weighted_distance import WeightedDistance

LIMITS: dict[str, Callable[[Reals, Reals, float], Reals]] = {
    "blake": lambda P, R, m: (P + R) / m,
    "bounded": lambda P, R, m: P / m + R,
    "solid_angle": lambda P, R, m: P / m,
    "full": lambda P, R, m: np.full(len(P), np.inf),
}
"""Limit distances in clear air of the built-in metrics that have a law, apart from those that the
pruner uses (``lod.metric.family``): a prediction must not rest on what it tests."""

_HALVINGS = 60
"""Bisections of an interval: enough for the last bits of a float64."""

_EXACT, _MOST_STEPS = 1e-14, 200
"""Relative error at which a distance is found, and steps that none ever took."""


def chained_limits(
    hierarchy: Hierarchy, metric: Metric, m: float, conditions: ViewingConditions | None = None
) -> np.ndarray:
    """Compute the limit distance of every part, (n,) [m], for the metrics that have a law.

    A part is displayed while its own test and those of every part above it pass, in whatever pose:
    D = max(0, min over ancestors j of (D_j − length of the chain of separations from j down)).
    Through air, lens and eye, D_j is the farthest d of which W(d) is within its limit in clear air.
    Raises KeyError for a metric that measures depth along the axis of view: it has no law.
    """
    alone = _own_limits(hierarchy, slice(None), metric, m, conditions)
    limit, chain, above = alone.copy(), np.zeros(len(alone)), np.arange(len(alone))
    while (above > 0).any():
        chain = chain + np.where(above > 0, hierarchy.separation[above], 0.0)
        above = np.where(above > 0, hierarchy.parent[above], 0)
        limit = np.minimum(limit, alone[above] - chain)
    return np.maximum(limit, 0.0)


def whole_limit(
    hierarchy: Hierarchy, metric: Metric, m: float, conditions: ViewingConditions | None = None
) -> float:
    """Compute the limit distance of the whole object [m]: the first of ``chained_limits``."""
    return max(0.0, float(_own_limits(hierarchy, slice(1), metric, m, conditions)[0]))


def _own_limits(
    hierarchy: Hierarchy,
    rows: slice,
    metric: Metric,
    m: float,
    conditions: ViewingConditions | None,
) -> Reals:
    """Distances to which the own tests of these parts pass, those of their wholes aside, (n,)."""
    if metric.along_axis:
        raise KeyError(metric.name)
    # A metric of another package is known by its own formula alone.
    formula = LIMITS.get(metric.name, metric.limit)
    clear = formula(hierarchy.P[rows], hierarchy.R[rows], m)
    if conditions is None or not metric.finite:
        return clear
    seen = _farthest_seen(clear, hierarchy.contrast[rows], conditions, m)
    if conditions.defocus is None:
        return seen
    theta = conditions.widths.effective
    return np.minimum(seen, _farthest_sharp(clear, conditions.defocus, theta))


def limits_seen(hierarchy: Hierarchy, view: View, m: float) -> np.ndarray:
    """Compute the limit distances of a view's parts at a detail angle m [rad], (n,) [m].

    Of two eyes what either can see is displayed: the distance from their middle is up to half a
    baseline greater.
    """
    limits = chained_limits(hierarchy, view.metric, m, view.conditions)
    limits[limits > 0] += view.camera.baseline_m / 2
    return limits


def _farthest_seen(clear: Reals, contrast: Ints, conditions: ViewingConditions, m: float) -> Reals:
    """Distance d at which W(d) reaches the limit in clear air, (n,) [m]."""
    seen = np.empty_like(clear)
    for row in np.unique(contrast):
        of_class = contrast == row
        seen[of_class] = _reached(conditions.weighted(CONTRAST_CLASSES[row], m), clear[of_class])
    return seen


def _reached(W: WeightedDistance, clear: Reals) -> Reals:
    """Greatest d with W(d) ≤ these limits, (n,) [m], by false position.

    It is the Illinois method (Dowell & Jarratt, "A modified regula falsi method for computing the
    root of an equation", BIT 11:168, 1971); W(d) ≥ d brackets every root.
    """
    found = np.minimum(clear, W.vanishing_distance)
    missed = W.weight(found) - clear
    rows = np.flatnonzero(missed > _EXACT * clear)
    near, far, below, above = np.zeros(len(rows)), found[rows], -clear[rows], missed[rows]
    for _ in range(_MOST_STEPS):
        if not len(rows):
            break
        at = far - above * (far - near) / (above - below)
        missed = W.weight(at) - clear[rows]
        found[rows] = at
        short = missed <= 0
        # The end that stays counts half from now on, so that the next step passes the root.
        below, above = np.where(short, missed, below / 2), np.where(short, above / 2, missed)
        near, far = np.where(short, at, near), np.where(short, far, at)
        open_ = np.abs(missed) > _EXACT * clear[rows]
        rows, near, far = rows[open_], near[open_], far[open_]
        below, above = below[open_], above[open_]
    return found


def _farthest_sharp(clear: Reals, defocus: Defocus, theta: float) -> Reals:
    """Distance up to which τ·θ_eff(d)·d stays within τ·θ·D_c, by bisection, (n,) [m].

    It begins where a part is sharpest for its distance; what is too small there is nowhere seen.
    """

    def blurred(d: Reals) -> Reals:
        return np.hypot(theta, defocus_width(defocus, d)) / theta * d

    start = max(defocus.sharpest_m(theta), 1e-9)
    near, far = np.full_like(clear, start), np.maximum(clear, start)
    never = blurred(near) >= clear
    for _ in range(_HALVINGS):
        middle = (near + far) / 2
        within = blurred(middle) <= clear
        near, far = np.where(within, middle, near), np.where(within, far, middle)
    return np.where(never, 0.0, far)


def disc_areas(D: np.ndarray, h: np.ndarray) -> np.ndarray:
    """Compute the area of ground from which a part is displayed, π·max(0, D² − h²), (n,) [m²]."""
    return np.pi * np.maximum(np.square(D) - np.square(h), 0.0)


def expected_count(K: float, areas: np.ndarray) -> float:
    """Compute the expected number of parts displayed, K·Σ areas; of objects, given wholes only."""
    return K * float(np.sum(areas))


def count_variance(K: float, areas: np.ndarray) -> float:
    """Compute the variance of the number displayed, K·ΣᵢΣⱼ min(areaᵢ, areaⱼ): compound Poisson.

    Parts of one object come together: the discs are concentric, so those of i and j overlap in the
    smaller one. With areas sorted downwards, ΣΣ min = Σ (2k + 1)·area_k, k = 0, 1, …
    """
    down = np.sort(np.asarray(areas, np.float64))[::-1]
    return K * float(np.sum((2 * np.arange(len(down)) + 1) * down))
