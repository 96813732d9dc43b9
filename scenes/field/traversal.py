"""The compiled traversal of the parts of posed objects, from the root down to what fails its test.

One object at a time, its parts level by level. Most tests are decided before the part's position is
known: a part that is never farther than w from where the root rests, whose distance is d, passes
where d + w < D and fails where d − w ≥ D (triangle inequality); so too with what is in view. Only
what is left is posed, each joint once, and put to the one comparison. All of that is float64, and
agrees with the level-by-level pruner to the last bit; rows of parts are int32.

Objects are shared out to threads in runs, and the runs joined in order: same bytes for any number.
"""

from typing import NamedTuple

import numpy as np

from lod.arrays import Reals
from lod.hierarchy import Hierarchy
from lod.kernels import ZERO, map_chunks, njit
from lod.view import View, compile_view, distance_to, is_displayed, sphere_in_frustum
from scenes.field.part_tables import PartTables
from scenes.rig.pose import (
    IDENTITY,
    NO_POSE,
    POSED,
    Instances,
    PoseTables,
    begin_pose,
    mark_joint,
    pose_buffers,
    pose_marked,
    rotation_matrix,
    transform_point,
)

_ROUNDING_M = 1e-6  # more than positions within a frame are ever rounded by [m]


class TraversalTables(NamedTuple):
    """Nodes of the hierarchies of all prototypes, (s,), and what bounds each prototype, (v,).

    Roots come first, then the parts of one whole side by side, so that each step down the tree
    reads neighbouring rows.

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
    if sway_m == 0:
        return np.linalg.norm(tree.position - tree.position[0], axis=1) + _ROUNDING_M
    away = np.full(len(tree), sway_m + _ROUNDING_M)
    for row in range(1, len(tree)):
        away[row] = away[tree.parent[row]] + tree.separation[row]
    return away


def node_limits(
    nodes: TraversalTables, tables: PartTables, view: View, max_steps: float
) -> np.ndarray:
    """Compute what bounds every node at steps of motion (``limits_by_motion``), (steps, s, 4) [m].

    They are its maximal displacement, its limit distances in view and out of it, and its bound.
    """
    limits = tables.limits_by_motion(view, max_steps)[:, nodes.nodes[:, 0]]
    table = np.empty((*limits.shape[:2], 4))
    table[..., 0], table[..., 1:3], table[..., 3] = nodes.max_displacement, limits, nodes.bound
    return table


_ROOM = 2**20
"""Rows in the first buffer, each of which is twice as large as the one before; memory is taken only
as it fills."""

_UNKNOWN, _FAILS, _PASSES, _BY_VIEW, _BY_POSITION = 0, 1, 2, 3, 4
"""What is known of a part's test before its position: its outcome, or what decides it."""

_SHORTEST_RUN = 256  # objects for which another thread is worth its start


class DisplayedRows(NamedTuple):
    """Displayed parts, (n,) int32 each, and how many parts were examined.

    object, part  rows of the object and in the part tables; parent: row here, −1 for roots
    """

    object: np.ndarray
    part: np.ndarray
    parent: np.ndarray
    examined: int


def traverse(
    pose_tables: PoseTables,
    nodes: TraversalTables,
    limits: np.ndarray,
    instances: Instances,
    motion_step: Reals,
    view: View,
) -> DisplayedRows:
    """Return the displayed parts of these objects.

    limits (steps, s, 4): as ``node_limits`` gives them; motion_step (n,): how much motion hides of
        each object, on the scale of lod.motion
    """
    given = pose_tables, compile_view(view), instances, motion_step, nodes, limits

    def run(first: int, last: int) -> list[DisplayedRows]:
        done: list[DisplayedRows] = []
        room = max(_ROOM, 2 * nodes.max_parts)
        while first < last or not done:
            out = np.empty((3, room), np.int32)
            first, filled, examined = _traverse(given, first, last, out)
            done.append(DisplayedRows(out[0, :filled], out[1, :filled], out[2, :filled], examined))
            room *= 2
        return done

    runs = [rows for each in map_chunks(run, len(motion_step), _SHORTEST_RUN) for rows in each]
    if len(runs) == 1:
        return runs[0]
    # Rows of parents are counted from the first of all.
    starts = np.cumsum([0] + [len(rows.part) for rows in runs])
    parents = [
        np.where(rows.parent < 0, rows.parent, rows.parent + np.int32(start))
        for rows, start in zip(runs, starts[:-1], strict=True)
    ]
    objects, parts = (np.concatenate([getattr(r, k) for r in runs]) for k in ("object", "part"))
    examined = sum(rows.examined for rows in runs)
    return DisplayedRows(objects, parts, np.concatenate(parents), examined)


