"""How much objects too small to display cover of the ground, by the gap fraction of a stand.

Objects stand at random (Poisson), K of them to the square metre, each of mean outline A(δ) along a
line that comes down at δ to the horizon. Of such lines exp(−K·A/sin δ) reach the ground: the gap
fraction of a random stand (Nilson 1971, "A theoretical analysis of the frequency of gaps in plant
stands", Agricultural Meteorology 8; of whole crowns Li & Strahler 1985, "Geometric-optical
modeling of a conifer forest canopy", IEEE Trans. Geoscience and Remote Sensing 23). The rest meets
objects, of each kind in proportion to its K·A.
"""

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals
from lod.kernels import njit

PerKind = Float64[np.ndarray, "n k"]
Colours = Float64[np.ndarray, "n 3"]
Kinds = Float64[np.ndarray, " k"]
Triple = Float64[np.ndarray, "3"]


def undisplayed_share(
    d: Reals, limits: Float64[np.ndarray, "#n p"], areas: Float64[np.ndarray, " p"], fade: float
) -> Reals:
    """Compute the share of the objects' cover that is not displayed at distance ``d`` (n,), (n,).

    Equally many have each of ``limits`` (n or 1, p), and outlines in proportion to ``areas``; over
    the band of fading it is what they no longer cover.
    """
    missing: Reals = _missing(d, np.minimum(limits, 1e30), areas / areas.sum(), fade)
    return missing


@njit(cache=True, nogil=True)
def _missing(d, limits, weight, fade):  # type: ignore[no-untyped-def]
    missing = np.empty(len(d))
    for i in range(len(d)):
        limit = limits[min(i, len(limits) - 1)]
        shown = 0.0
        for k in range(len(weight)):
            band = max(fade * limit[k], 1e-12)
            shown += weight[k] * min(max((limit[k] - d[i]) / band, 0.0), 1.0)
        missing[i] = max(1.0 - shown, 0.0)
    return missing


def cover_depths(missing: PerKind, density: Kinds, area: PerKind, sine: Reals) -> PerKind:
    """Compute K·A/sin δ, the mean number of objects of each kind (k,) on each line (n,)."""
    return missing * density * area / sine[:, None]


def covered_share(depths: PerKind) -> Reals:
    """Compute the share of lines that meet any object, 1 − exp(−Σ depth), (n,)."""
    return -np.expm1(-depths.sum(axis=1))


def first_hit_shares(depths: PerKind) -> PerKind:
    """Compute the share of each kind in first hits, (n, k), 0 where no line meets anything."""
    total = depths.sum(axis=1, keepdims=True)
    return np.divide(depths, total, out=np.zeros_like(depths), where=total > 0)


LEAST_LIGHT = 0.05
"""Share of the sun's light on level ground that no surface counts below, so that none asks for an
albedo without end."""


def surface_irradiance(
    normals: Float64[np.ndarray, "n 3"], to_sun: Triple, sky_share: Triple
) -> Colours:
    """Compute the irradiance of unshadowed surfaces relative to that of level ground, (n, 3)."""
    sun = np.maximum(normals @ to_sun / to_sun[2], LEAST_LIGHT)[:, None]
    sky = (1 + normals[:, 2:3]) / 2
    return (1 - sky_share) * sun + sky_share * sky
