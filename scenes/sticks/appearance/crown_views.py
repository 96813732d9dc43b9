"""Views of a whole object from far off, in full detail, that its leaf appearances are held against.

They are spread over elevations and azimuths. An outline is the same from the other side, so that
views from above stand for those from below.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.threads import map_chunks
from scenes.sticks.shapes import Shapes
from scenes.sticks.view_angles import ELEVATIONS_DEG
from scenes.sticks.visible_area import visible_areas

AZIMUTHS = 8
"""Views from each of ELEVATIONS_DEG, turned from one elevation to the next."""

RAYS = 200
"""Rays across the object's largest extent."""

_TURN_DEG = 38.2


@dataclass(frozen=True, eq=False)
class CrownViews:
    """An object in full detail, seen from all sides.

    toward (e, a, 3)  unit vectors to the eye, for each elevation
    weight (e,)       share of all directions that each elevation stands for
    spacing           of the rays [m]
    covers (e,)       area that the object covers from each elevation, over azimuths [m²]
    seen (k,)         area that is seen of each of its shapes, over all directions [m²]
    """

    toward: Float64[np.ndarray, "e a 3"]
    weight: Float64[np.ndarray, " e"]
    spacing: float
    covers: Float64[np.ndarray, " e"]
    seen: Float64[np.ndarray, " k"]

    def seen_areas(self, shown: Shapes) -> Float64[np.ndarray, "e k"]:
        """Measure the area that is seen of each shape from each elevation, (e, k)."""
        return _seen_areas(shown, self.toward, self.spacing)

    def covered(self, shown: Shapes, elevation: int) -> float:
        """Measure the area that shapes cover from one elevation, over azimuths [m²]."""
        areas = visible_areas(shown, self.toward[elevation], self.spacing)
        return float(areas.sum()) / AZIMUTHS

    def mean_colour(self, whole: Shapes, palette: np.ndarray) -> Reals:
        """Compute the mean albedo of what is seen of the whole object, (3,)."""
        colour: Reals = self.seen @ whole.albedos(palette) / self.seen.sum()
        return colour


def look_at(whole: Shapes) -> CrownViews:
    """Look at an object in full detail."""
    points, radii = whole.spheres
    extent = float((points.max(axis=0) - points.min(axis=0)).max())
    spacing = max(extent, 2 * float(radii.max())) / RAYS
    toward = np.array([_around(k, each) for k, each in enumerate(ELEVATIONS_DEG)])
    areas, weight = _seen_areas(whole, toward, spacing), _weights()
    return CrownViews(toward, weight, spacing, areas.sum(axis=1), weight @ areas)


def _seen_areas(
    shown: Shapes, toward: Float64[np.ndarray, "e a 3"], spacing: float
) -> Float64[np.ndarray, "e k"]:
    def run(first: int, last: int) -> list[Reals]:
        return [visible_areas(shown, views, spacing).mean(axis=0) for views in toward[first:last]]

    return np.array([each for some in map_chunks(run, len(toward), 1) for each in some])


def _around(number: int, elevation_deg: float) -> Points:
    """Make the unit vectors of one elevation, (a, 3)."""
    turn = np.radians(_TURN_DEG * number + 360.0 / AZIMUTHS * np.arange(AZIMUTHS))
    e = np.radians(elevation_deg)
    up = np.full(AZIMUTHS, np.sin(e))
    return np.stack((np.cos(e) * np.cos(turn), np.cos(e) * np.sin(turn), up), axis=1)


def _weights() -> Reals:
    """Share of a half sphere that is nearest to each elevation, (e,)."""
    edges = np.radians(np.array(ELEVATIONS_DEG))
    middles = np.concatenate(([0.0], (edges[1:] + edges[:-1]) / 2, [np.pi / 2]))
    return np.diff(np.sin(middles))
