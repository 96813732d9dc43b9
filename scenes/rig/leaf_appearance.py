"""How leaf appearances are fitted to what they hide, and cores of parts without a body (§2.4)."""

import numpy as np

from lod.arrays import Ints, Reals
from lod.stick_table import StickTable
from scenes.rig.anatomy import Colour
from scenes.rig.rig import Rig, RiggedSticks
from scenes.sticks.outline_area import mean_area, mean_outline_areas

CORE = 0.75
"""Radius of the hidden core, as a share of the leaf appearance's."""

_COLUMNS = ("start", "end", "start_radius", "end_radius", "tint", "start_joint", "end_joint")


def group_by_owner(owner: Ints, columns: list[np.ndarray], n: int) -> RiggedSticks:
    """The table of sticks given in any order, sorted by owner; columns as in RiggedSticks."""
    order = np.argsort(owner, kind="stable")
    first = np.concatenate(([0], np.cumsum(np.bincount(owner, minlength=n))))
    return RiggedSticks(first, *(column[order] for column in columns))


def select_sticks(table: RiggedSticks | None, stick: Ints, owner: Ints, n: int) -> RiggedSticks:
    """The sticks at rows ``stick`` with owners ``owner``; an empty table where there is none."""
    if table is None:
        empty = (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
        return RiggedSticks(np.zeros(n + 1, np.int64), *empty, *(stick,) * 3)
    return group_by_owner(owner, [getattr(table, name)[stick] for name in _COLUMNS], n)


def sticks_below(parent: Ints, body: StickTable) -> StickTable:
    """The sticks of every part's own body and of all parts below it, at rest."""
    owner, stick = body.owner, np.arange(len(body))
    owners, sticks = [], []
    while len(owner):
        owners.append(owner)
        sticks.append(stick)
        above = parent[owner]
        owner, stick = above[above >= 0], stick[above >= 0]
    rows = np.concatenate(sticks)
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = (getattr(body, name)[rows] for name in names)
    return StickTable.of(len(parent), np.concatenate(owners), *columns)


def fit_leaf_appearances(
    rig: Rig,
    body: RiggedSticks,
    given: RiggedSticks,
    full: StickTable,
    materials: dict[str, Colour],
) -> tuple[RiggedSticks, np.ndarray]:
    """Leaf appearances of all parts, and the palette (t, 3) with the mean tint as its last row.

    given: sticks chosen for some parts, whose radii are fitted so that their mean area over
        directions is that of everything they hide (``full``); other parts look as their bodies do.
        The whole object without any is one upright stick of the mean tint.
    """
    n = len(full.first) - 1
    palette = np.array(list(materials.values()))
    own = slice(full.first[0], full.first[1])
    weight = mean_outline_areas(full)[own]
    mean = (weight[:, None] * palette[full.tint[own]]).sum(axis=0) / weight.sum()
    target = mean_area(full)
    if given.first[1] == 0:
        given = concatenate(n, (_upright_stick(full, float(target[0]), len(palette)), given))
    fitted = _fit_radii(rig, given, target)
    given_count = np.bincount(given.owner, minlength=n)
    plain = np.flatnonzero(given_count[body.owner] == 0)
    leaf = concatenate(n, (fitted, select_sticks(body, plain, body.owner[plain], n)))
    return leaf, np.concatenate((palette, mean[None]))


def _upright_stick(full: StickTable, area: float, tint: int) -> RiggedSticks:
    """The whole as one upright stick of that mean area: for radius r and height h it is π·r·h/2."""
    own = slice(full.first[0], full.first[1])
    tops = (full.start[own, 2] + full.start_radius[own], full.end[own, 2] + full.end_radius[own])
    height = max(float(top.max()) for top in tops)
    radius = 2 * area / (np.pi * height)
    first = np.ones(len(full.first), np.int64)
    first[0] = 0
    ends = np.array(((0.0, 0.0, radius),)), np.array(((0.0, 0.0, height - radius),))
    none = np.array([-1])
    radii = np.array([radius])
    return RiggedSticks(first, *ends, radii, radii, np.array([tint]), none, none)


def concatenate(n: int, tables: tuple[RiggedSticks, ...]) -> RiggedSticks:
    """One table of the sticks of several tables of the same n parts."""
    owner = np.concatenate([table.owner for table in tables])
    return group_by_owner(
        owner, [np.concatenate([getattr(t, name) for t in tables]) for name in _COLUMNS], n
    )


def _fit_radii(rig: Rig, given: RiggedSticks, target: Reals, rounds: int = 4) -> RiggedSticks:
    """Sticks with radii scaled part by part, so that mean areas at rest are the targets [m²]."""
    rows = np.flatnonzero(np.bincount(given.owner, minlength=len(target)))
    factor = np.ones(len(target))
    frames = rig.frames()
    for _ in range(rounds):
        area = mean_area(_scale_radii(given, factor).posed(*frames))
        # Area is almost in proportion to the radius of a slender stick: this converges.
        factor[rows] *= target[rows] / area[rows]
    return _scale_radii(given, factor)


def _scale_radii(table: RiggedSticks, factor: Reals) -> RiggedSticks:
    scale = factor[table.owner]
    radii = table.start_radius * scale, table.end_radius * scale
    joints = (table.tint, table.start_joint, table.end_joint)
    return RiggedSticks(table.first, table.start, table.end, *radii, *joints)


def inner_appearances(
    parent: Ints, body: RiggedSticks, leaf: RiggedSticks, given: RiggedSticks
) -> RiggedSticks:
    """Inner appearances: the bodies of parts that own parts, and cores where there is no body.

    given: cores chosen for some parts; elsewhere the core is the leaf appearance, thinned. The
        whole object has no core unless one is given.
    """
    n = len(parent)
    owns = np.zeros(n, bool)
    owns[parent[parent >= 0]] = True
    kept = np.flatnonzero(owns[body.owner])
    bare = [np.bincount(table.owner, minlength=n) == 0 for table in (body, given)]
    cores = owns & bare[0] & bare[1]
    cores[0] = False
    core = np.flatnonzero(cores[leaf.owner])
    thin = _scale_radii(leaf, np.full(n, CORE))
    pieces = (
        select_sticks(body, kept, body.owner[kept], n),
        select_sticks(thin, core, leaf.owner[core], n),
    )
    return concatenate(n, (*pieces, given))
