"""Slopes, albedo and mean light of the ground at points, as smooth as mesh and picture ask for.

``docs/ground.md`` says what becomes of relief, patches and light that are too small to be drawn. Of
a rough Lambertian surface the mean of the normals that the eye sees, which is shorter than 1, is
the normal and the factor on the albedo here; where facets turn away from the sun or lie in each
other's shadow, the normal is tilted from the sun until it receives as much as they do (Olano &
Baker 2010, "LEAN mapping"; Dupuy et al. 2013, "Linear efficient antialiased displacement and
reflectance mapping"; Smith 1967, "Geometrical shadowing of a random rough surface"; Heitz 2014,
"Understanding the masking-shadowing function in microfacet-based BRDFs").

Albedo has patches of every size from moist to dry, rock where steep, and snow. It is a function of
the place alone. Patches and slopes too small to be drawn count as normally distributed, and a
smooth step that is blurred by a normal distribution is about a smooth step again, whose variance is
the sum of both. Albedo is linear Rec.709, chosen by eye.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.camera import Corner
from lod.kernels import njit
from lod.view import View, distance
from scenes.appearance.sky import GRASS
from scenes.ground.relief import Relief
from scenes.noise import Octaves, left_out_variance, octaves_at, twin_values, unit_rms


@runtime_checkable
class ResidualCover(Protocol):
    """Cover that undisplayed objects leave at n points of the ground, as the eye sees it."""

    @property
    def lift(self) -> Reals:
        """Height by which the cover raises the ground, (n,) [m]."""

    @property
    def covered(self) -> Reals:
        """Share of the ground that the cover hides from the eye, (n,)."""

    def colours(self, normals: Points, bare: Points) -> Points:
        """Albedo of the covered ground, (n, 3).

        normals, bare (n, 3)  of the ground without its small bumps, and its own albedo
        """


@runtime_checkable
class AggregateCover(Protocol):
    """Species whose undisplayed objects leave their cover, colour and height on the ground."""

    @property
    def highest(self) -> float:
        """Largest height by which the cover can raise the ground [m]."""

    def residual(
        self, view: View, points: Points, slopes: Float64[np.ndarray, "n 2"] | None = None
    ) -> ResidualCover:
        """What the species leave at points (n, 3) of the ground of these slopes (n, 2) in a view.

        Without slopes it is level.
        """


_SMOOTH = 1e-6  # variance of slopes below which ground counts as smooth
_LEAST_UP = 0.05  # least upward component of a normal: a height field has no overhangs

_LEAST_FACING = 0.05
"""Least cosine to the eye of a normal that is tilted from the sun, if it had as much before."""

_ROOT_2PI = math.sqrt(2 * math.pi)


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
def seen_slopes(slopes, variance, share, to_eye):  # type: ignore[no-untyped-def]
    """Mean of the slopes that the eye sees, (n, 2), and their mean variance on an axis, (n,).

    slopes (n, 2), variance (n,)  of the ground that is drawn, and on each axis of those left out
    share (n,)   part of the variance whose slopes are asked for; the others are left out
    to_eye (n, 3)  way to the eye [m]
    """
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
def seen_facets(slopes, variance, to_eye, sun):  # type: ignore[no-untyped-def]
    """Unit normals (n, 3) of rough ground, and factors on its light, (n,).

    slopes (n, 2), variance (n,)  of the ground that is drawn, and on each axis of those left out
    to_eye (n, 3)  way to the eye [m]
    sun            unit vector to the sun (3,); 0: no facet counts as unlit
    """
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


@dataclass(frozen=True)
class GroundMaterials:
    """Materials of the ground, and where each of them lies.

    moist, dry, steep   albedo in hollows, on ridges, and where it is too steep for either
    steep_from, steep_to   tangents of the slope between which that sets in
    snow_line   height above which snow lies, in units of the relief's RMS; None = nowhere
    """

    moist: tuple[float, float, float]
    dry: tuple[float, float, float]
    steep: tuple[float, float, float]
    steep_from: float
    steep_to: float
    snow_line: float | None = None


GROUND_MATERIALS = {
    "grassy": GroundMaterials(*GRASS, (0.150, 0.112, 0.072), 0.45, 0.85),
    "trodden": GroundMaterials(
        (0.074, 0.107, 0.034), (0.185, 0.166, 0.082), (0.180, 0.139, 0.090), -0.02, 0.10
    ),
    "bare": GroundMaterials(
        (0.150, 0.118, 0.085), (0.260, 0.225, 0.175), (0.200, 0.190, 0.178), 0.35, 0.75
    ),
    "snowy": GroundMaterials(
        (0.060, 0.098, 0.030), (0.140, 0.135, 0.070), (0.155, 0.147, 0.138), 0.40, 0.80, -0.1
    ),
}
"""Grass and earth; short dry turf, worn down to earth in patches, for here the bare ground of steep
places begins on the level; gravel and rock; alpine grass and rock under snow."""

SNOW = (0.80, 0.83, 0.87)
_SNOW_EDGE = 0.5  # range of heights over which snow thins out, in units of the relief's RMS

_SNOW_FROM, _SNOW_TO = 0.75, 1.15
"""Tangents of the slopes on which snow begins to slide, and on which none stays."""

_SIDES = 2.0 ** np.arange(10, -5, -1)  # sizes of patches, from 1024 m to 0.0625 m across

_FALL = 0.92
"""Ratio of the RMS of octaves of patches to that of patches twice as large, as in vegetation."""

_LEVEL = 1e-6  # half the variance of slopes below which none count as hidden

_PATCHES = 0x50415443485459
"""Word by which the patches' random numbers differ from others of the same seed."""


