"""Sticks of displayed parts, posed and laid out in one compiled walk.

What ``rig_pose.pose_sticks`` gives, with radii that cover each stick's share of its area
(``lod.pruning.area_scaling``). Positions are float64 up to the renderer's door.
"""

import math

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


def emit(
    pose_tables: PoseTables,
    part_tables: PartTables,
    instances: Instances,
    objects: Ints,
    displayed: DisplayedSticks,
) -> Sticks:
    """Posed sticks of displayed parts; objects (n,): row of each part in ``instances``."""
    table = part_tables.sticks
    ends = table.start, table.end, table.start_joint, table.end_joint
    sizes = table.start_radius, table.end_radius
    owner, stick, share, tint = displayed
    n, columns = len(stick), instances.columns()
    start, end, radii = np.empty((n, 3)), np.empty((n, 3)), np.empty((2, n))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        which = objects, owner[rows], stick[rows], share[rows]
        out = start[rows], end[rows], radii[:, rows]
        _emit(pose_tables.columns, pose_tables.max_joints, columns, *which, ends, sizes, *out)

    map_chunks(run, n, _SHORTEST_RUN)
    return Sticks(start, end, radii[0], radii[1], tint, part_tables.tints, owner)


@njit(cache=True, nogil=True)
def _emit(  # type: ignore[no-untyped-def]
    t,
    most,
    instances,
    objects,
    owner,
    stick,
    share,
    ends,
    sizes,
    starts,
    stops,
    radii,
):
    start, end, joint0, joint1 = ends
    radius0, radius1 = sizes
    n = len(stick)
    buffers = pose_buffers(most)
    frame = buffers.frame
    m = 0
    while m < n:
        o = objects[owner[m]]
        stance = begin_pose(t, buffers, instances, o)
        last = m
        while last < n and objects[owner[last]] == o:
            mark_joint(t, buffers, stance, joint0[stick[last]] + 1)
            mark_joint(t, buffers, stance, joint1[stick[last]] + 1)
            last += 1
        pose_marked(t, buffers, stance, instances.foot_contacts, o, 1, stance.joints)
        row, turn = 0, rotation_matrix(frame, 0)
        while m < last:
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
            stops[m, 0], stops[m, 1], stops[m, 2] = b
            factor = 1.0
            if share[m] != 1.0:
                x, y, z = b[0] - a[0], b[1] - a[1], b[2] - a[2]
                length = math.sqrt(x * x + y * y + z * z)
                factor = radius_factor(radius0[k], radius1[k], length, share[m])
            radii[0, m], radii[1, m] = radius0[k] * factor, radius1[k] * factor
            m += 1