@njit(cache=True, nogil=True)
def _traverse(given, first, last, out):  # type: ignore[no-untyped-def]
    """Objects from ``first`` on, while the rest of the buffer has room for any one of them.

    Gives the object it stopped before, rows filled, and parts examined.
    """
    # Arrays are unpacked here once: whatever a tuple gives up inside the loop is counted anew.
    t, view, instances, motion_step, tables, limits = given
    origin, _, _, nodes, rests, extent, max_parts = tables
    root, feet, buffers = instances.origin, instances.foot_contacts, pose_buffers(t.max_joints)
    prototype, frame, state = instances.prototype, buffers.frame, buffers.state
    node = np.empty(max_parts, np.int32)
    n, examined, o = 0, 0, first
    while o < last and n + max_parts <= out.shape[1]:
        v = prototype[o]
        cos, sin, x, y = instances.cos[o], instances.sin[o], rests[v, 0], rests[v, 1]
        east, north = root[o, 0] + cos * x - sin * y, root[o, 1] + sin * x + cos * y
        rest = east, north, root[o, 2] + rests[v, 2]
        d, seen = distance_to(view, *rest), _UNKNOWN
        pose, turn, begun = NO_POSE, IDENTITY, False
        base, i, parent, k, end = n, n, -1, v, v + 1
        step = int(motion_step[o])
        share = motion_step[o] - step
        while True:
            examined += end - k
            while k < end:
                inside, outside = limits[step, k, 1], limits[step, k, 2]
                if share > 0:
                    inside += share * (limits[step + 1, k, 1] - inside)
                    outside += share * (limits[step + 1, k, 2] - outside)
                known = _decide(d, limits[step, k, 0], inside, outside)
                if known == _BY_VIEW:
                    if seen == _UNKNOWN:
                        seen = _decide_by_view(view, rest, extent[v, 0], extent[v, 1])
                    known = seen
                passed = known == _PASSES
                if known == _BY_POSITION:
                    if not begun:
                        pose = begin_pose(t, buffers, instances, o)
                        turn, begun = rotation_matrix(frame, ZERO), True
                    row = np.int64(nodes[k, 1])
                    if state[row] != POSED:
                        lowest = mark_joint(t, buffers, pose, row)
                        pose_marked(t, buffers, pose, feet, o, lowest, row)
                    x, y, z = _node_origin(frame, row, turn, origin, k)
                    passed = is_displayed(view, x, y, z, limits[step, k, 3], inside, outside)
                if passed:
                    out[0, n], out[1, n], out[2, n] = o, nodes[k, 0], parent
                    node[n - base] = k
                    n += 1
                k += 1
            if i == n:
                break
            parent, k = i, nodes[node[i - base], 2]
            end = k + nodes[node[i - base], 3]
            i += 1
        o += 1
    return o, n, examined


@njit(cache=True)
def _decide(d, displacement, inside, outside):  # type: ignore[no-untyped-def]
    """What is known of a part's test from the distance of where its root rests: see the module."""
    if d + displacement < outside:
        return _PASSES
    if not d - displacement < inside:
        return _FAILS
    by_view = d + displacement < inside and d - displacement >= outside
    return _BY_VIEW if by_view else _BY_POSITION


@njit(cache=True)
def _decide_by_view(view, rest, displacement, radius):  # type: ignore[no-untyped-def]
    """Outcome of tests that are passed in view alone: the same for all parts of an object whose
    origins are all in view, or of which nothing is."""
    x, y, z = rest
    if sphere_in_frustum(view, x, y, z, -displacement):
        return _PASSES
    return _BY_POSITION if sphere_in_frustum(view, x, y, z, radius) else _FAILS


@njit(cache=True, inline="always")
def _node_origin(frame, row, turn, origin, k):  # type: ignore[no-untyped-def]
    x, y, z = origin[k, 0], origin[k, 1], origin[k, 2]
    if row == 0:
        place = transform_point(frame, ZERO, turn, x, y, z)
    elif x == 0.0 and y == 0.0 and z == 0.0:
        place = frame[row, 0], frame[row, 1], frame[row, 2]
    else:
        place = transform_point(frame, row, rotation_matrix(frame, row), x, y, z)
    return place
