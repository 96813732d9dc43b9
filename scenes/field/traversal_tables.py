"""The parts of all prototypes of a species as the compiled walk reads them, slot by slot."""

from typing import NamedTuple

import numpy as np

from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from scenes.field.part_tables import PartTables

_ROUNDING_M = 1e-6
"""More than positions within a frame are ever rounded by [m]."""


class TraversalTables(NamedTuple):
    """The parts of all prototypes, the parts of one whole side by side: what a walk reads.

    place  (s, 3) origin in the frame of its joint [m]; bound (s,) [m]
    wander (s,) farthest that the origin can be from where the root rests, in any pose [m]
    links  (s, 4) int32: row in the part tables, row of its joint in a frame, first slot and
           number of its own parts
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


def slots_of(part_tables: PartTables, max_sway_m: np.ndarray) -> TraversalTables:
    """Lay the parts of part tables out for the walk: roots first, then the parts of each whole.

    max_sway_m: (v,) how far the root of each prototype can be from where it rests; 0 = it stays.
    """
    row = np.concatenate((part_tables.root, part_tables.order))
    first = len(part_tables.root) + part_tables.first_part
    links = (row, part_tables.joint[row] + 1, first[row], part_tables.part_count[row])
    wander = [
        _wander(tree, float(sway))
        for tree, sway in zip(part_tables.hierarchies, max_sway_m, strict=True)
    ]
    spread = [
        (w.max(), (w + t.B).max()) for w, t in zip(wander, part_tables.hierarchies, strict=True)
    ]
    return TraversalTables(
        place=np.ascontiguousarray(part_tables.origin[row]),
        bound=part_tables.bound[row],
        wander=np.concatenate(wander)[row],
        links=np.stack(links, axis=1).astype(np.int32),
        rest=part_tables.rest[part_tables.root],
        spread=np.array(spread),
        most=max(len(tree) for tree in part_tables.hierarchies),
    )


def _wander(tree: Hierarchy, max_sway_m: float) -> np.ndarray:
    """How far the origin of each part can be from where the root rests, (n,) [m]."""
    if max_sway_m == 0:
        return np.linalg.norm(tree.position - tree.position[0], axis=1) + _ROUNDING_M
    wander = np.full(len(tree), max_sway_m + _ROUNDING_M)
    for row in range(1, len(tree)):
        wander[row] = wander[tree.parent[row]] + tree.separation[row]
    return wander


def limit_table(
    slots: TraversalTables, part_tables: PartTables, view: View, most: float
) -> np.ndarray:
    """Wander, limit distances in view and out of it, and bound, slot by slot, (steps, s, 4) [m].

    For every motion step as in ``PartTables.limits_by_motion``.
    """
    limits = part_tables.limits_by_motion(view, most)[:, slots.links[:, 0]]
    table = np.empty((*limits.shape[:2], 4))
    table[..., 0], table[..., 1:3], table[..., 3] = slots.wander, limits, slots.bound
    return table
