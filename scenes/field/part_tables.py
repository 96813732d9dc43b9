"""The prototypes of one species, laid end to end in one set of arrays."""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from lod.arrays import ArrayData, FloatArray, IntArray, Ints, Reals, expand
from lod.crossfade import leaf_area_share
from lod.hierarchy import Hierarchy
from lod.kernels import njit
from lod.pruner import BlendWeights
from lod.shapes import MeshTable
from lod.threads import map_chunks
from lod.view import View
from scenes.field.thinning import Left, Thinning, at_motion
from scenes.rig.rig import RiggedSticks
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.by_view import (
    ViewDependence,
    azimuth_index,
    elevation_index,
    interpolate,
    tone_steps_at,
    with_tone_steps,
)

_SHORTEST_RUN = 16384
"""Parts for which another thread is worth its start."""

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
