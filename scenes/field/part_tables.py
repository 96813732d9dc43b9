"""The prototypes of one species, laid end to end in one set of arrays.

Which share of parts that thin out is left at a distance; what is left is so much wider.

Parts of which each stands for others like it (``Hierarchy.stands_for``) end one by one, at limit
distances of their own. At the distance d the share k(d) of them is left, fading included, and what
is left is 1/k times as wide, so that all together cover the same. No part gets wider than
``stands_for`` says: beyond that the ground takes over (``scenes.field.far_cover``).

Sticks and meshes of displayed parts, posed: carried by the joints of their parts.

The ends of sticks are where ``scenes.rig.pose.pose_points`` puts them, and their radii cover each
stick's share of its area (``lod.pruner``). Positions are float64 up to the renderer's door. A
mesh with a spine gets narrower as it fades, and wider where it stands for others like it, but no
shorter or longer; from PLAIN times its width on a single triangle of the same area has its place.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals, expand
from lod.hierarchy import Hierarchy
from lod.kernels import ONE, ZERO, map_chunks, njit
from lod.pruner import BlendWeights, leaf_area_share, radius_factor
from lod.shapes import MeshTable, Sticks, Triangles
from lod.view import View
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
from scenes.rig.rig import RiggedSticks
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import (
    ViewDependence,
    azimuth_index,
    elevation_index,
    interpolate,
    tone_steps_at,
    with_tone_steps,
)

_DISTANCES = np.geomspace(1e-4, 1.0, 384)
"""Distances at which shares are tabled, over the farthest limit distance."""

WHOLE, RIGID = -2, -1  # kinds of wholes whose parts thin out, and of what does not thin out


@dataclass(frozen=True, eq=False)
class Thinning(ArrayData):
    """Parts by kind: those of wholes whose parts are as large, which differ in their limits.

    kind (m,)   of every row of the part tables, or WHOLE or RIGID
    floor (k,)  share of each kind that is left before the last of it fades away
    area (k,)   share of the area of all kinds
    """

    kind: IntArray
    floor: FloatArray
    area: FloatArray

    @staticmethod
    def of(trees: tuple[Hierarchy, ...]) -> "Thinning | None":
        """Group the parts of hierarchies; None where none thin out."""
        thinned = [tree for tree in trees if tree.is_thinned]
        if not thinned:
            return None
        alone = np.array([(tree.P**2 / tree.stands_for).min() for tree in thinned])
        sizes, of_tree = np.unique(alone.round(12), return_inverse=True)
        most = np.zeros(len(sizes))
        np.maximum.at(most, of_tree, [tree.stands_for[0] for tree in thinned])
        kinds, numbers = [], iter(of_tree.tolist())
        for tree in trees:
            kind = next(numbers) if tree.is_thinned else RIGID
            kinds.append(np.where(tree.parent < 0, WHOLE if tree.is_thinned else RIGID, kind))
        area = sizes * np.bincount(of_tree)
        return Thinning(np.concatenate(kinds), 1 / most, area / area.sum())


@dataclass(frozen=True, eq=False)
class Left(ArrayData):
    """What is left in a view: shares (k, n) of each kind at distances (n,) [m]."""

    thinning: Thinning
    distances: FloatArray
    shares: FloatArray

    @staticmethod
    def of(thinning: Thinning, limits: Reals, fade: float) -> "Left":
        """Table what limits (m,) of all rows leave, where parts fade over a share of them."""
        farthest = float(limits[thinning.kind >= 0].max())
        shares = np.ones((len(thinning.floor), len(_DISTANCES)))
        if np.isfinite(farthest):
            for kind in range(len(shares)):
                limit = limits[thinning.kind == kind]
                past = limit - farthest * _DISTANCES[:, None]
                shares[kind] = np.clip(past / np.maximum(fade * limit, 1e-9), 0, 1).mean(axis=1)
        return Left(thinning, np.minimum(farthest, 1e30) * _DISTANCES, shares)

    def kept(self, rows: Ints, d: Reals) -> Reals:
        """Compute ``Parts.kept`` of parts in these rows at distances d [m], (n,)."""
        kinds = self.thinning.kind[rows]
        left = np.where(kinds == WHOLE, 0.0, 1.0)
        for kind, floor in enumerate(self.thinning.floor):
            own = np.flatnonzero(kinds == kind)
            left[own] = np.maximum(np.interp(d[own], self.distances, self.shares[kind]), floor)
        return left

    def missing(self, d: Reals) -> Reals:
        """Compute the share of the cover that what is left lacks at distances d [m], (n,)."""
        columns = zip(self.thinning.area, self.shares / self.thinning.floor[:, None], strict=True)
        covered = [a * np.interp(d, self.distances, np.minimum(s, 1.0)) for a, s in columns]
        return np.maximum(1.0 - np.sum(covered, axis=0), 0.0)


def at_motion(motion: Reals, at_step: Callable[[int, Ints], Reals]) -> Reals:
    """Interpolate what is known of rows at whole steps of motion to the step of each, (n,)."""
    low, found = motion.astype(np.int64), np.empty(len(motion))
    for step in np.unique(low).tolist():
        rows = np.flatnonzero(low == step)
        share = motion[rows] - step
        found[rows] = at_step(step, rows)
        if share.any():
            found[rows] += share * (at_step(step + 1, rows) - found[rows])
    return found


_SHORTEST_RUN = 16384  # parts for which another thread is worth its start
_GOLDEN = (math.sqrt(5) - 1) / 2  # multiples of it fall evenly on 0 to 1 (Weyl)


@dataclass(frozen=True, eq=False)
class PartTables(ArrayData):
    """Rows are the parts of all prototypes, one prototype after the other.

    root (v,) row of each prototype's whole object; bound, level, share, overlap as in Hierarchy
    joint, origin  a part's origin is the point ``origin`` (m, 3) in the frame of its joint (m,)
    rest (m, 3)    the same in the object's own frame, as the object stands [m]
    part_count, first_part, order: the parts of row i are order[first_part[i] :][: part_count[i]]
    sticks         both appearances; those of row i, inner then leaf, begin at first[2 i] and
                   first[2 i + 1]
    view_dependence  tables of the sticks that look otherwise from elsewhere; their darker tones
                   follow their own
    meshes         of the parts that are shown as meshes and have no leaf sticks here, each in the
                   frame of its part's joint; None where there are none
    thinning       of the parts that thin out; None where none do
    """

    hierarchies: tuple[Hierarchy, ...]
    root: IntArray
    joint: IntArray
    origin: FloatArray
    rest: FloatArray
    bound: FloatArray
    level: IntArray
    share: FloatArray
    overlap: FloatArray
    part_count: IntArray
    first_part: IntArray
    order: IntArray
    sticks: RiggedSticks
    tints: FloatArray
    view_dependence: ViewDependence
    meshes: MeshTable | None
    thinning: Thinning | None

    @staticmethod
    def of(prototypes: tuple[RiggedPrototype, ...]) -> "PartTables":
        """Lay the prototypes end to end."""
        trees = tuple(prototype.hierarchy for prototype in prototypes)
        root = np.cumsum([0] + [len(tree) for tree in trees])[:-1]
        order_start = np.cumsum([0] + [len(tree) - 1 for tree in trees])[:-1]
        joint = np.concatenate([prototype.joint for prototype in prototypes])
        rest = np.concatenate([tree.position for tree in trees])
        pairs = list(zip(trees, order_start, root, strict=True))
        sticks, tints, view_dependence = _appearances(prototypes)
        names = {"bound": "B"} | {k: k for k in ("level", "share", "overlap", "part_count")}
        columns = {k: np.concatenate([getattr(t, own) for t in trees]) for k, own in names.items()}
        meshes = None
        if any(each.meshes is not None for each in prototypes):
            empty = (MeshTable.of([None] * len(each.joint)) for each in prototypes)
            own = [p.meshes or none for p, none in zip(prototypes, empty, strict=True)]
            meshes = MeshTable.concatenate(own)
        return PartTables(
            hierarchies=trees,
            root=root,
            joint=joint,
            origin=np.concatenate([prototype.place for prototype in prototypes]),
            rest=rest,
            **columns,
            first_part=np.concatenate([tree.first_part + start for tree, start, _ in pairs]),
            order=np.concatenate([tree.order + row for tree, _, row in pairs]),
            sticks=sticks,
            tints=tints,
            view_dependence=view_dependence,
            meshes=meshes,
            thinning=Thinning.of(trees),
        )

    def limits(self, view: View, motion_step: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Compute the clamped limit distances of every row, in view and out of it, (m,) each [m].

        motion_step: how much motion hides, a whole step on the scale of lod.motion
        """
        return _limits(self, view, motion_step)

    def limits_by_motion(self, view: View, max_step: float) -> np.ndarray:
        """Compute the limits of every row at whole steps of motion, (steps, m, 2) [m].

        They are those in view and out of it, at each step up to the next after ``max_step``.
        Between two steps limits lie on the straight line: still clamped, and in clear air never
        below their own, for D is convex in m.
        """
        steps = range(1 if max_step == 0 else int(max_step) + 2)
        return np.stack([np.stack(self.limits(view, step), axis=1) for step in steps])

    def kept(self, rows: Ints, d: Reals, view: View, motion: Reals) -> Reals | None:
        """Compute ``Parts.kept`` of parts in these rows at distances d and steps of motion (n,)."""
        if self.thinning is None:
            return None
        return at_motion(motion, lambda step, k: _left(self, view, step).kept(rows[k], d[k]))

    def missing_cover(self, d: Reals, view: View, motion: Reals) -> Reals:
        """Compute what parts that thin out lack of their cover at distances d [m], (n,)."""
        return at_motion(motion, lambda step, k: _left(self, view, step).missing(d[k]))

    def parts_of(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the row of each part that ``rows`` own, and which of them owns it."""
        whole, offset = expand(self.part_count[rows])
        return whole, self.order[self.first_part[rows][whole] + offset]

    def sticks_of(self, rows: np.ndarray, weights: BlendWeights) -> "DisplayedSticks":
        """Return the displayed sticks of the parts in these rows, in their order."""
        views, table = self.view_dependence, self.sticks
        tables = views.table_row, views.area_share, views.tone_steps
        angles = weights.sin_elevation, weights.cos_azimuth
        asked = rows, weights.inner, weights.leaf, *angles, weights.hidden_area

        def count(first: int, last: int) -> tuple[int, int]:
            return first, _count(table.first, *(each[first:last] for each in asked[:3]))

        starts, counts = zip(*map_chunks(count, len(rows), _SHORTEST_RUN), strict=True)
        *begins, total = np.cumsum((0, *counts)).tolist()
        begin = dict(zip(starts, begins, strict=True))
        kinds = np.int64, np.int64, np.float64, np.int64
        found = DisplayedSticks(*(np.empty(total, kind) for kind in kinds))

        def fill(first: int, last: int) -> None:
            own, out = [each[first:last] for each in asked], [c[begin[first] :] for c in found]
            known = table.first, table.tint, tables, self.overlap
            _sticks_of(*known, first, own[0], tuple(own[1:]), tuple(out))

        map_chunks(fill, len(rows), _SHORTEST_RUN)
        return found


class DisplayedSticks(NamedTuple):
    """Displayed sticks of some parts, (k,).

    owner  number of the part among those that were asked for; stick: its row in the stick table
    share  of its area that is displayed; tint: row of ``PartTables.tints``
    """

    owner: np.ndarray
    stick: np.ndarray
    share: np.ndarray
    tint: np.ndarray


@lru_cache(maxsize=16)
def _left(part_tables: PartTables, view: View, motion_step: int) -> Left:
    if part_tables.thinning is None:
        raise ValueError("nothing of these prototypes thins out")
    return Left.of(part_tables.thinning, _limits(part_tables, view, motion_step)[0], view.fade)


@lru_cache(maxsize=16)
def _limits(part_tables: PartTables, view: View, motion_step: int) -> tuple[np.ndarray, np.ndarray]:
    """Limits of every row; cached, as one frame asks for the same several times."""
    pairs = [view.limits(tree, motion_step) for tree in part_tables.hierarchies]
    inside, outside = (np.concatenate(side) for side in zip(*pairs, strict=True))
    for each in (inside, outside):
        each.setflags(write=False)
    return inside, outside


@njit(cache=True, nogil=True)
def _count(first, rows, inner, leaf):  # type: ignore[no-untyped-def]
    count = 0
    for i in range(len(rows)):
        for side, share in enumerate((inner[i], leaf[i])):
            block = 2 * rows[i] + side
            count += (first[block + 1] - first[block]) * (share > 0.0)
    return count


@njit(cache=True, nogil=True)
def _sticks_of(first, tints, views, overlap, begin, rows, weights, found):  # type: ignore[no-untyped-def]
    """Owner, row, share and tint of every stick of blocks 2·row and 2·row + 1, in their order;
    owners are counted from ``begin``."""
    inner, leaf, sin_elevation, cos_azimuth, hidden_area = weights
    owner, stick, shares, tint = found
    table_row, area_share, tone_steps = views
    k = 0
    for i in range(len(rows)):
        aloft = high = around = -2.0  # not looked up yet
        blended = leaf[i]
        if 0.0 < hidden_area[i] < 1.0:
            blended *= leaf_area_share(hidden_area[i], overlap[rows[i]]) / hidden_area[i]
        for side, share in enumerate((inner[i], blended)):
            block = 2 * rows[i] + side
            if share > 0.0:
                for row in range(first[block], first[block + 1]):
                    owner[k], stick[k], shares[k], tint[k] = begin + i, row, share, tints[row]
                    c = table_row[row]
                    if c >= 0:
                        if aloft == -2.0:
                            aloft = elevation_index(abs(sin_elevation[i]))
                            high = elevation_index(max(sin_elevation[i], 0.0))
                            around = azimuth_index(cos_azimuth[i])
                        shares[k] *= interpolate(area_share[c], aloft)
                        # Between two tones some sticks have one and some the other.
                        down = tone_steps_at(tone_steps[c], high, around)
                        tint[k] += int(down + row * _GOLDEN % 1.0)
                    k += 1


def _appearances(
    prototypes: tuple[RiggedPrototype, ...],
) -> tuple[RiggedSticks, np.ndarray, ViewDependence]:
    """Inner and leaf sticks of all prototypes, interleaved part by part, their palette, and their
    view dependence."""
    palettes = np.concatenate([p.tints for p in prototypes])
    tints, tint_row = np.unique(palettes, axis=0, return_inverse=True)
    tint_start = np.cumsum([0] + [len(p.tints) for p in prototypes])[:-1]
    tables, block, parts = [], [], 0
    for prototype, start in zip(prototypes, tint_start, strict=True):
        inner = prototype.inner
        if prototype.hierarchy.is_thinned:
            inner = inner.only(np.zeros(len(inner.count), np.bool_))
        for is_leaf, table in enumerate((inner, _shown(prototype)[0])):
            tables.append(replace(table, tint=tint_row.ravel()[start + table.tint]))
            block.append(2 * (parts + table.owner) + is_leaf)
        parts += len(prototype.hierarchy)
    blocks = np.concatenate(block)
    columns = map(np.concatenate, zip(*(table.columns for table in tables), strict=True))
    sticks = RiggedSticks.of(2 * parts, blocks, *columns)
    pairs = [each for p in prototypes for each in (ViewDependence(), _shown(p)[1])]
    views = ViewDependence.concatenate(pairs, [len(table) for table in tables])
    views = replace(views, table_row=views.table_row[np.argsort(blocks, kind="stable")])
    tint, tints = with_tone_steps(sticks.tint, tints, views)
    return replace(sticks, tint=tint), tints, views


def _shown(prototype: RiggedPrototype) -> tuple[RiggedSticks, ViewDependence]:
    leaf, views = prototype.leaf, prototype.view_dependence
    if prototype.meshes is None and not prototype.hierarchy.is_thinned:
        return leaf, views
    shown = leaf.owner >= int(prototype.hierarchy.is_thinned)
    if prototype.meshes is not None:
        shown &= prototype.meshes.count[leaf.owner] == 0
    rows = views.rows(len(leaf))[shown]
    return leaf.take(shown), replace(views, table_row=rows) if len(views.table_row) else views


PLAIN = 4.0  # how much wider a mesh stands for so many like it that its bends are not seen

TONE = 0.03
"""Power of how much wider a mesh is by which it gets darker. Few wide blades shade one another, and
the ground, less evenly than many narrow ones: in a stand on hills, under suns of 10°, 40° and 70°,
they were 3 % too bright where 5 times as wide, and 5 to 7 % where 20 times."""

_SHORTEST_STICK_RUN = 8192  # sticks for which another thread is worth its start


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

    map_chunks(run, n, _SHORTEST_STICK_RUN)
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
        for start in range(first, last, _SHORTEST_STICK_RUN):
            own = slice(start, min(start + _SHORTEST_STICK_RUN, last))
            joints = part_tables.joint[part[own]]
            frames = _joint_frames(pose_tables, instances, objects[rows[own]], joints)
            begin = first_vertex[own], first_face[own]
            asked = rows[own], part[own], share[rows[own]]
            _emit_meshes(asked, frames, table, begin, (*points, faces, owner))

    map_chunks(run, len(rows), _SHORTEST_STICK_RUN)
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
