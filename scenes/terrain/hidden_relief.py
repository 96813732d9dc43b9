"""Light of relief that is too small to be drawn: the mean over its facets that the eye sees.

Slopes of the relief that is left out count as normally distributed about those that are drawn, with
the variance of the octaves left out (Olano & Baker 2010, "LEAN mapping"; Dupuy et al. 2013, "Linear
efficient antialiased displacement and reflectance mapping"). The eye sees a facet by its area
across the line of sight, so that more is seen of those that face it, and none of those that turn
away (Smith 1967, "Geometrical shadowing of a random rough surface"; Heitz 2014, "Understanding the
masking-shadowing function in microfacet-based BRDFs"). A Lambertian surface sends light by the mean
of its normals, which is shorter than 1: that is the normal and the factor on the albedo here. Where
facets turn away from the sun or lie in each other's shadow, the normal is tilted from the sun until
it receives as much as they do. Light between facets is that of an even cavity.
"""

import math

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Points, Reals

_SMOOTH = 1e-6
"""Variance of slopes below which ground counts as smooth."""

_LEAST_UP = 0.05
"""Least upward component of a normal: a height field has no overhangs."""

_LEAST_FACING = 0.05
"""Least cosine to the eye of a normal that is tilted from the sun, if it had as much before."""

_ROOT_2PI = math.sqrt(2 * math.pi)


def seen_facets(
    slopes: Float64[np.ndarray, "n 2"], variance: Reals, to_eye: Points, to_sun: np.ndarray | None
) -> tuple[Points, Reals]:
    """Unit normals (n, 3) of rough ground, and factors on its light, (n,).

    slopes     of the ground that is drawn
    variance   of the slopes that are left out, on each axis
    to_eye     way to the eye [m]
    to_sun     unit vector to the sun (3,); None: no facet counts as unlit
    """
    sun = np.zeros(3) if to_sun is None else np.asarray(to_sun, np.float64)
    return _seen_facets(slopes, variance, to_eye, sun)


def seen_slopes(
    slopes: Float64[np.ndarray, "n 2"], variance: Reals, share: Reals, to_eye: Points
) -> tuple[Float64[np.ndarray, "n 2"], Reals]:
    """Mean of the slopes that the eye sees, (n, 2), and their mean variance on an axis, (n,).

    slopes, variance  of the ground that is drawn, and on each axis of those that are left out
    share             part of the variance whose slopes are asked for; the others are left out
    """
    return _seen_slopes(slopes, variance, share, to_eye)


def cavity_albedo(albedo: Points, share: Reals) -> Points:
    """Albedo of rough ground whose facets (n, 3) exchange light, by the share (n,) that escapes."""
    kept = share[:, None]
    return albedo * kept / (1.0 - albedo * (1.0 - kept))


@njit(cache=True, inline="always")
def _facing(z):  # type: ignore[no-untyped-def]
    """Mean of z − x for normal x below z, and its derivative over it."""
    if z < -6.0:
        mean = math.exp(-z * z / 2) / _ROOT_2PI / (z * z + 3.0)
        return mean, -z - 2.0 / z
    below = math.erfc(-z / math.sqrt(2.0)) / 2
    mean = math.exp(-z * z / 2) / _ROOT_2PI + z * below
    return mean, below / mean


@njit(cache=True, inline="always")
def _seen(sx, sy, sigma, x, y, z):  # type: ignore[no-untyped-def]
    """Way to the eye on the map, by how many sigmas slopes along it fall, their variance over that
    of all, and how many times as much ground faces the eye as is seen, less 1."""
    flat = math.hypot(x, y)
    if flat <= 1e-6 * abs(z):
        return 1.0, 0.0, 0.0, 1.0, 0.0
    ex, ey = x / flat, y / flat
    steepest = (z / flat - sx * ex - sy * ey) / sigma
    mean, ratio = _facing(steepest)
    spread = max(2.0 - steepest * ratio - ratio * ratio, 0.01)
    return ex, ey, ratio, spread, (mean / steepest - 1.0 if steepest > 1e-3 else 1e3)


