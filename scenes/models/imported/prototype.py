"""Prototypes of imported models: P, R, B and separation from the geometry of their meshes.

    position    middle of the box about all that hangs on a part, as it rests
    P           √ of the largest projected area, over directions, of all that hangs on the part
    R           the greater of the extent of the part's own appearances and those of its direct
        parts, from its position
    B           the greater of the extent of the part and, over its parts, separation + B of the
        part

It is the rule of ``scenes.rig.rigged_prototype``, with meshes for the appearances of ends, and with
what the meshes cover in place of what stands for them. Joints turn about one axis. From a joint on,
distances are bounded by the sum of the lengths on the way: never exceeded, in any pose.
"""

from dataclasses import dataclass

import numpy as np

from lod.arrays import Ints, Points, Reals
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.shapes import MeshTable, StickTable
from scenes.model_files.part_tree import PartTree
from scenes.models.imported.appearances import model_appearances
from scenes.models.imported.joints import joints_of, motion_of
from scenes.models.imported.projected_area import projected_areas
from scenes.rig.rig import RiggedSticks
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.contrast import part_contrast
from scenes.sticks.outline_area import directions


@dataclass(frozen=True, eq=False)
class _Reach:
    """How far things can be from points, for parts whose joints are known.

    joint (n,)   that each part rides on; origin (j, 3) of joints at rest [m]; above (j,) joint
    """

    joint: np.ndarray
    origin: np.ndarray
    above: np.ndarray

    def farthest(
        self, row: int, place: np.ndarray, other: int, points: Points, radii: Reals
    ) -> float:
        """Bound the distance from ``place`` (3,) on the joint of part ``row`` to spheres [m].

        They are at ``points`` (k, 3) as the object rests and ride on the joint of part ``other``,
        which is the same or hangs on it.
        """
        joint, here, way = int(self.joint[other]), int(self.joint[row]), 0.0
        at = points
        while joint != here:
            origin = self.origin[joint]
            way += float((np.linalg.norm(at - origin, axis=1) + radii).max())
            at, radii = origin[None], np.zeros(1)
            joint = int(self.above[joint])
        return way + float((np.linalg.norm(at - place, axis=1) + radii).max())


def imported_prototype(name: str, tree: PartTree) -> RiggedPrototype:
    """Make the prototype of a model."""
    areas = _areas(tree)
    mean, P = areas[:, : len(directions())].mean(axis=1), np.sqrt(areas.max(axis=1))
    looks = model_appearances(tree, mean)
    leaf, tints = looks.leaf, looks.tints
    rig, joint = joints_of(tree)
    position = _middles(tree)
    tied = representative(tree.parent, P)
    position = position[tied]
    origin = rig.frames()[0]
    reach = _Reach(joint, origin, rig.parent)
    lengths = _lengths(tree, reach, position, P, tied, leaf)
    contrast = part_contrast(tree.parent, leaf, tints)[tied]
    hierarchy = Hierarchy(tree.parent, tree.level, position, *lengths, contrast, looks.overlap)
    local = np.concatenate((np.zeros((1, 3)), origin))
    return RiggedPrototype(
        name=name,
        rig=rig,
        joint=joint,
        hierarchy=hierarchy,
        inner=_rigged(leaf.take(np.zeros(0, np.int64)), joint, local),
        leaf=_rigged(leaf, joint, local),
        tints=tints,
        motion=motion_of(tree, rig),
        place=position - local[joint + 1],
        view_dependence=looks.view_dependence,
        meshes=_on_joints(tree.meshes, joint, local),
    )


def _areas(tree: PartTree) -> np.ndarray:
    """Areas of each part along the directions over which means are taken, and along x, y and z."""
    views = np.concatenate((directions(), np.eye(3)))
    return projected_areas(tree.parent, tree.meshes, views)


def _middles(tree: PartTree) -> Points:
    """Middle of the box about all that hangs on each part, (n, 3) [m]."""
    n = len(tree)
    low, high = np.full((n, 3), np.inf), np.full((n, 3), -np.inf)
    np.minimum.at(low, tree.meshes.vertex_owner, tree.meshes.vertices)
    np.maximum.at(high, tree.meshes.vertex_owner, tree.meshes.vertices)
    for row in range(n - 1, 0, -1):
        above = tree.parent[row]
        low[above], high[above] = (
            np.minimum(low[above], low[row]),
            np.maximum(high[above], high[row]),
        )
    return (low + high) / 2


def _lengths(
    tree: PartTree, reach: _Reach, position: Points, P: Reals, tied: Ints, leaf: StickTable
) -> tuple[Reals, Reals, Reals, Reals]:
    """P, R, B and separation of every part, (n,) each [m]."""
    n, parent = len(tree), tree.parent
    own, R, separation = np.zeros(n), np.zeros(n), np.zeros(n)
    spheres = [_spheres(tree.meshes, leaf, row) for row in range(n)]
    none = np.zeros(1)
    for row in range(n):
        own[row] = reach.farthest(row, position[row], row, *spheres[row])
        R[row] = max(R[row], own[row])
        above = int(parent[row])
        if above >= 0:
            R[above] = max(R[above], reach.farthest(above, position[above], row, *spheres[row]))
            at = position[row][None]
            separation[row] = reach.farthest(above, position[above], row, at, none)
    B = own.copy()
    for row in range(n - 1, 0, -1):
        B[parent[row]] = max(B[parent[row]], separation[row] + B[row])
    return max_over_tied(P, tied), max_over_tied(R, tied), B, separation


def _spheres(meshes: MeshTable, leaf: StickTable, row: int) -> tuple[Points, Reals]:
    """What a part looks like, as spheres that hold it: corners of its mesh, ends of its sticks."""
    corners = meshes.vertices[meshes.first_vertex[row] : meshes.first_vertex[row + 1]]
    own = slice(leaf.first[row], leaf.first[row + 1])
    points = np.concatenate((corners, leaf.start[own], leaf.end[own]))
    radii = np.concatenate((np.zeros(len(corners)), leaf.start_radius[own], leaf.end_radius[own]))
    return points, radii


def _rigged(table: StickTable, joint: np.ndarray, local: np.ndarray) -> RiggedSticks:
    """Sticks that ride on the joint of their part."""
    on = joint[table.owner]
    start, end = table.start - local[on + 1], table.end - local[on + 1]
    radii = table.start_radius, table.end_radius
    return RiggedSticks.of(len(table.count), table.owner, start, end, *radii, table.tint, on, on)


def _on_joints(meshes: MeshTable, joint: np.ndarray, local: np.ndarray) -> MeshTable:
    """Meshes in the frames of the joints of their parts, which are not turned at rest."""
    columns = {
        name: getattr(meshes, name)
        for name in ("first_vertex", "first_face", "normals", "colours", "faces")
    }
    return MeshTable(vertices=meshes.vertices - local[joint[meshes.vertex_owner] + 1], **columns)
