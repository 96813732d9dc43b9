"""Joints of an imported model: where its parts turn, about which axis, and how.

Each joint sits at the origin of its node and turns about one axis; its frame is that of the object
as it rests. All that turns keeps to one period, in which it makes whole turns, or swings once.

Projected area of every part of a model, with all that hangs on it, along given directions.

Seen along a direction the triangles of a part and of all below it fall on a square grid of points,
CELLS to the longer side; the points that any covers are counted. Points fall evenly, so that areas
are unbiased, however thin what covers them is.

Prototypes of imported models: P, R, B and separation from the geometry of their meshes.

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
from jaxtyping import Float64
from numba import njit

from lod.arrays import Ints, Points, Reals
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.shapes import MeshTable, StickTable
from scenes.imported.appearances import model_appearances
from scenes.imported.part_tree import PartTree
from scenes.rig.rig import Motion, Rig, RiggedSticks, rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import _along, _frame, directions
from scenes.sticks.prototype import part_contrast

_KEYS_A_TURN, _KEYS_A_SWING = 8, 24
"""Key poses: between two of them a joint turns by less than half a turn, the shorter way."""


def joints_of(tree: PartTree) -> tuple[Rig, Ints]:
    """Make the rig of a model, and find the joint of each part, (n,), −1 for the object's frame."""
    joint = np.full(len(tree), -1)
    names, parent, origin = [], [], []
    for row, above in enumerate(tree.parent.tolist()):
        joint[row] = joint[above] if above >= 0 else -1
        if np.any(tree.axis[row]):
            names.append(tree.names[row])
            parent.append(joint[row])
            origin.append(tree.frame[row, :3, 3])
            joint[row] = len(names) - 1
    places = np.array(origin).reshape(-1, 3)
    above_it = np.array(parent, np.int64)
    before = np.concatenate((np.zeros((1, 3)), places))[above_it + 1]
    rest = np.tile((0.0, 0.0, 0.0, 1.0), (len(names), 1))
    most = np.full((len(names), 3), 180.0)
    still = np.zeros(3)
    rig = Rig(tuple(names), above_it, places - before, rest, -most, most, still, still)
    return rig, joint


def motion_of(tree: PartTree, rig: Rig) -> Motion:
    """Make the motion of a model: every joint turns evenly, or swings as a sine."""
    rows = np.flatnonzero(tree.axis.any(axis=1))
    if not len(rows):
        return rest_motion(rig)
    turns, swing = tree.turns[rows], np.radians(tree.swing[rows])
    keys = max(_KEYS_A_TURN * int(np.abs(turns).max()), _KEYS_A_SWING)
    phase = 2 * np.pi * np.arange(keys)[:, None] / keys
    angle = np.where(swing > 0, swing * np.sin(phase), turns * phase)
    linear = tree.frame[rows, :3, :3]
    axis = np.einsum("jab,jb->ja", linear, tree.axis[rows])
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    rotations = np.concatenate(
        (np.sin(angle / 2)[..., None] * axis, np.cos(angle / 2)[..., None]), axis=-1
    )
    return Motion(rotations, np.zeros((keys, 3)), 0.0, tree.period)


CELLS = 160


def projected_areas(
    parent: Ints, meshes: MeshTable, directions: Float64[np.ndarray, "d 3"]
) -> Float64[np.ndarray, "n d"]:
    """Measure the projected area of each part along each direction, (n, d) [m²].

    parent (n,) as in Hierarchy; meshes: of the n parts, in one frame
    """
    order, begin, end = depth_first(parent, meshes.count)
    rows = np.concatenate(
        [np.arange(meshes.first_face[part], meshes.first_face[part + 1]) for part in order]
    )
    corners = np.ascontiguousarray(meshes.vertices[meshes.faces[rows]].reshape(-1, 3))
    return _areas(corners, begin, end, np.ascontiguousarray(directions))


def depth_first(parent: Ints, count: Ints) -> tuple[Ints, Ints, Ints]:
    """Order parts so that all below a part follow it, (n,), and find the run of each, (n,) each.

    The run of a part goes from its first triangle to the end of those below it, in that order;
    ``count`` (n,) is how many triangles each has itself.
    """
    n = len(parent)
    size, total = np.ones(n, np.int64), count.astype(np.int64)
    for row in range(n - 1, 0, -1):
        size[parent[row]] += size[row]
        total[parent[row]] += total[row]
    place, begin = np.zeros(n, np.int64), np.zeros(n, np.int64)
    next_place, next_begin = place + 1, count.astype(np.int64)
    for row in range(1, n):
        above = parent[row]
        place[row], begin[row] = next_place[above], next_begin[above]
        next_place[above] += size[row]
        next_begin[above] += total[row]
        next_place[row] = place[row] + 1
        next_begin[row] = begin[row] + count[row]
    return np.argsort(place), begin, begin + total


@njit(cache=True)
def _areas(corners, begin, end, directions):  # type: ignore[no-untyped-def]
    n = len(begin)
    areas = np.zeros((n, len(directions)))
    grid = np.zeros((CELLS + 1, CELLS + 1), np.uint8)
    for j in range(len(directions)):
        across, up = _frame(directions[j])
        x, y = _along(corners, across), _along(corners, up)
        for i in range(n):
            a, b = 3 * begin[i], 3 * end[i]
            areas[i, j] = _covered(x[a:b], y[a:b], grid)
    return areas


@njit(cache=True)
def _covered(x, y, grid):  # type: ignore[no-untyped-def]
    """Area that triangles cover, three corners each in a row."""
    low_x, low_y = x.min(), y.min()
    side = max(x.max() - low_x, y.max() - low_y)
    cell = side / CELLS
    if cell <= 0.0:
        return 0.0
    grid[:] = 0
    for t in range(0, len(x), 3):
        top = max(y[t], y[t + 1], y[t + 2])
        bottom = min(y[t], y[t + 1], y[t + 2])
        first = int(np.ceil((bottom - low_y) / cell - 0.5))
        last = int(np.floor((top - low_y) / cell - 0.5))
        for row in range(max(first, 0), min(last, CELLS) + 1):
            level = low_y + (row + 0.5) * cell
            left, right = np.inf, -np.inf
            for k in range(3):
                p, q = t + k, t + (k + 1) % 3
                if (y[p] <= level) != (y[q] <= level):
                    at = x[p] + (level - y[p]) / (y[q] - y[p]) * (x[q] - x[p])
                    left, right = min(left, at), max(right, at)
            if left <= right:
                a = int(np.ceil((left - low_x) / cell - 0.5))
                b = int(np.floor((right - low_x) / cell - 0.5))
                for column in range(max(a, 0), min(b, CELLS) + 1):
                    grid[row, column] = 1
    return grid.sum() * cell * cell


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
    areas = _areas_prototype(tree)
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


def _areas_prototype(tree: PartTree) -> np.ndarray:
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
