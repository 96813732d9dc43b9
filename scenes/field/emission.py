"""Sticks and meshes of displayed parts, posed: carried by the joints of their parts.

The ends of sticks are where ``scenes.rig.pose.pose_points`` puts them, and their radii cover each
stick's share of its area (``lod.crossfade``). Positions are float64 up to the renderer's door. A
mesh with a spine gets narrower as it fades, and wider where it stands for others like it, but no
shorter or longer; from PLAIN times its width on a single triangle of the same area has its place.
"""

import math

import numpy as np

from lod.arrays import Ints, Reals
from lod.crossfade import radius_factor
from lod.kernels import ONE, ZERO, njit
from lod.shapes import Sticks, Triangles
from lod.threads import map_chunks
from scenes.field.part_tables import DisplayedSticks, PartTables
from scenes.rig.pose import (
    Instances,
    PoseTables,
    begin_pose,
    mark_joint,
    pose_buffers,
    pose_marked,
    pose_points,
    rotation_matrix,
    transform_point,
)

PLAIN = 4.0
"""How much wider a mesh stands for so many like it that its bends are not seen."""

TONE = 0.03
"""Power of how much wider a mesh is by which it gets darker. Few wide blades shade one another, and
the ground, less evenly than many narrow ones: in a stand on hills, under suns of 10°, 40° and 70°,
they were 3 % too bright where 5 times as wide, and 5 to 7 % where 20 times."""

_SHORTEST_RUN = 8192
"""Sticks for which another thread is worth its start."""


def emit(
    pose_tables: PoseTables,
    part_tables: PartTables,
    instances: Instances,
    objects: Ints,
    displayed: DisplayedSticks,
) -> Sticks:
    """Pose the sticks of displayed parts; ``objects`` (n,) are rows in ``instances``."""
    sticks, n = part_tables.sticks, len(displayed.stick)
    ends, joints = (sticks.start, sticks.end), (sticks.start_joint, sticks.end_joint)
    table = *ends, *joints, sticks.start_radius, sticks.end_radius
    start, end, radii = np.empty((n, 3)), np.empty((n, 3)), np.empty((2, n))

    def run(first: int, last: int) -> None:
        rows = slice(first, last)
        own = DisplayedSticks(*(column[rows] for column in displayed))
        out = start[rows], end[rows], radii[:, rows]
        _emit(pose_tables, instances, objects, own, table, out)

    map_chunks(run, n, _SHORTEST_RUN)
    tints = displayed.tint, part_tables.tints
    return Sticks(start, end, radii[0], radii[1], *tints, displayed.owner)


@njit(cache=True, nogil=True)
def _emit(t, instances, objects, displayed, table, out):  # type: ignore[no-untyped-def]
    owner, stick, share, _ = displayed
    _, _, joint0, joint1, _, _ = table
    n = len(stick)
    buffers = pose_buffers(t.max_joints)
    m = ZERO
    while m < n:
        o, first = objects[owner[m]], m
        pose = begin_pose(t, buffers, instances, o)
        while m < n and objects[owner[m]] == o:
            mark_joint(t, buffers, pose, joint0[stick[m]] + 1)
            mark_joint(t, buffers, pose, joint1[stick[m]] + 1)
            m += 1
        pose_marked(t, buffers, pose, instances.foot_contacts, o, ONE, pose.joints)
        _emit_object(buffers.frame, stick, share, table, out, first, m)


@njit(cache=True)
def _emit_object(frame, stick, share, table, out, first, last):  # type: ignore[no-untyped-def]
    start, end, joint0, joint1, radius0, radius1 = table
    starts, ends, radii = out
    row, turn = ZERO, rotation_matrix(frame, ZERO)
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


