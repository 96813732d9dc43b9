"""How much of a picture does a tree cover, displayed down to a level, against all of it?"""

import numpy as np

from bench.studies.appearance.cuts import LoneTree, as_one_part
from lod.arrays import Reals
from scenes.sticks.outline_area import directions
from scenes.sticks.visible_area import visible_areas

RAYS = 220
"""Rays across the radius that holds a tree."""


def cover_ratios(tree: LoneTree, level: int) -> Reals:
    """Compute the cover of a level over that of the whole in 64 directions, half from below."""
    around = directions() * np.where(np.arange(64) % 2, -1.0, 1.0)[:, None]
    found = [_cover(tree, level, view) / _cover(tree, tree.finest, view) for view in around]
    return np.array(found)


def _cover(tree: LoneTree, level: int, view: Reals) -> float:
    sticks = tree.sticks(level, float(view[2]))
    spacing = tree.reach / RAYS
    return float(visible_areas(as_one_part(sticks), view[None], spacing).sum())
