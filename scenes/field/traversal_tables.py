"""The parts of all prototypes of a species as the compiled walk reads them, slot by slot."""

from typing import NamedTuple

import numpy as np

from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from scenes.field.part_tables import Atlas

_ROUNDING_M = 1e-6
"""More than positions within a frame are ever rounded by [m]."""


class Slots(NamedTuple):
    """The parts of all prototypes, the parts of one whole side by side: what a walk reads.

    place  (s, 3) origin in the frame of its joint [m]; bound (s,) [m]
    wander (s,) farthest that the origin can be from where the root rests, in any pose [m]
    links  (s, 4) int32: row in the atlas, row of its joint in a frame, first slot and number of
           its own parts
    rest   (v, 3) where each prototype's root rests; its slot is its number [m]
    spread (v, 2) farthest that any of its parts wanders, and that anything of it reaches [m]
    most   parts of the largest prototype
    """

    place: np.ndarray
    bound: np.ndarray
    wander: np.ndarray
    links: np.ndarray
    rest: np.ndarray
    spread: np.ndarray
    most: int


def slots_of(atlas: Atlas, sway_m: np.ndarray) -> Slots:
    """Lay the parts of an atlas out for the walk: roots first, then the parts of each whole.

    sway_m: (v,) how far the root of each prototype can be from where it rests; 0 = stands still.
    """
    row = np.concatenate((atlas.root, atlas.order))
    first = len(atlas.root) + atlas.first_part
    links = (row, atlas.joint[row] + 1, first[row], atlas.part_count[row])
    wander = [
        _wander(tree, float(sway)) for tree, sway in zip(atlas.hierarchies, sway_m, strict=True)
    ]
    spread = [(w.max(), (w + t.B).max()) for w, t in zip(wander, atlas.hierarchies, strict=True)]
    return Slots(
        place=np.ascontiguousarray(atlas.origin[row]),
        bound=atlas.bound[row],
        wander=np.concatenate(wander)[row],
        links=np.stack(links, axis=1).astype(np.int32),
        rest=atlas.rest[atlas.root],
        spread=np.array(spread),
        most=max(len(tree) for tree in atlas.hierarchies),
    )


def _wander(tree: Hierarchy, sway_m: float) -> np.ndarray:
    """How far the origin of each part can be from where the root rests, (n,) [m]."""
    if sway_m == 0:
        return np.linalg.norm(tree.position - tree.position[0], axis=1) + _ROUNDING_M
    wander = np.full(len(tree), sway_m + _ROUNDING_M)
    for row in range(1, len(tree)):
        wander[row] = wander[tree.whole[row]] + tree.separation[row]
    return wander


def limits_of(slots: Slots, atlas: Atlas, view: View, most: float) -> np.ndarray:
    """Wander, limit distances in view and out of it, and bound, slot by slot, (steps, s, 4) [m].

    For every step of smear as in ``Atlas.smeared_limits``.
    """
    limits = atlas.smeared_limits(view, most)[:, slots.links[:, 0]]
    table = np.empty((*limits.shape[:2], 4))
    table[..., 0], table[..., 1:3], table[..., 3] = slots.wander, limits, slots.bound
    return table