def emit_meshes(
    pose_tables: PoseTables,
    part_tables: PartTables,
    instances: Instances,
    objects: Ints,
    parts: Ints,
    share: Reals,
) -> Triangles:
    """Pose the meshes of displayed parts; those without a mesh give nothing.

    objects (n,) rows in ``instances``, parts (n,) rows of the tables; share (n,) of their area that
    they show
    """
    meshes = part_tables.meshes
    if meshes is None:
        raise ValueError("parts without meshes")
    rows = np.flatnonzero((meshes.count[parts] > 0) & (share > 0))
    part = parts[rows]
    # Rows of this frame's vertices and faces at which those of each part begin.
    plain = (share[rows] >= PLAIN) & ~meshes.shrinks_to_point[part]
    first_vertex, first_face = (
        np.append(0, np.cumsum(np.where(plain, fewest, np.diff(first)[part])))
        for first, fewest in ((meshes.first_vertex, 3), (meshes.first_face, 1))
    )
    kinds = np.float64, np.float32, np.float32
    points = [np.empty((first_vertex[-1], 3), kind) for kind in kinds]
    faces, owner = np.empty((first_face[-1], 3), np.int64), np.empty(first_face[-1], np.int64)
    table = (
        *(meshes.first_vertex, meshes.first_face, meshes.shrinks_to_point, meshes.plain_width),
        *(meshes.vertices, meshes.spine, meshes.normals, meshes.colours, meshes.faces),
    )

    def run(first: int, last: int) -> None:
        for start in range(first, last, _SHORTEST_RUN):
            own = slice(start, min(start + _SHORTEST_RUN, last))
            joints = part_tables.joint[part[own]]
            frames = _joint_frames(pose_tables, instances, objects[rows[own]], joints)
            begin = first_vertex[own], first_face[own]
            asked = rows[own], part[own], share[rows[own]]
            _emit_meshes(asked, frames, table, begin, (*points, faces, owner))

    map_chunks(run, len(rows), _SHORTEST_RUN)
    vertices, normals, colours = points
    return Triangles(vertices, normals, colours, faces, owner)


@njit(cache=True, nogil=True)
def _emit_meshes(asked, frames, table, begin, out):  # type: ignore[no-untyped-def]
    rows, parts, share = asked
    origin, turn = frames
    first_vertex, first_face, to_point, plain_width, corner, spine, normal, colour, face = table
    vertices, normals, colours, faces, owner = out
    for i in range(len(parts)):
        part, v, f = parts[i], begin[0][i], begin[1][i]
        first, last = first_vertex[part], first_vertex[part + 1]
        shift, width, plain = v - first, share[i], share[i] >= PLAIN and not to_point[part]
        tone = max(width, 1.0) ** -TONE
        if to_point[part]:
            width = math.sqrt(width)
        elif plain:
            width *= plain_width[part]
        for k in range(first, last):
            if plain and first + 1 < k < last - 1:
                continue  # of a plain one the two corners of its foot and its tip are left
            for a in range(3):
                at, ahead = origin[i, a], 0.0
                for b in range(3):
                    wide = width * (corner[k, b] - spine[k, b])
                    at += turn[i, a, b] * (spine[k, b] + wide)
                    ahead += turn[i, a, b] * normal[k, b]
                vertices[v, a], normals[v, a], colours[v, a] = at, ahead, tone * colour[k, a]
            v += 1
        if plain:
            faces[f, 0], faces[f, 1], faces[f, 2], owner[f] = v - 3, v - 2, v - 1, rows[i]
            continue
        for k in range(first_face[part], first_face[part + 1]):
            for a in range(3):
                faces[f, a] = face[k, a] + shift
            owner[f] = rows[i]
            f += 1


def _joint_frames(
    pose_tables: PoseTables, instances: Instances, objects: Ints, joints: Ints
) -> tuple[np.ndarray, np.ndarray]:
    """Origins (n, 3) [m] and rotations (n, 3, 3) of joints of posed objects, (n,) each."""
    corners = np.concatenate((np.zeros((1, 3)), np.eye(3)))
    most = pose_tables.max_joints + 1
    table = np.tile(corners, (most, 1)), np.repeat(np.arange(-1, most - 1), 4)
    points = (4 * (joints + 1)[:, None] + np.arange(4)).ravel()
    posed = pose_points(pose_tables, instances, np.repeat(objects, 4), points, *table)
    posed = posed.reshape(-1, 4, 3)
    return posed[:, 0], (posed[:, 1:] - posed[:, :1]).transpose(0, 2, 1)
