"""How much does what a frame displays vary, where objects stand in clusters or keep apart? (§4.1)

``docs/method.md`` derives the variance of a frame's number N of parts from the pair correlation
g(r) of a stationary field (Campbell's theorem of second order: Illian, Penttinen, Stoyan & Stoyan,
"Statistical Analysis and Modelling of Spatial Point Patterns", 2008, §4.3). How N is distributed
does not follow from g. It is taken for a gamma variable, which cannot be negative, and is the
skewer the wider it is.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats
from scipy.spatial import cKDTree

from lod.arrays import Reals
from lod.kernels import njit
from lod.law import count_variance, expected_count

PairCorrelation = Callable[[Reals], Reals]
"""A function from distances [m], (n,), to g there, (n,)."""

_CLASSES, _STEPS = 96, 2000
"""Radii by which parts are classed for C(r), and steps of the integral over r."""


@dataclass(frozen=True)
class CountSpread:
    """Mean and variance of the number that a frame displays."""

    mean: float
    variance: float

    def quantile(self, share: float) -> float:
        """Return the number that this share of all frames does not pass, of a gamma variable."""
        shape = self.mean**2 / self.variance
        return float(stats.gamma.ppf(share, shape, scale=self.mean / shape))


def count_spread(K: float, areas: Sequence[np.ndarray], g: PairCorrelation) -> CountSpread:
    """Predict what frames of a stationary, isotropic field of density K [1/m²] display.

    areas  for each of the equally likely prototypes, the area of ground from which each of its
           parts is displayed [m²]: that of a disc about the eye
    """
    each = K / len(areas)
    mean = sum(expected_count(each, of) for of in areas)
    alone = sum(count_variance(each, of) for of in areas)
    radius = np.sqrt(np.concatenate(list(areas)) / np.pi)
    radius = radius[radius > 0]
    farthest = float(radius.max(initial=0.0))
    if not farthest:
        return CountSpread(mean, alone)
    # Parts of about one radius stand for one another: their number and their mean area are kept.
    rank = np.log(radius / radius.min()) / max(math.log(farthest / radius.min()), 1e-12)
    of_class = np.minimum((rank * _CLASSES).astype(np.int64), _CLASSES - 1)
    number = np.bincount(of_class, minlength=_CLASSES)
    squared = np.bincount(of_class, np.square(radius), _CLASSES) / np.maximum(number, 1)
    there = number > 0
    step = 2 * farthest / _STEPS
    r = (np.arange(_STEPS) + 0.5) * step
    shared = _shared(r, np.sqrt(squared[there]), number[there] / len(areas))
    together = K**2 * float(np.sum((g(r) - 1) * shared * 2 * np.pi * r) * step)
    return CountSpread(mean, alone + together)


@njit(cache=True)
def _shared(r, radius, weight):  # type: ignore[no-untyped-def]
    """Sum of the areas that discs r apart share, over all pairs of classes, for each r, (n,)."""
    found = np.zeros(len(r))
    for k in range(len(r)):
        for i in range(len(radius)):
            for j in range(i + 1):
                both = weight[i] * weight[j] * (1.0 if i == j else 2.0)
                found[k] += both * _lens(radius[i], radius[j], r[k])
    return found


@njit(cache=True)
def _lens(a, b, d):  # type: ignore[no-untyped-def]
    if d >= a + b:
        return 0.0
    if d <= abs(a - b):
        return math.pi * min(a, b) ** 2
    x = (d * d + a * a - b * b) / (2 * d)  # of the chord, from the middle of the first
    half = math.sqrt(max(a * a - x * x, 0.0))
    return a * a * math.atan2(half, x) + b * b * math.atan2(half, d - x) - d * half


def poisson(r: Reals) -> Reals:
    """Return g of a Poisson field, which is 1 everywhere."""
    return np.ones_like(r)


def thomas(r: Reals, parents: float, sigma: float) -> Reals:
    """Return g of a Thomas field: Gaussian clusters of deviation ``sigma`` [m] on either axis.

    parents  clusters on a unit of ground [1/m²], whose middles are Poisson (Illian et al. §6.3.2)
    """
    return 1 + np.exp(-np.square(r / (2 * sigma))) / (4 * np.pi * parents * sigma**2)


def matern(r: Reals, candidates: float, core: float) -> Reals:
    """Return g of Matérn's second hard-core field, in which no two are nearer than ``core`` [m].

    candidates  density of the Poisson field that it is thinned from [1/m²]: of any two that are
                too near the later goes, even where it is gone already (Illian et al. §6.5.2)
    """
    disc = np.pi * core**2
    kept = -math.expm1(-candidates * disc)
    lens = np.array([_lens(core, core, float(each)) for each in r])
    union = 2 * disc - lens
    pairs = 2 * union * kept + 2 * disc * np.expm1(-candidates * union)
    found = pairs / (disc * union * np.maximum(union - disc, 1e-300)) / (kept / disc) ** 2
    return np.where(r < core, 0.0, found)


def mapped(
    xy: np.ndarray, period: tuple[float, float], farthest: float, step: float = 0.5
) -> PairCorrelation:
    """Count g of a map of points (n, 2) [m] that is repeated with these periods [m].

    Pairs are counted in rings ``step`` [m] wide, ``farthest`` [m] at most; copies of one point are
    pairs, too. A map is one sample: what it says of a kind of forest has no error that is known.
    """
    edges = np.arange(0.0, farthest + 2 * step, step)
    reach = [math.ceil(edges[-1] / side) for side in period]
    copies = [
        xy + np.array((i, j)) * period
        for i in range(-reach[0], reach[0] + 1)
        for j in range(-reach[1], reach[1] + 1)
    ]
    # A point that is its own neighbour is nearer than the least of the edges that is asked for.
    own = np.concatenate(([step * 1e-6], edges[1:]))
    pairs = np.diff(cKDTree(xy).count_neighbors(cKDTree(np.concatenate(copies)), own))
    density = len(xy) / (period[0] * period[1])
    found = pairs / (len(xy) * density * np.pi * np.diff(np.square(edges)))
    middle = (edges[1:] + edges[:-1]) / 2
    return lambda r: np.interp(r, middle, found)
