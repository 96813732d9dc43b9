"""Meshes of displayed parts, posed: vertices and normals carried by the joints of their parts.

A part that fades shrinks about its origin, so that its area is the share that it shows.
"""

import numpy as np

from lod.arrays import Ints, Reals, expand
from lod.mesh_table import MeshTable
from lod.pruning.shapes import Triangles
from scenes.field.part_tables import PartTables
from scenes.rig.pose import pose_points
from scenes.rig.pose_tables import Instances, PoseTables


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
    part, scale = parts[rows], np.sqrt(share[rows])
    origin, turn = _joint_frames(pose_tables, instances, objects[rows], part_tables.joint[part])
    owner, vertex = _expanded(meshes.first_vertex, part)
    middle = part_tables.origin[part][owner]
    local = middle + scale[owner, None] * (meshes.vertices[vertex] - middle)
    vertices = origin[owner] + np.einsum("kab,kb->ka", turn[owner], local)
    normals = np.einsum("kab,kb->ka", turn[owner], meshes.normals[vertex])
    # Rows of this frame's vertices from those of the table, part by part.
    count = np.diff(meshes.first_vertex)[part]
    shift = np.cumsum(count) - count - meshes.first_vertex[part]
    of_face, face = _expanded(meshes.first_face, part)
    faces = meshes.faces[face] + shift[of_face, None]
    return Triangles(vertices, normals, meshes.colours[vertex], faces, rows[of_face])


def triangles_of(meshes: MeshTable | None, parts: Ints) -> Reals:
    """Return how many triangles each of these parts shows, (n,)."""
    if meshes is None:
        return np.zeros(len(parts))
    return meshes.count[parts].astype(np.float64)


def _expanded(first: np.ndarray, parts: np.ndarray) -> tuple[Ints, Ints]:
    """Number of the part among ``parts``, and row of the table, of all that parts have."""
    owner, offset = expand(np.diff(first)[parts])
    return owner, first[parts][owner] + offset


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
