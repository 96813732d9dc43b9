"""Light in a layer of scattering air, in closed form along each line of sight (--haze scattered).

The layer is the air of the reference, a medium in the scene: it reaches from the ground to the top
of the medium's box, or several scale heights above the base of mist. lod.plane_parallel solves for
its light over flat ground, on which the field's species are a turbid medium. Along a line of sight
the light is that of the same height above the ground of the displayed meshes, whose profile about
the eye is known by azimuth and distance; the equation of transfer is summed from step to step,
exact where the source is a line in optical depth between them. The solution gives three things: the
airlight in every direction up to every distance; the sky as it appears from the eye; and the light
that reaches the ground, the sun's and that of layer and sky together. Two things are neglected:
where each object stands (its shade is that of the mean stand), and that hills shade and light the
air beside them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.air import Air, optical_depth
from lod.arrays import Reals, freeze
from lod.canopy import Canopy
from lod.plane_parallel import (
    LOWEST_SUN,
    RINGS,
    SPOKES,
    Scattering,
    SlabInputs,
    directions,
    mean_path_fraction,
    source_function,
)
from scenes.render.description import ALBEDO, ASYMMETRY, Description, extent
from scenes.render.light import (
    azimuth,
    interpolate,
    row_sine,
    row_upper,
    sky_radiance,
    sun_irradiance,
    variant_bands,
)

DISTANCES_M = np.concatenate(([0.0], np.geomspace(5.0, 4e4, 24)))
"""Horizontal distances from the eye at which a profile has heights [m]."""

Profile = Float64[np.ndarray, "spokes distances"]
"""Heights [m], at SPOKES azimuths clockwise from north and at DISTANCES_M."""


def ground_profile(points: np.ndarray, eye: np.ndarray) -> Profile:
    """Average the heights of points (n, 3) about an eye (3,), interpolated where there are none."""
    away = points[:, :2] - eye[:2]
    spoke = np.rint(np.arctan2(away[:, 0], away[:, 1]) / (2 * np.pi) * SPOKES).astype(np.int64)
    middles = np.sqrt(DISTANCES_M[1:-1] * DISTANCES_M[2:])
    step = 1 + np.searchsorted(middles, np.hypot(away[:, 0], away[:, 1]))
    count = len(DISTANCES_M)
    place = spoke % SPOKES * count + step
    held = np.bincount(place, minlength=SPOKES * count).reshape(SPOKES, count)
    summed = np.bincount(place, points[:, 2], minlength=SPOKES * count).reshape(SPOKES, count)
    nearest = points[np.argmin((away**2).sum(axis=1)), 2]
    held[:, 0], summed[:, 0] = 1, nearest
    every = np.arange(count)
    rows = [
        np.interp(every, np.flatnonzero(n), s[n > 0] / n[n > 0])
        for n, s in zip(held, summed, strict=True)
    ]
    return np.array(rows)


def heights_at(profile: Profile, distance: np.ndarray) -> Float64[np.ndarray, "n spokes"]:
    """Interpolate the ground's height [m] at horizontal distances (n,) [m], in every azimuth."""
    known = np.log1p(DISTANCES_M)
    place = np.interp(np.log1p(distance), known, np.arange(len(known)))
    nearer = np.minimum(place.astype(np.int64), len(known) - 2)
    share = (place - nearer)[:, None]
    return profile[:, nearer].T * (1 - share) + profile[:, nearer + 1].T * share


Light = Float64[np.ndarray, "rows spokes bands"]

_THIN = 1e-9


@dataclass(frozen=True, eq=False)
class Sources:
    """Source function J of the air over level ground, at a few heights.

    ground  (k,) increasing, heights of the ground [m]
    height  (k, levels) above it, from 0 up [m]
    source  (k, levels, RINGS, SPOKES, bands)
    """

    ground: np.ndarray
    height: np.ndarray
    source: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, ground=np.float64, height=np.float64, source=np.float64)


class Lines(NamedTuple):
    """Lines of sight from a height [m], in every azimuth, that rise by ``up`` (rows,) a metre.

    ``ground`` gives the ground's height at horizontal distances, (rows,) → (rows, spokes) [m].
    """

    start_m: float
    up: np.ndarray
    ground: Callable[[np.ndarray], np.ndarray]


class Gathered(NamedTuple):
    """The light that the air has added by the end of each step along lines of sight.

    light   (steps, rows, spokes, bands) radiance that the air has added
    source  (steps, rows, spokes, bands) the radiance that an endless path of such air would add:
            light / (1 − exp(−depth))
    depth   (steps, rows, bands) optical depth
    """

    light: np.ndarray
    source: np.ndarray
    depth: np.ndarray


