"""How leaf appearances are fitted to what they hide, and cores of parts without a body (§2.4)."""

import numpy as np

from lod.arrays import Ints, Reals
from lod.shapes import StickTable
from scenes.rig.anatomy import Colour
from scenes.rig.rig import Rig, RiggedSticks
from scenes.sticks.outline_area import mean_area, mean_outline_areas

CORE = 0.75
"""Radius of the hidden core, as a share of the leaf appearance's."""


def sticks_below(parent: Ints, body: StickTable) -> StickTable:
    """Collect the sticks of every part's own body and of all parts below it, at rest."""
    owner, stick = body.owner, np.arange(len(body))
    owners, sticks = [], []
    while len(owner):
        owners.append(owner)
        sticks.append(stick)
        above = parent[owner]
        owner, stick = above[above >= 0], stick[above >= 0]
    rows = np.concatenate(sticks)
    columns = (column[rows] for column in body.columns)
    return StickTable.of(len(parent), np.concatenate(owners), *columns)


def fit_leaf_appearances(
    rig: Rig,
    body: RiggedSticks,
    given: RiggedSticks,
    full: StickTable,
    materials: dict[str, Colour],
) -> tuple[RiggedSticks, np.ndarray]:
    """Fit the leaf appearances of all parts; the palette (t, 3) gets the mean tint as its last row.

    given: sticks chosen for some parts, whose radii are fitted so that their mean area over
        directions is that of everything they hide (``full``); other parts look as their bodies do.
        The whole object without any is one upright stick of the mean tint.
    """
    palette = np.array(list(materials.values()))
    own = slice(full.first[0], full.first[1])
    weight = mean_outline_areas(full)[own]
    mean = (weight[:, None] * palette[full.tint[own]]).sum(axis=0) / weight.sum()
    target = mean_area(full)
    if given.first[1] == 0:
        given = RiggedSticks.merge((_upright_stick(full, float(target[0]), len(palette)), given))
    leaf = RiggedSticks.merge((_fit_radii(rig, given, target), body.only(given.count == 0)))
    return leaf, np.concatenate((palette, mean[None]))


def _upright_stick(full: StickTable, area: float, tint: int) -> RiggedSticks:
    """Make the whole one upright stick of mean area π·r·h/2, of radius r and height h."""
    own = slice(full.first[0], full.first[1])
    tops = (full.start[own, 2] + full.start_radius[own], full.end[own, 2] + full.end_radius[own])
    height = max(float(top.max()) for top in tops)
    radius = 2 * area / (np.pi * height)
    ends = np.array(((0.0, 0.0, radius),)), np.array(((0.0, 0.0, height - radius),))
    radii, none = np.array([radius]), np.array([-1])
    owner, tints = np.zeros(1, np.int64), np.array([tint])
    return RiggedSticks.of(len(full.count), owner, *ends, radii, radii, tints, none, none)


def _fit_radii(rig: Rig, given: RiggedSticks, target: Reals, rounds: int = 4) -> RiggedSticks:
    """Scale the radii of sticks part by part, so that mean areas at rest are the targets [m²]."""
    rows = np.flatnonzero(given.count)
    factor = np.ones(len(target))
    frames = rig.frames()
    for _ in range(rounds):
        area = mean_area(given.thickened(factor[given.owner]).posed(*frames))
        # Area is almost in proportion to the radius of a slender stick: this converges.
        factor[rows] *= target[rows] / area[rows]
    return given.thickened(factor[given.owner])


def inner_appearances(
    parent: Ints, body: RiggedSticks, leaf: RiggedSticks, given: RiggedSticks
) -> RiggedSticks:
    """Choose the inner appearances: bodies of parts that own parts, and cores where there is none.

    ``given`` holds cores chosen for some parts; elsewhere the core is the leaf appearance, thinned.
    The whole object has no core unless one is given.
    """
    owns = np.zeros(len(parent), bool)
    owns[parent[parent >= 0]] = True
    cores = owns & (body.count == 0) & (given.count == 0)
    cores[0] = False
    core = leaf.only(cores)
    return RiggedSticks.merge((body.only(owns), core.thickened(np.full(len(core), CORE)), given))