def ground_colours(
    seed: int,
    corner: Corner,
    xy: Float64[np.ndarray, "n 2"],
    rise: Reals,
    slope: Reals,
    hidden: Reals,
    shortest: Reals,
    materials: GroundMaterials,
) -> Points:
    """Mean albedo of the ground about ``xy``, (n, 3); patches under ``shortest`` [m] are left out.

    rise    height in units of the relief's RMS: ridges are drier than hollows
    slope   tangent of the steepness: steep ground is drier, and the steepest bare
    hidden  variance on each axis of the slopes that ``slope`` is without
    """
    octaves = _octaves(seed ^ _PATCHES, corner)
    noise = twin_values(octaves, xy, shortest)
    vague = left_out_variance(shortest, octaves.side, (octaves.weight * unit_rms()) ** 2)
    snow_line = math.inf if materials.snow_line is None else materials.snow_line
    albedos = np.array((materials.moist, materials.dry, materials.steep, SNOW))
    edges = materials.steep_from, materials.steep_to, snow_line - _SNOW_EDGE / 2
    return np.asarray(_mean_colours(noise, vague, rise, slope, hidden, albedos, edges))


@njit(cache=True, nogil=True)
def _mean_colours(noise, vague, rise, slope, hidden, albedos, edges):  # type: ignore[no-untyped-def]
    """Mean albedo (n, 3) over hidden slopes: five steepnesses, each with half their variance.

    vague  variance of dryness and of brightness that the noise (n, 2) is without
    The steepnesses are those of Stroud's seven points (of degree 5 for the normal distribution).
    """
    colours = np.zeros((len(rise), 3))
    for i in range(len(rise)):
        half, patch = hidden[i] / 2, (noise[i, 0], noise[i, 1], vague[i])
        if half < _LEVEL:
            _add_colour(colours[i], 1.0, patch, rise[i], slope[i], half, albedos, edges)
            continue
        aside, s = math.sqrt(half), slope[i]
        for k in range(5):
            if k == 0:
                share, steep = 1 / 2, s
            elif k < 3:
                share, steep = 1 / 12, abs(s + (2.0 if k == 1 else -2.0) * aside)
            else:
                along = s + (1.0 if k == 3 else -1.0) * aside
                share, steep = 1 / 6, math.sqrt(along * along + 3.0 * half)
            _add_colour(colours[i], share, patch, rise[i], steep, half, albedos, edges)
    return colours


@njit(cache=True)
def _add_colour(colour, share, patch, rise, slope, hidden, albedos, edges):  # type: ignore[no-untyped-def]
    """Add ``share`` of the mean albedo (3,) of a patch at a rise and a slope.

    patch    its dryness and brightness, and the variance that both are without
    hidden   variance on each axis of the slopes about this one
    albedos  (4, 3) of moist, dry and steep ground, and of snow
    edges    tangents between which steep ground sets in; height above which snow does
    """
    dryness, shade, vague = patch
    # Mean and variance of the length of a slope in two dimensions (Rice), to first order.
    if hidden > 0.0:
        square = slope * slope
        slope = math.sqrt(square + hidden * (square + math.pi / 2 * hidden) / (square + hidden))
        hidden = square + 2.0 * hidden - slope * slope
    dry = _step(-1.9, 2.3, dryness + 0.35 * rise + 1.2 * slope, vague + 1.44 * hidden)
    bare = _step(edges[0], edges[1], slope + 0.06 * shade, 0.0036 * vague + hidden)
    snow = _step(edges[2], edges[2] + _SNOW_EDGE, rise + 0.2 * dryness, 0.04 * vague)
    if snow > 0.0:
        slid = _step(_SNOW_FROM, _SNOW_TO, slope + 0.1 * shade, 0.01 * vague + hidden)
        snow *= 1.0 - slid
    bright = math.exp(0.16 * shade + 0.0128 * vague)
    for k in range(3):
        ground = albedos[0, k] + (albedos[1, k] - albedos[0, k]) * dry
        ground = (ground + (albedos[2, k] - ground) * bare) * bright
        colour[k] += share * min(max(ground + (albedos[3, k] - ground) * snow, 0.0), 1.0)


