"""Slopes and albedo of the ground at points, as smooth as the mesh and the picture ask for.

Normals hold the waves that the mesh can show, those of two spacings and more, and albedo the
patches of one spacing and more; a finer level adds the next of them as it fades in. Shorter ones
would be put in wrong places by vertices too far apart for them. Of what is left out the mean stays
(``scenes.terrain.hidden_relief``, ``scenes.terrain.colour``).
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lod.arrays import Ints, Points, Reals
from lod.view import View, distance
from scenes.terrain.aggregate_cover import AggregateCover
from scenes.terrain.colour import GroundMaterials, ground_colours
from scenes.terrain.hidden_relief import seen_slopes
from scenes.terrain.relief import Relief

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
    to_sun   unit vector to the sun (3,); None: no sun
    """

    view: View
    relief: Relief
    spacings: Reals
    limit: Reals
    materials: GroundMaterials
    aggregate_cover: AggregateCover | None
    to_sun: np.ndarray | None


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
    hidden = relief.left_out_slope_variance(shown)
    growing = relief.left_out_slope_variance(grown)
    growing = np.maximum(growing - relief.left_out_slope_variance(np.array([GRASS_WAVE_M])), 0.0)
    share = growing / np.maximum(hidden, 1e-12)
    seen, vague = seen_slopes(steep[:, 2:], hidden, share, view.camera.eye - points)
    seen += steep[:, :2] - steep[:, 2:]
    rise, slope = points[:, 2] / (relief.amplitude or 1.0), np.hypot(seen[:, 0], seen[:, 1])
    albedo = ground_colours(relief.seed, corner, xy, rise, slope, vague, spacing, ground.materials)
    return np.concatenate((steep, hidden[:, None], albedo), axis=1)
