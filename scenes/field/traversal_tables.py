"""The parts of all prototypes of a species in the order in which the compiled traversal reads them.

Roots come first, then the parts of one whole side by side, so that each step down the tree reads
neighbouring rows.
"""

from typing import NamedTuple

import numpy as np

from lod.metric.hierarchy import Hierarchy
from lod.pruning.view import View
from scenes.field.part_tables import PartTables

_ROUNDING_M = 1e-6
"""More than positions within a frame are ever rounded by [m]."""


class TraversalTables(NamedTuple):
    """Nodes of the hierarchies of all prototypes, (s,), and what bounds each prototype, (v,).

    origin  (s, 3) of the part, in the frame of its joint [m]; bound (s,) its B [m]
    max_displacement (s,) farthest that this origin can be from where the root rests, in any pose
            [m]
    nodes   (s, 4) int32: row in the part tables, row of its joint in a frame, first node of its own
            parts, and their number
    rest    (v, 3) where the root of each prototype rests; its node is the prototype's number [m]
    extent  (v, 2) greatest displacement of any of its parts, and radius about ``rest`` that
            holds everything of it [m]
    max_parts  parts of the largest prototype
    """

    origin: np.ndarray
    bound: np.ndarray
    max_displacement: np.ndarray
    nodes: np.ndarray
    rest: np.ndarray
    extent: np.ndarray
    max_parts: int

    @staticmethod
    def of(tables: PartTables, sway_m: np.ndarray) -> "TraversalTables":
        """Lay out the nodes of part tables.

        sway_m (v,): how far the root of each prototype can be from where it rests; 0 = it does not
            move
        """
        row, trees = np.concatenate((tables.root, tables.order)), tables.hierarchies
        first = len(tables.root) + tables.first_part
        nodes = (row, tables.joint[row] + 1, first[row], tables.part_count[row])
        away = [_max_displacement(tree, m) for tree, m in zip(trees, sway_m.tolist(), strict=True)]
        extent = [(a.max(), (a + tree.B).max()) for a, tree in zip(away, trees, strict=True)]
        return TraversalTables(
            origin=np.ascontiguousarray(tables.origin[row]),
            bound=tables.bound[row],
            max_displacement=np.concatenate(away)[row],
            nodes=np.stack(nodes, axis=1).astype(np.int32),
            rest=tables.rest[tables.root],
            extent=np.array(extent),
            max_parts=max(len(tree) for tree in trees),
        )


def _max_displacement(tree: Hierarchy, sway_m: float) -> np.ndarray:
    """How far the origin of each part can be from where the root rests, (n,) [m]."""
    if sway_m == 0:
        return np.linalg.norm(tree.position - tree.position[0], axis=1) + _ROUNDING_M
    away = np.full(len(tree), sway_m + _ROUNDING_M)
    for row in range(1, len(tree)):
        away[row] = away[tree.parent[row]] + tree.separation[row]
    return away


def node_limits(
    nodes: TraversalTables, tables: PartTables, view: View, max_steps: float
) -> np.ndarray:
    """Maximal displacement, limit distances in view and out of it, and bound, of every node,
    (steps, s, 4) [m].

    steps: of motion, as in ``PartTables.limits_by_motion``
    """
    limits = tables.limits_by_motion(view, max_steps)[:, nodes.nodes[:, 0]]
    table = np.empty((*limits.shape[:2], 4))
    table[..., 0], table[..., 1:3], table[..., 3] = nodes.max_displacement, limits, nodes.bound
    return table
