"""Slopes and albedo of the ground at points, as smooth as the mesh and the picture ask for.

Albedo has no patches smaller than the spacing of the mesh, and patches fade in as a finer level
does. Normals keep waves down to a few pixels, however coarse the mesh, so that a coarse mesh looks
nearly as rough as the finest.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.pruning.view import View
from lod.pruning.view_geometry import distance
from scenes.terrain.aggregate_cover import AggregateCover
from scenes.terrain.colour import GroundMaterials, ground_colours
from scenes.terrain.relief import Relief

GRASS_WAVE_M = 8.0
"""Shortest waves of the slope that decide what grows: plants cover smaller bumps [m]."""

SHOWN_PX = 4.0
"""Length of the shortest waves that normals hold in full [px].

A pixel's box leaves 0.90 of them; of waves half as long it leaves 0.64, which vertices some pixels
apart would put in wrong places.
"""

LEAST_FACING, LEVEL_FACING = 0.05, 1e-4
"""Smallest cosines between a normal and the direction to the eye.

Normals are bent up to the first, so that faces between such normals are turned to the eye as well;
but no further than the ground without its bumps faces the eye, down to the second, or plains would
tilt where they are seen at a grazing angle.
"""

Shading = Float64[np.ndarray, "n 7"]
"""Per point: two slopes without small bumps, two slopes with those that show, and the albedo."""


@dataclass(frozen=True, eq=False)
class GroundInView:
    """What the looks of the ground in one frame depend on.

    spacings, limit (l,)  of each level: spacing of the mesh, and limit distance in view [m]
    materials, aggregate_cover  materials of the ground, and what undisplayed objects leave on it
    """

    view: View
    relief: Relief
    spacings: Reals
    limit: Reals
    materials: GroundMaterials
    aggregate_cover: AggregateCover | None


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
    """Slopes and albedo of the bare ground at points of the relief (n, 3)."""
    view, relief = ground.view, ground.relief
    d, corner = distance(view, points), view.camera.corner
    xy = np.ascontiguousarray(points[:, :2])
    spacing = spacing_at(ground, d)
    shortest = np.maximum(2 * spacing, GRASS_WAVE_M), SHOWN_PX * view.camera.pixel_angle * d
    steep = relief.slopes(corner, xy, np.column_stack(shortest))
    rise, slope = points[:, 2] / (relief.amplitude or 1.0), np.hypot(steep[:, 0], steep[:, 1])
    albedo = ground_colours(relief.seed, corner, xy, rise, slope, spacing, ground.materials)
    return np.concatenate((steep, albedo), axis=1)


@njit(cache=True, nogil=True)
def bend_toward_eye(normals: np.ndarray, smooth: np.ndarray, to_eye: np.ndarray) -> np.ndarray:
    """Unit normals (n, 3), bent where they turn away from the eye.

    Ground that is seen faces the eye, but its bumps may be smaller than the mesh shows; shaded by
    the side of one that the eye cannot see, it would be black.

    smooth, to_eye (n, 3)  normals of the ground without its bumps, and the way to the eye [m]
    """
    bent = normals.copy()
    for i in range(len(normals)):
        away, facing, level = 0.0, 0.0, 0.0
        for k in range(3):
            away += to_eye[i, k] ** 2
            facing += normals[i, k] * to_eye[i, k]
            level += smooth[i, k] * to_eye[i, k]
        away = math.sqrt(away)
        if away < 1e-6:
            continue
        facing, level = facing / away, abs(level) / away
        least = min(max(level, LEVEL_FACING), LEAST_FACING)
        if facing < least:
            share = math.sqrt((1 - least**2) / max(1 - facing**2, 1e-12))
            for k in range(3):
                way = to_eye[i, k] / away
                bent[i, k] = least * way + share * (normals[i, k] - facing * way)
    return bent
