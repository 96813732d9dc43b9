"""Prototypes of imported models: joints, sticks, and P, R, B and separation from their meshes.

    position    middle of the box about all that hangs on a part, as it rests
    P           √ of the largest projected area, over directions, of all that hangs on the part
    R           the greater of the extent of the part's own appearances and those of its direct
        parts, from its position
    B           the greater of the extent of the part and, over its parts, separation + B of the
        part

It is the rule of ``scenes.rig.rigged_prototype``, with meshes for the appearances of ends, and with
what the meshes cover in place of what stands for them.

Each joint sits at the origin of its node and turns about one axis; its frame is that of the object
as it rests. All that turns keeps to one period, in which it makes whole turns, or swings once. From
a joint on, distances are bounded by the sum of the lengths on the way: never exceeded, in any pose.

Leaf appearances are fitted as for any other object (``scenes.appearance.fit``), with balls in the
place of pieces of surface where they are gathered, and the meshes themselves where anything is seen
or lit. Ends show their meshes; far cover (``scenes.field.far_cover``) is worked out from a few
sticks in their place, as thick as makes them cover, on average over directions, what the mesh does.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float64
from PIL import Image

from lod.arrays import Ints, Points, Reals, expand
from lod.hierarchy import Hierarchy, max_over_tied, representative
from lod.kernels import njit
from lod.shapes import MeshTable, StickTable, triangle_areas
from scenes.appearance.fit import (
    FittedAppearances,
    cluster,
    error_diffusion,
    fit_appearances,
    fit_radii,
)
from scenes.imported.part_tree import PartTree
from scenes.rig.rig import Motion, Rig, RiggedSticks, rest_motion
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import ViewDependence, along, directions, frame_across
from scenes.sticks.prototype import PartSticks, bounds_of_all_below, box_middles, part_contrasts

_PIECES = 48  # pieces of one mesh, about as many or more

_MOST_BALLS = 200_000
"""Balls of a model, about as many at most: beyond, one ball stands for several pieces in a row."""


def imported_prototype(name: str, tree: PartTree) -> RiggedPrototype:
    """Make the prototype of a model."""
    around = directions()
    areas = projected_areas(tree.parent, tree.meshes, np.concatenate((around, np.eye(3))))
    P = np.sqrt(areas.max(axis=1))
    leaf, tints, fitted = model_appearances(tree, areas[:, : len(around)].mean(axis=1))
    rig, joint = joints_of(tree)
    tied = representative(tree.parent, P)
    position = box_middles(tree.parent, tree.meshes.vertex_owner, tree.meshes.vertices)[tied]
    origin = rig.frames()[0]
    lengths = _lengths(tree, rig, joint, position, P, tied, leaf)
    contrasts = (each[tied] for each in part_contrasts(tree.parent, leaf, tints))
    hierarchy = Hierarchy(tree.parent, tree.level, position, *lengths, *contrasts)
    local = np.concatenate((np.zeros((1, 3)), origin))
    on = joint[leaf.owner]
    sticks = RiggedSticks.on(leaf, on, on, origin)
    meshes, corner_joint = tree.meshes, joint[tree.meshes.vertex_owner]
    return RiggedPrototype(
        name=name,
        rig=rig,
        joint=joint,
        hierarchy=replace(hierarchy, overlap=fitted.overlap),
        inner=sticks.take(np.zeros(0, np.int64)),
        leaf=sticks,
        tints=tints,
        motion=motion_of(tree, rig),
        place=position - local[joint + 1],
        view_dependence=fitted.view_dependence,
        meshes=replace(meshes, vertices=meshes.vertices - local[corner_joint + 1]),
    )


def surface_balls(meshes: MeshTable) -> tuple[StickTable, Points]:
    """Make the pieces of every part's mesh, and the albedo of each piece, (k, 3).

    A ball covers on average over directions as much as its piece, half of which faces away: it does
    not matter to what is fitted that balls of one surface overlap. A triangle that is much of its
    mesh has several pieces, in a regular pattern.
    """
    area = triangle_areas(meshes.vertices, meshes.faces)
    whole = np.bincount(meshes.owner, area, len(meshes.count))[meshes.owner]
    side = np.ceil(np.sqrt(_PIECES * area / whole)).astype(np.int64)  # pieces along each edge
    face, number = expand(side * side)
    s = side[face]
    row = np.floor(np.sqrt(number)).astype(np.int64)  # the row-th strip has 2 row + 1 pieces
    place = number - row * row
    down = place % 2  # every other piece points the other way
    u = (row - place // 2 + np.where(down, -1 / 3, 1 / 3)) / s
    v = (place // 2 + np.where(down, 2 / 3, 1 / 3)) / s
    shares = np.stack((1 - u - v, u, v), axis=1)[:, :, None]
    corners = meshes.faces[face]
    points = (meshes.vertices[corners] * shares).sum(axis=1)
    albedo = (meshes.colours[corners] * shares).sum(axis=1)
    radius = np.sqrt(area[face] / (s * s) / (2 * np.pi))
    owner = meshes.owner[face]
    step = max(1, len(points) // _MOST_BALLS)
    first = np.searchsorted(owner, np.arange(len(meshes.count)))
    kept = np.flatnonzero((np.arange(len(points)) - first[owner]) % step == 0)
    points, radius, none = points[kept], radius[kept] * np.sqrt(step), np.zeros(len(kept), np.int64)
    columns = points, points, radius, radius, none
    return StickTable.of(len(meshes.count), owner[kept], *columns), albedo[kept]


Tints = Float64[np.ndarray, "t 3"]

END_STICKS = 3  # sticks of one end at most
TINTS = 24  # tints of a model at most


def model_appearances(tree: PartTree, area: Reals) -> tuple[StickTable, Tints, FittedAppearances]:
    """Fit the sticks of all n parts of a model, as it rests.

    Returns their table, their tints, and the fit for those that own parts: its view dependence is
    that of the table.

    area (n,): mean projected area over directions of all that hangs on each part [m²]
    """
    balls, albedo = surface_balls(tree.meshes)
    tints = few_tints(albedo)
    weight, every = balls.start_radius**2, np.arange(len(tints))
    own = replace(balls, tint=error_diffusion(weight, albedo, tints, every))
    fitted = fit_appearances(PartSticks(tree.parent, tree.level, own, tints, tree.meshes))
    owns = np.bincount(tree.parent[1:], minlength=len(tree)) > 0
    ends = _end_sticks(own.of_parts(~owns), albedo, tints, area[~owns])
    ends = ends.with_owner(len(tree), np.flatnonzero(~owns)[ends.owner])
    inner, views = owns[fitted.leaf.owner], fitted.view_dependence
    rows = np.concatenate((views.table_row[inner], np.full(len(ends), -1)))
    owner = np.concatenate((fitted.leaf.owner[inner], ends.owner))
    leaf = StickTable.merge([fitted.leaf.take(inner), ends])
    in_order = rows[np.argsort(owner, kind="stable")]
    by_view = ViewDependence.of_area(in_order, views.area_share)
    return leaf, tints, replace(fitted, leaf=leaf, view_dependence=by_view)


def few_tints(colours: Points) -> Tints:
    """Choose at most TINTS albedos for all of these (k, 3), in order."""
    exact = np.unique(np.round(colours, 6), axis=0)
    if len(exact) <= TINTS:
        return exact
    coded = np.rint(255 * np.sqrt(colours)).astype(np.uint8)
    picture = Image.fromarray(coded[None]).quantize(TINTS, Image.Quantize.MEDIANCUT)
    _, row = np.unique(np.asarray(picture)[0], return_inverse=True)
    count = np.bincount(row)
    return np.stack([np.bincount(row, c) / count for c in colours.T], axis=1)


def _end_sticks(balls: StickTable, albedo: Points, tints: Tints, area: np.ndarray) -> StickTable:
    """Sticks in the place of the balls of m ends, which cover these areas (m,) [m²] on average."""
    groups, group = cluster(balls, np.full(len(area), END_STICKS))
    factor = fit_radii(groups, balls.take(np.zeros(0, np.int64)), area)
    weight = balls.start_radius**2
    total = np.bincount(group, weight, len(groups.part))
    sums = [np.bincount(group, weight * c, len(total)) for c in albedo.T]
    wanted = np.stack(sums, axis=1) / total[:, None]
    tint = error_diffusion(total, wanted, tints, np.arange(len(tints)))
    return groups.table(len(area), factor, tint)


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


CELLS = 160  # of the longer side of a projected part


def projected_areas(
    parent: Ints, meshes: MeshTable, directions: Float64[np.ndarray, "d 3"]
) -> Float64[np.ndarray, "n d"]:
    """Measure the projected area of each part along each direction, (n, d) [m²].

    Seen along a direction the triangles of a part and of all below it fall on a square grid of
    points, CELLS to the longer side; the points that any covers are counted. Points fall evenly, so
    that areas are unbiased, however thin what covers them is.

    parent (n,) as in Hierarchy; meshes: of the n parts, in one frame
    """
    order, begin, end = _depth_first(parent, meshes.count)
    rows = np.concatenate(
        [np.arange(meshes.first_face[part], meshes.first_face[part + 1]) for part in order]
    )
    corners = np.ascontiguousarray(meshes.vertices[meshes.faces[rows]].reshape(-1, 3))
    return _areas(corners, begin, end, np.ascontiguousarray(directions))


def _depth_first(parent: Ints, count: Ints) -> tuple[Ints, Ints, Ints]:
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
        across, up = frame_across(directions[j])
        x, y = along(corners, across), along(corners, up)
        for i in range(n):
            a, b = 3 * begin[i], 3 * end[i]
            areas[i, j] = _covered(x[a:b], y[a:b], grid)
    return areas


@njit(cache=True)
def _covered(x, y, grid):  # type: ignore[no-untyped-def]
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


def _lengths(
    tree: PartTree, rig: Rig, joint: Ints, position: Points, P: Reals, tied: Ints, leaf: StickTable
) -> tuple[Reals, Reals, Reals, Reals]:
    origins, above_it = rig.frames()[0], rig.parent

    def farthest(row: int, other: int, points: Points, radii: Reals) -> float:
        """Bound the distance from the place of part ``row`` to spheres of part ``other`` [m].

        They are at ``points`` (k, 3) as the object rests and ride on the joint of ``other``, which
        is the part itself or hangs on it.
        """
        at, way, on = points, 0.0, int(joint[other])
        while on != joint[row]:
            origin = origins[on]
            way += float((np.linalg.norm(at - origin, axis=1) + radii).max())
            at, radii, on = origin[None], np.zeros(1), int(above_it[on])
        return way + float((np.linalg.norm(at - position[row], axis=1) + radii).max())

    n, parent, meshes = len(tree), tree.parent, tree.meshes
    own, R, separation = np.zeros(n), np.zeros(n), np.zeros(n)
    for row in range(n):
        # What the part looks like lies in spheres: corners of its mesh, ends of its sticks.
        corners = meshes.vertices[meshes.first_vertex[row] : meshes.first_vertex[row + 1]]
        sticks = slice(leaf.first[row], leaf.first[row + 1])
        radii = np.zeros(len(corners)), leaf.start_radius[sticks], leaf.end_radius[sticks]
        points = np.concatenate((corners, leaf.start[sticks], leaf.end[sticks]))
        spheres = points, np.concatenate(radii)
        own[row] = farthest(row, row, *spheres)
        R[row] = max(R[row], own[row])
        above = int(parent[row])
        if above >= 0:
            R[above] = max(R[above], farthest(above, row, *spheres))
            separation[row] = farthest(above, row, position[row][None], np.zeros(1))
    B = bounds_of_all_below(parent, own, separation)
    return max_over_tied(P, tied), max_over_tied(R, tied), B, separation