def gather(
    sources: Sources, lines: Lines, air: Air, wavelengths: np.ndarray, ends: np.ndarray
) -> Gathered:
    """Integrate the air's light along lines up to increasing distances (steps, rows) [m]."""
    spokes, bands = sources.source.shape[-2:]
    light, total = np.zeros((len(lines.up), spokes, bands)), np.zeros((len(lines.up), bands))
    start, before = np.zeros(len(lines.up)), _source_at(sources, lines, np.zeros(len(lines.up)))
    made = []
    for end in ends:
        heights = lines.start_m + lines.up * start, lines.start_m + lines.up * end
        depth = optical_depth(air, *heights, end - start, wavelengths)
        here = _source_at(sources, lines, end)
        share = mean_path_fraction(depth)[:, None]
        own = before * (1 - share) + here * share
        light = light + (np.exp(-total) * -np.expm1(-depth))[:, None] * own
        total, start, before = total + depth, end, here
        held = -np.expm1(-total)[:, None]
        made.append((light, np.where(held > _THIN, light / np.maximum(held, _THIN), own), total))
    return Gathered(*(np.stack(each) for each in zip(*made, strict=True)))


def _source_at(sources: Sources, lines: Lines, distance: Reals) -> Light:
    """Interpolate the source function J at distances (rows,) [m] along the lines."""
    ground = lines.ground(distance * np.sqrt(np.maximum(1 - lines.up**2, 0.0)))
    above = np.maximum((lines.start_m + lines.up * distance)[:, None] - ground, 0.0)
    row = np.clip(row_sine(RINGS, lines.up), 0, RINGS - 1)
    spoke = np.arange(sources.source.shape[-2])
    total = np.zeros((*ground.shape, sources.source.shape[-1]))
    at = np.interp(ground, sources.ground, np.arange(len(sources.ground)))
    for k in range(len(sources.ground)):
        weight = np.maximum(1 - np.abs(at - k), 0.0)
        level = np.interp(above, sources.height[k], np.arange(sources.height.shape[1]))
        for up, up_share in _neighbours(level, sources.height.shape[1]):
            for ring, ring_share in _neighbours(row, RINGS):
                share = weight * up_share * ring_share[:, None]
                total += share[..., None] * sources.source[k, up, ring[:, None], spoke]
    return total