@njit(cache=True, nogil=True)
def _seen_slopes(slopes, variance, share, to_eye):  # type: ignore[no-untyped-def]
    mean, spread = slopes.copy(), share * variance
    for i in range(len(slopes)):
        if variance[i] < _SMOOTH:
            continue
        x, y, z = to_eye[i]
        sigma = math.sqrt(variance[i])
        ex, ey, ratio, along, _ = _seen(slopes[i, 0], slopes[i, 1], sigma, x, y, z)
        mean[i, 0] -= share[i] * sigma * ratio * ex
        mean[i, 1] -= share[i] * sigma * ratio * ey
        spread[i] *= 1.0 + share[i] * (along - 1.0) / 2
    return mean, spread


@njit(cache=True, inline="always")
def _turned(nx, ny, nz, x, y, z, cosine):  # type: ignore[no-untyped-def]
    """A unit normal, turned towards a direction or from it until the cosine between them is so."""
    cosine, facing = min(cosine, 1.0), nx * x + ny * y + nz * z
    ax, ay, az = nx - facing * x, ny - facing * y, nz - facing * z
    aside = math.sqrt(ax * ax + ay * ay + az * az)
    if aside < 1e-6:
        return nx, ny, nz
    scale = math.sqrt(1.0 - cosine * cosine) / aside
    return cosine * x + scale * ax, cosine * y + scale * ay, cosine * z + scale * az


@njit(cache=True, nogil=True)
def _seen_facets(slopes, variance, to_eye, sun):  # type: ignore[no-untyped-def]
    normals, share = np.empty((len(slopes), 3)), np.ones(len(slopes))
    sun_flat = math.hypot(sun[0], sun[1])
    for i in range(len(slopes)):
        sx, sy = slopes[i, 0], slopes[i, 1]
        x, y, z = to_eye[i]
        if variance[i] < _SMOOTH and z > sx * x + sy * y:
            length = math.sqrt(sx * sx + sy * sy + 1.0)
            normals[i, 0], normals[i, 1], normals[i, 2] = -sx / length, -sy / length, 1.0 / length
            continue
        sigma = math.sqrt(max(variance[i], _SMOOTH))
        ex, ey, ratio, along, behind = _seen(sx, sy, sigma, x, y, z)
        sx, sy, along = sx - sigma * ratio * ex, sy - sigma * ratio * ey, sigma * math.sqrt(along)
        # Shadow of the sun on what is seen.
        lit = 1.0
        if sun_flat > 1e-6:
            fall = (slopes[i, 0] * sun[0] + slopes[i, 1] * sun[1]) / sun_flat
            steepest = (sun[2] / sun_flat - fall) / sigma
            before = _facing(steepest)[0] / steepest - 1.0 if steepest > 1e-3 else 1e3
            lit = (1.0 + behind) / (1.0 + behind + before)
        # Mean over seven facets (Stroud's rule of degree 5 for the normal distribution).
        nx, ny, nz, received = 0.0, 0.0, 0.0, 0.0
        for k in range(7):
            weight, a, b = 0.5, 0.0, 0.0
            if k:
                turn = math.pi / 3 * k
                weight, a, b = 1 / 12, 2 * math.cos(turn) * along, 2 * math.sin(turn) * sigma
            px, py = sx + a * ex - b * ey, sy + a * ey + b * ex
            weight /= math.sqrt(1.0 + px * px + py * py)
            nx, ny, nz = nx - weight * px, ny - weight * py, nz + weight
            received += weight * max(sun[2] - px * sun[0] - py * sun[1], 0.0)
        length = math.sqrt(nx * nx + ny * ny + nz * nz)
        nx, ny, nz = nx / length, ny / length, nz / length
        if sun[2] > 0.0 or sun_flat > 0.0:
            away = math.sqrt(x * x + y * y + z * z)
            least = min((nx * x + ny * y + nz * z) / away, _LEAST_FACING)
            nx, ny, nz = _turned(nx, ny, nz, sun[0], sun[1], sun[2], received * lit / length)
            if nx * x + ny * y + nz * z < least * away:
                nx, ny, nz = _turned(nx, ny, nz, x / away, y / away, z / away, least)
            if nz < _LEAST_UP:
                scale = math.sqrt((1 - _LEAST_UP**2) / (nx * nx + ny * ny))
                nx, ny, nz = nx * scale, ny * scale, _LEAST_UP
        normals[i, 0], normals[i, 1], normals[i, 2] = nx, ny, nz
        share[i] = length
    return normals, share
