"""Sticks of displayed parts, posed and laid out in one compiled loop.

Their ends are where ``scenes.rig.pose.pose_points`` puts them, and their radii cover each stick's
share of its area (``lod.pruning.area_scaling``). Positions are float64 up to the renderer's door.
"""

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from lod.arrays import Ints
from lod.pruning.area_scaling import radius_factor
from lod.pruning.shapes import Sticks
from lod.threads import map_chunks
from scenes.field.part_tables import DisplayedSticks, PartTables
from scenes.rig.pose import (
    begin_pose,
    mark_joint,
    pose_buffers,
    pose_marked,
    rotation_matrix,
    transform_point,
)
from scenes.rig.pose_tables import Instances, PoseTables

_SHORTEST_RUN = 8192
"""Sticks for which another thread is worth its start."""


class _StickColumns(NamedTuple):
    """Rigged sticks as the loop reads them: ends (k, 3) in the frames of their joints, joints (k,),
    radii (k,) [m]."""

    start: np.ndarray
    end: np.ndarray
    start_joint: np.ndarray
    end_joint: np.ndarray
    start_radius: np.ndarray
    end_radius: np.ndarray


class _PosedSticks(NamedTuple):
    """Where the loop writes: ends (n, 3), radii at both (2, n) [m]."""

    start: np.ndarray
    end: np.ndarray
    radii: np.ndarray


def emit(
    pose_tables: PoseTables,
    part_tables: PartTables,
    instances: Instances,
    objects: Ints,
    displayed: DisplayedSticks,
) -> Sticks:
    """Pose the sticks of displayed parts; ``objects`` (n,) are rows in ``instances``."""
    table = _StickColumns(*(getattr(part_tables.sticks, name) for name in _StickColumns._fields))
    n, columns = len(displayed.stick), instances.columns()
    posed = _PosedSticks(np.empty((n, 3)), np.empty((n, 3)), np.empty((2, n)))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        own = DisplayedSticks(*(column[rows] for column in displayed))
        out = _PosedSticks(posed.start[rows], posed.end[rows], posed.radii[:, rows])
        _emit(pose_tables.columns, pose_tables.max_joints, columns, objects, own, table, out)

    map_chunks(run, n, _SHORTEST_RUN)
    start, end, radii = posed
    return Sticks(
        start, end, radii[0], radii[1], displayed.tint, part_tables.tints, displayed.owner
    )


@njit(cache=True, nogil=True)
def _emit(t, max_joints, instances, objects, displayed, table, out):  # type: ignore[no-untyped-def]
    """Pose the displayed sticks into ``out``, object by object: each joint once."""
    owner, stick, share, _ = displayed
    joint0, joint1 = table.start_joint, table.end_joint
    n = len(stick)
    buffers = pose_buffers(max_joints)
    m = 0
    while m < n:
        o, first = objects[owner[m]], m
        pose = begin_pose(t, buffers, instances, o)
        while m < n and objects[owner[m]] == o:
            mark_joint(t, buffers, pose, joint0[stick[m]] + 1)
            mark_joint(t, buffers, pose, joint1[stick[m]] + 1)
            m += 1
        pose_marked(t, buffers, pose, instances.foot_contacts, o, 1, pose.joints)
        _emit_object(buffers.frame, stick, share, table, out, first, m)


@njit(cache=True)
def _emit_object(frame, stick, share, table, out, first, last):  # type: ignore[no-untyped-def]
    """Sticks first to last, all of one object, whose joints have these frames."""
    start, end, joint0, joint1, radius0, radius1 = table
    starts, ends, radii = out
    row, turn = 0, rotation_matrix(frame, 0)
    for m in range(first, last):
        k = stick[m]
        if joint0[k] + 1 != row:
            row = joint0[k] + 1
            turn = rotation_matrix(frame, row)
        a = transform_point(frame, row, turn, start[k, 0], start[k, 1], start[k, 2])
        if joint1[k] + 1 != row:
            row = joint1[k] + 1
            turn = rotation_matrix(frame, row)
        b = transform_point(frame, row, turn, end[k, 0], end[k, 1], end[k, 2])
        starts[m, 0], starts[m, 1], starts[m, 2] = a
        ends[m, 0], ends[m, 1], ends[m, 2] = b
        factor = 1.0
        if share[m] != 1.0:
            x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
            length = math.sqrt(x * x + y * y + z * z)
            factor = radius_factor(radius0[k], radius1[k], length, share[m])
        radii[0, m], radii[1, m] = radius0[k] * factor, radius1[k] * factor
