"""Light in a layer of scattering air, in closed form along each line of sight (--haze scattered).

The layer is the air of the reference, a medium in the scene: it reaches from the ground to the top
of the medium's box, or several scale heights above the base of mist. lod.plane_parallel
solves for its light over flat ground, on which the field's species are a turbid medium
(lod.canopy). Along a line of sight the light is that of the same height above the
ground of the displayed meshes. The solution gives three things: the airlight in every direction up
to every distance; the sky as it appears from the eye; and the light that reaches the ground, the
sun's and that of layer and sky together. Two things are neglected: where each object stands (its
shade is that of the mean stand), and that hills shade and light the air beside them.
"""

from dataclasses import dataclass
from functools import partial

import numpy as np

from lod.air import Air, optical_depth
from lod.canopy import Canopy
from lod.plane_parallel import (
    LOWEST_SUN,
    RINGS,
    SPOKES,
    Scattering,
    SlabInputs,
    directions,
    source_function,
)
from scenes.render.description.direction_table import azimuth, interpolate, row_upper
from scenes.render.description.medium_box import ALBEDO, ASYMMETRY, extent
from scenes.render.description.scene_description import Description
from scenes.render.haze.ground_profile import Profile, ground_points, ground_profile, heights_at
from scenes.render.haze.horizon_airlight import sky_radiance
from scenes.render.haze.sight_line_integral import Lines, Sources, gather
from scenes.render.mitsuba.emitters import sun_irradiance, variant_bands

AIR = Scattering(ALBEDO, ASYMMETRY)

NEAR_M, RATIO, PLANES = 4.0, 1.35, 34
"""Airlight is tabulated for distances NEAR_M, NEAR_M·RATIO, …, in so many planes."""

_STEPS = 7
_MIST_SCALES = 4.0
_ROWS = 65
_SKY_ROWS, _SKY_COLUMNS = 96, 144

_GROUNDS = (2.0, 50.0, 98.0)
"""Percentiles of the ground's height for which the layer is solved; between them the light is
taken to change evenly."""

_FLAT_M = 1.0
"""Ground that varies by less counts as flat."""


@dataclass(frozen=True, eq=False)
class ScatteringLayer:
    """Light that a layer of air scatters and lets through, in tables by direction.

    airlight_table   (planes, rows, columns, bands) airlight of paths that begin at the eye; rows by
                     direction_table.row_sqrt_sine
    sky_from_eye     (rows, columns, bands) radiance of the sky and of the layer above the horizon,
                     as they appear from the eye; rows by direction_table.row_upper
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
    """Light a description through the air: add a ScatteringLayer to its light."""
    layer = make_scattering_layer(description, air)
    return {**description, "light": {**description["light"], "scattering_layer": layer}}


def make_scattering_layer(description: Description, air: Air) -> ScatteringLayer:
    """Solve the layer of a frame that is not built yet, in the variant that is set."""
    light, place = description["light"], description["camera"]["eye"]
    profile, mean, top = _reach(description, air)
    eye = float(place[2])
    sources = _sources(description, air, profile, top)
    around = partial(heights_at, profile)
    flat = partial(heights_at, np.full_like(profile, mean))
    root = np.linspace(-1, 1, _ROWS)
    ends = np.repeat(NEAR_M * RATIO ** np.arange(PLANES)[:, None], _ROWS, axis=1)
    lines = Lines(eye, np.sign(root) * root**2, around)
    sky = sky_radiance(light, _sky_directions().reshape(-1, 3))
    sky = sky.reshape(_SKY_ROWS, _SKY_COLUMNS, -1)
    return ScatteringLayer(
        airlight_table=gather(sources, lines, air, variant_bands().wavelengths, ends).source,
        sky_from_eye=_sky_through_layer(sky, sources, Lines(eye, _sky_sines(), around), air, top),
        sky_from_ground=_sky_through_layer(sky, sources, Lines(mean, _sky_sines(), flat), air, top),
        sun_to_ground=_sun_left(light["to_sun"], air, mean, top),
        sun_to_eye=_sun_left(light["to_sun"], air, eye, top),
    )


def _reach(description: Description, air: Air) -> tuple[Profile, float, float]:
    """Measure the profile of the ground, its mean height, and the height of the layer's top [m].

    The eye stands above the mean and below the top.
    """
    eye, (bottom, top, _) = description["camera"]["eye"], extent(description)
    points = ground_points(description)
    if points is None:
        points = np.array([[*eye[:2], bottom]])
    if air.mist is not None:
        top = max(top, air.mist.base_m + _MIST_SCALES * air.mist.scale_m)
    profile = ground_profile(points, eye)
    top = max(top, float(profile.max()) + description["light"]["canopy"].top_m + 1.0)
    return profile, min(float(points[:, 2].mean()), float(eye[2])), top


def _sources(description: Description, air: Air, profile: Profile, top: float) -> Sources:
    """Solve the layer over level ground, at a few of the heights that the profile has."""
    heights = np.percentile(profile, _GROUNDS)
    if np.ptp(heights) < _FLAT_M:
        heights = heights[1:2]
    slabs = [_slab_inputs(description, air, float(ground), top) for ground in np.unique(heights)]
    above = np.stack([each.height - each.height[0] for each in slabs])
    return Sources(
        np.unique(heights), above, np.stack([source_function(each, AIR) for each in slabs])
    )


def _slab_inputs(description: Description, air: Air, ground: float, top: float) -> SlabInputs:
    """Describe the layer over flat ground at a height, for lod.plane_parallel."""
    light, way = description["light"], directions()[RINGS // 2 :]
    canopy: Canopy = light["canopy"]
    free = np.linspace(ground + canopy.top_m, top, _STEPS + 1)
    height = np.concatenate((ground + canopy.height, free[1:]))
    step = np.diff(height)
    return SlabInputs(
        height=height,
        depth=optical_depth(air, height[:-1], height[1:], step, variant_bands().wavelengths),
        cover=np.concatenate((canopy.depth, np.zeros(_STEPS))),
        to_sun=light["to_sun"],
        sun=sun_irradiance(light),
        sky=sky_radiance(light, way.reshape(-1, 3)).reshape(RINGS // 2, SPOKES, -1),
        ground=_ground_albedo(description),
        plants=canopy.albedo,
    )


def _ground_albedo(description: Description) -> np.ndarray:
    """Mean colour of the vertices of all meshes, (3,); black where there is none."""
    meshes = [s["colours"] for s in description["shapes"].values() if s["type"] == "mesh"]
    return np.concatenate(meshes).mean(axis=0) if meshes else np.zeros(3)


def _sky_sines() -> np.ndarray:
    """Sines of elevation of the rows of the table of the sky, the lowest just above the horizon."""
    return np.clip(np.linspace(0, 1, _SKY_ROWS) ** 2, 1e-5, 1.0)


def _sky_directions() -> np.ndarray:
    """Directions of the entries of the table of the sky, (rows, columns, 3)."""
    up = _sky_sines()
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