def _neighbours(place: np.ndarray, count: int) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Find the two whole numbers about each place, below ``count``, and the share of each."""
    below = np.floor(place).astype(np.int64)
    share = place - below
    return (below, 1 - share), (np.minimum(below + 1, count - 1), share)


AIR = Scattering(ALBEDO, ASYMMETRY)

NEAR_M, RATIO, PLANES = 4.0, 1.35, 34
"""Airlight is tabulated for distances NEAR_M, NEAR_M·RATIO, …, in so many planes."""

_STEPS = 7
_MIST_SCALES = 4.0
_ROWS = 65
_SKY_ROWS, _SKY_COLUMNS = 96, 144
_SKY_SINES = np.clip(np.linspace(0, 1, _SKY_ROWS) ** 2, 1e-5, 1.0)
"""Sines of elevation of the rows of the table of the sky, the lowest just above the horizon."""

_GROUNDS = (2.0, 50.0, 98.0)
"""Percentiles of the ground's height for which the layer is solved; between them the light is
taken to change evenly."""

_FLAT_M = 1.0
"""Ground that varies by less counts as flat."""


@dataclass(frozen=True, eq=False)
class ScatteringLayer:
    """Light that a layer of air scatters and lets through, in tables by direction.

    airlight_table   (planes, rows, columns, bands) airlight of paths that begin at the eye, as
                     ``Haze.airlight_table``
    sky_from_eye     (rows, columns, bands) radiance of the sky and of the layer above the horizon,
                     as they appear from the eye; rows by light.row_upper
    sky_from_ground  (rows, columns, bands) the radiance as it appears from the mean ground
    sun_to_ground    (bands,) share of the sun's light that reaches the mean ground
    sun_to_eye       (bands,) share of the sun's light that reaches the eye
    """

    airlight_table: np.ndarray
    sky_from_eye: np.ndarray
    sky_from_ground: np.ndarray
    sun_to_ground: np.ndarray
    sun_to_eye: np.ndarray


def with_scattering_layer(description: Description, air: Air) -> Description:
    """Light a description through the air: add a ScatteringLayer to its light.

    The frame is not built yet; the variant is the one that is set.
    """
    light, place = description["light"], description["camera"]["eye"]
    profile, mean, top = _reach(description, air)
    eye = float(place[2])
    # The layer is solved over level ground, at a few of the heights that the profile has.
    heights = np.percentile(profile, _GROUNDS)
    if np.ptp(heights) < _FLAT_M:
        heights = heights[1:2]
    slabs = [_slab_inputs(description, air, float(ground), top) for ground in np.unique(heights)]
    above = np.stack([each.height - each.height[0] for each in slabs])
    found = np.stack([source_function(each, AIR) for each in slabs])
    sources = Sources(np.unique(heights), above, found)
    around = partial(heights_at, profile)
    flat = partial(heights_at, np.full_like(profile, mean))
    root = np.linspace(-1, 1, _ROWS)
    ends = np.repeat(NEAR_M * RATIO ** np.arange(PLANES)[:, None], _ROWS, axis=1)
    lines = Lines(eye, np.sign(root) * root**2, around)
    sky = sky_radiance(light, _sky_directions().reshape(-1, 3))
    sky = sky.reshape(_SKY_ROWS, _SKY_COLUMNS, -1)
    layer = ScatteringLayer(
        airlight_table=gather(sources, lines, air, variant_bands().wavelengths, ends).source,
        sky_from_eye=_sky_through_layer(sky, sources, Lines(eye, _SKY_SINES, around), air, top),
        sky_from_ground=_sky_through_layer(sky, sources, Lines(mean, _SKY_SINES, flat), air, top),
        sun_to_ground=_sun_left(light["to_sun"], air, mean, top),
        sun_to_eye=_sun_left(light["to_sun"], air, eye, top),
    )
    return {**description, "light": {**light, "scattering_layer": layer}}


def _reach(description: Description, air: Air) -> tuple[Profile, float, float]:
    """Measure the profile of the ground, its mean height, and the height of the layer's top [m].

    The eye stands above the mean and below the top.
    """
    eye, (bottom, top, _) = description["camera"]["eye"], extent(description)
    meshes = [s for s in description["shapes"].values() if s["type"] == "mesh" and "glow" not in s]
    points = np.concatenate([s["vertices"] for s in meshes] or [[[*eye[:2], bottom]]])
    points = points.astype(np.float64)
    if air.mist is not None:
        top = max(top, air.mist.base_m + _MIST_SCALES * air.mist.scale_m)
    profile = ground_profile(points, eye)
    top = max(top, float(profile.max()) + description["light"]["canopy"].top_m + 1.0)
    return profile, min(float(points[:, 2].mean()), float(eye[2])), top


def _slab_inputs(description: Description, air: Air, ground: float, top: float) -> SlabInputs:
    """Describe the layer over flat ground at a height, for lod.plane_parallel."""
    light, way = description["light"], directions()[RINGS // 2 :]
    canopy: Canopy = light["canopy"]
    free = np.linspace(ground + canopy.top_m, top, _STEPS + 1)
    height = np.concatenate((ground + canopy.height, free[1:]))
    step = np.diff(height)
    meshes = [s["colours"] for s in description["shapes"].values() if s["type"] == "mesh"]
    return SlabInputs(
        height=height,
        depth=optical_depth(air, height[:-1], height[1:], step, variant_bands().wavelengths),
        cover=np.concatenate((canopy.depth, np.zeros(_STEPS))),
        to_sun=light["to_sun"],
        sun=sun_irradiance(light),
        sky=sky_radiance(light, way.reshape(-1, 3)).reshape(RINGS // 2, SPOKES, -1),
        ground=np.concatenate(meshes).mean(axis=0) if meshes else np.zeros(3),
        plants=canopy.albedo,
    )


def _sky_directions() -> np.ndarray:
    """Directions of the entries of the table of the sky, (rows, columns, 3)."""
    up = _SKY_SINES
    turn = np.arange(_SKY_COLUMNS) / _SKY_COLUMNS * 2 * np.pi
    horizontal = np.sqrt(1 - up**2)[:, None]
    z = np.broadcast_to(up[:, None], (_SKY_ROWS, _SKY_COLUMNS))
    return np.stack((horizontal * np.sin(turn), horizontal * np.cos(turn), z), axis=2)


def _sky_through_layer(
    sky: np.ndarray, sources: Sources, lines: Lines, air: Air, top_m: float
) -> np.ndarray:
    """Compute the sky as it appears from where lines begin, through the layer above."""
    whole = (top_m - lines.start_m) / lines.up
    steps = NEAR_M * RATIO ** np.arange(PLANES)[:, None]
    ends = np.concatenate((np.minimum(steps, whole), whole[None]))
    found = gather(sources, lines, air, variant_bands().wavelengths, ends)
    way = _sky_directions()
    own = interpolate(found.light[-1], row_upper(_SKY_ROWS, way[..., 2]), azimuth(way))
    return sky * np.exp(-found.depth[-1])[:, None] + own


def _sun_left(to_sun: np.ndarray, air: Air, at_m: float, top_m: float) -> np.ndarray:
    """Compute the share of the sun's light that comes down to a height, (bands,)."""
    length = (top_m - at_m) / max(float(to_sun[2]), LOWEST_SUN)
    ends = np.array([at_m]), np.array([top_m]), np.array([length])
    return np.exp(-optical_depth(air, *ends, variant_bands().wavelengths)[0])
