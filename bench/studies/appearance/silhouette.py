"""How much of a picture does an object cover, displayed down to a level, against all of it?"""

import numpy as np

from bench.studies.appearance.cuts import LoneObject, shapes_of
from lod.arrays import Reals
from scenes.appearance.visible_area import visible_areas
from scenes.sticks.areas import directions

RAYS = 220
"""Rays across the radius that holds an object."""


def cover_ratios(one: LoneObject, level: int) -> Reals:
    """Compute the cover of a level over that of the whole in 64 directions, half from below."""
    around = directions() * np.where(np.arange(64) % 2, -1.0, 1.0)[:, None]
    found = [_cover(one, level, view) / _cover(one, one.finest, view) for view in around]
    return np.array(found)


def _cover(one: LoneObject, level: int, view: Reals) -> float:
    shown = shapes_of(one.shown(level, float(view[2])))
    return float(visible_areas(shown, view[None], one.reach / RAYS).sum())
