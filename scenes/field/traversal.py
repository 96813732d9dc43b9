"""The compiled walk over the parts of posed objects: root first, and down only where that passes.

One object at a time, its parts level by level. Most tests are decided before the part's position is
known: a part that is never farther than w from where the root rests, whose distance is d, passes
where d + w < D and fails where d − w ≥ D (triangle inequality); so too with what is in view. Only
what is left is posed, each joint once, and put to the one comparison. All of that is float64, and
agrees with the level-by-level pruner to the last bit; rows of parts are int32.

Objects are shared out to threads in runs, and the runs joined in order: same bytes for any number.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

from lod.pruning.compiled_test import (
    CompiledView,
    compile_view,
    distance_to,
    is_displayed,
    sphere_in_frustum,
)
from lod.pruning.view import View
from lod.threads import map_chunks
from scenes.field.traversal_tables import TraversalTables
from scenes.rig.pose import (
    IDENTITY,
    NO_POSE,
    POSED,
    begin_pose,
    mark_joint,
    pose_buffers,
    pose_marked,
    rotation_matrix,
    transform_point,
)
from scenes.rig.pose_tables import InstanceColumns, Instances, PoseTables

_ROOM = 2**20
"""DisplayedRows in one buffer at first; memory is taken only as it fills."""

_UNKNOWN, _SEEN, _UNSEEN, _PARTLY = 0, 1, 2, 3

_SHORTEST_RUN = 256
"""Objects for which another thread is worth its start."""


class DisplayedRows(NamedTuple):
    """Displayed parts: object, row in the atlas, and row here of the whole (−1), (n,) int32 each;
    and how many parts were examined.
    """

    object: np.ndarray
    part: np.ndarray
    parent: np.ndarray
    examined: int


def walk(
    pose_tables: PoseTables,
    slots: TraversalTables,
    limits: np.ndarray,
    instances: Instances,
    motion_step: np.ndarray,
    view: View,
) -> DisplayedRows:
    """Everything displayed of these objects; motion_step (n,): of each."""
    vantage, columns = compile_view(view), (instances.columns(), motion_step)

    def run(first: int, last: int) -> list[DisplayedRows]:
        return _run(pose_tables, slots, limits, columns, vantage, first, last)

    runs = map_chunks(run, len(instances), _SHORTEST_RUN)
    return _joined([rows for each in runs for rows in each])


def _run(
    pose_tables: PoseTables,
    slots: TraversalTables,
    limits: np.ndarray,
    columns: tuple[InstanceColumns, np.ndarray],
    vantage: CompiledView,
    first: int,
    last: int,
) -> list[DisplayedRows]:
    """Objects first to last, buffer by buffer."""
    done: list[DisplayedRows] = []
    room = max(_ROOM, 2 * slots.most)
    while first < last or not done:
        out = np.empty((3, room), np.int32)
        table = (slots.place, limits, slots.links, slots.rest, slots.spread)
        first, filled, examined = _walk(
            pose_tables.columns,
            pose_tables.max_joints,
            vantage,
            *columns,
            table,
            slots.most,
            first,
            last,
            out,
        )
        done.append(DisplayedRows(out[0, :filled], out[1, :filled], out[2, :filled], examined))
        room *= 2
    return done


def _joined(runs: list[DisplayedRows]) -> DisplayedRows:
    if len(runs) == 1:
        return runs[0]
    starts = np.cumsum([0] + [len(rows.part) for rows in runs])
    wholes = [
        np.where(rows.parent < 0, rows.parent, rows.parent + np.int32(start))
        for rows, start in zip(runs, starts[:-1], strict=True)
    ]
    objects, parts = (np.concatenate([getattr(r, k) for r in runs]) for k in ("object", "part"))
    return DisplayedRows(
        objects, parts, np.concatenate(wholes), sum(rows.examined for rows in runs)
    )


@njit(cache=True, nogil=True)
def _walk(  # type: ignore[no-untyped-def]
    t,
    joints,
    vantage,
    instances,
    motion_step,
    table,
    most,
    first,
    last,
    out,
):
    """Objects from ``first`` while the rest of the buffer holds any one of them.

    Gives the object it stopped before, rows filled, and parts examined.
    """
    place, limits, links, rest, spread = table
    feet = instances.foot_contacts
    buffers = pose_buffers(joints)
    frame, state = buffers.frame, buffers.state
    slot = np.empty(most, np.int32)
    n, examined, o = 0, 0, first
    while o < last and n + most <= out.shape[1]:
        v = instances.prototype[o]
        middle = _rests(instances, o, rest[v, 0], rest[v, 1], rest[v, 2])
        d, seen, stands = distance_to(vantage, *middle), _UNKNOWN, False
        stance, turn = NO_POSE, IDENTITY
        base, i, whole, k, end = n, n, -1, v, v + 1
        step = int(motion_step[o])
        between = motion_step[o] - step
        while True:
            examined += end - k
            while k < end:
                wander, inside = limits[step, k, 0], limits[step, k, 1]
                outside = limits[step, k, 2]
                if between > 0:
                    inside += between * (limits[step + 1, k, 1] - inside)
                    outside += between * (limits[step + 1, k, 2] - outside)
                passed, decided = d + wander < outside, True
                if not passed and d - wander < inside:
                    decided = False
                    if d + wander < inside and d - wander >= outside:
                        if seen == _UNKNOWN:
                            seen = _whether_seen(vantage, middle, spread[v, 0], spread[v, 1])
                        passed, decided = seen == _SEEN, seen != _PARTLY
                if not decided:
                    if not stands:
                        stance = begin_pose(t, buffers, instances, o)
                        turn, stands = rotation_matrix(frame, 0), True
                    row = np.int64(links[k, 1])
                    if row == 0:
                        x, y, z = transform_point(
                            frame, 0, turn, place[k, 0], place[k, 1], place[k, 2]
                        )
                    else:
                        if state[row] != POSED:
                            lowest = mark_joint(t, buffers, stance, row)
                            pose_marked(t, buffers, stance, feet, o, lowest, row)
                        x, y, z = place[k, 0], place[k, 1], place[k, 2]
                        if x == 0.0 and y == 0.0 and z == 0.0:
                            x, y, z = frame[row, 0], frame[row, 1], frame[row, 2]
                        else:
                            x, y, z = transform_point(
                                frame, row, rotation_matrix(frame, row), x, y, z
                            )
                    passed = is_displayed(vantage, x, y, z, limits[step, k, 3], inside, outside)
                if passed:
                    out[0, n], out[1, n], out[2, n] = o, links[k, 0], whole
                    slot[n - base] = k
                    n += 1
                k += 1
            if i == n:
                break
            whole, k = i, links[slot[i - base], 2]
            end = k + links[slot[i - base], 3]
            i += 1
        o += 1
    return o, n, examined


@njit(cache=True)
def _rests(instances, o, x, y, z):  # type: ignore[no-untyped-def]
    """Where the root of an object would be at rest."""
    origin, cos, sin = instances.origin, instances.cos[o], instances.sin[o]
    east, north = origin[o, 0] + cos * x - sin * y, origin[o, 1] + sin * x + cos * y
    return east, north, origin[o, 2] + z


@njit(cache=True)
def _whether_seen(vantage, middle, wander, reach):  # type: ignore[no-untyped-def]
    """Whether the origins of an object's parts are all in view, or nothing of it, or neither."""
    x, y, z = middle
    if sphere_in_frustum(vantage, x, y, z, -wander):
        return _SEEN
    return _PARTLY if sphere_in_frustum(vantage, x, y, z, reach) else _UNSEEN