@njit(cache=True)
def _step(low: float, high: float, x: float, variance: float) -> float:
    """Smooth step from 0 below ``low`` to 1 above ``high``, blurred by a variance of ``x``."""
    if variance > 0.0 and math.isfinite(low):
        # The smooth step is the sum of a density with a variance of a 20th of its squared width.
        more = (math.sqrt((high - low) ** 2 + 20.0 * variance) - (high - low)) / 2
        low, high = low - more, high + more
    if not low < x:
        return 0.0
    t = min((x - low) / (high - low), 1.0)
    return t * t * (3.0 - 2.0 * t)


@lru_cache(maxsize=64)
def _octaves(seed: int, corner: Corner) -> Octaves:
    weights = _FALL ** np.arange(len(_SIDES))
    return octaves_at(corner, seed, _SIDES, weights / np.linalg.norm(weights) / unit_rms())


GRASS_WAVE_M = 8.0
"""Shortest waves of the slope that decide what grows: plants cover smaller bumps [m]."""

Shading = Float64[np.ndarray, "n 8"]
"""Per point: two slopes without small bumps, two with those that show, variance on each axis of the
slopes that do not, and the albedo."""


@dataclass(frozen=True, eq=False)
class GroundInView:
    """What the looks of the ground in one frame depend on.

    spacings, limit (l,)  of each level: spacing of the mesh, and limit distance in view [m]
    materials, aggregate_cover  materials of the ground, and what undisplayed objects leave on it
    to_sun   unit vector to the sun (3,); 0: no sun
    """

    view: View
    relief: Relief
    spacings: Reals
    limit: Reals
    materials: GroundMaterials
    aggregate_cover: AggregateCover | None
    to_sun: np.ndarray


def morph_fraction(ground: GroundInView, d: Reals, level: Ints) -> Reals:
    """Fraction of the way from the coarser surface to the relief that vertices have moved, (n,).

    d, level (n,)  distance of each vertex [m], and the level whose tiles add it
    """
    limit, fade = ground.limit[level], ground.view.fade
    fraction, near = np.ones(len(d)), np.flatnonzero(np.isfinite(limit) & (limit > 0))
    if fade and len(near):
        limit = limit[near]
        fraction[near] = np.clip((limit - d[near]) / (fade * limit), 0.0, 1.0)
    return fraction


def spacing_at(ground: GroundInView, d: Reals) -> Reals:
    """Spacing of the tiles in view at distances d, smooth over each band of fading, (n,) [m]."""
    level = np.searchsorted(-ground.limit, -d) - 1
    halved = np.where(level > 0, morph_fraction(ground, d, level), 0.0)
    return np.asarray(ground.spacings[np.maximum(level - 1, 0)] * 0.5**halved)


def bare_shading(ground: GroundInView, points: Points) -> Shading:
    """Slopes, hidden slopes and albedo of the bare ground at points of the relief (n, 3)."""
    view, relief = ground.view, ground.relief
    d, corner = distance(view, points), view.camera.corner
    xy = np.ascontiguousarray(points[:, :2])
    spacing = spacing_at(ground, d)
    shown = 2 * spacing
    grown = np.maximum(shown, GRASS_WAVE_M)
    steep = relief.slopes(corner, xy, np.column_stack((grown, shown)))
    finest = np.ascontiguousarray(steep[:, 2:])
    hidden = relief.left_out_slope_variance(shown)
    growing = relief.left_out_slope_variance(grown)
    growing = np.maximum(growing - relief.left_out_slope_variance(np.array([GRASS_WAVE_M])), 0.0)
    share = growing / np.maximum(hidden, 1e-12)
    seen, vague = seen_slopes(finest, hidden, share, view.camera.eye - points)
    seen += steep[:, :2] - finest
    rise, slope = points[:, 2] / (relief.amplitude or 1.0), np.hypot(seen[:, 0], seen[:, 1])
    albedo = ground_colours(relief.seed, corner, xy, rise, slope, vague, spacing, ground.materials)
    return np.concatenate((steep, hidden[:, None], albedo), axis=1)
