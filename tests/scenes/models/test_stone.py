"""Solids as octrees: what every level covers, what is kept, and that no light gets through."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lod.shapes import StickTable
from scenes.models.stone import (
    TINTS,
    Solid,
    boulder_prototypes,
    octree_prototype,
)
from scenes.sticks.areas import area_shares_at, directions, mean_area, with_area_share

DEPTH = 4


def ball(radius, depth=DEPTH, side=2.0, middle=(0.0, 0.0, 0.0)):
    s = 2 ** (depth + 1)
    axis = ((np.arange(s) + 0.5) / s - 0.5) * side
    xyz = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    within = np.linalg.norm(xyz - np.array(middle), axis=-1) < radius
    return Solid(within, np.full((s, s, s, 3), 0.3), np.full(3, -side / 2), side)


def level_table(prototype, level):
    """All balls of a level as one part."""
    rows = np.flatnonzero(prototype.hierarchy.level == level)
    centre, radius = prototype.leaf.start[rows], prototype.leaf.start_radius[rows]
    zero = np.zeros(len(rows), np.int64)
    return StickTable.of(1, zero, centre, centre, radius, radius, zero)


def cover(prototype, level):
    """Mean area over directions that a level covers, as it looks from each [m²]."""
    table, views = level_table(prototype, level), prototype.view_dependence
    row = views.table_row[prototype.hierarchy.level[prototype.leaf.owner] == level]
    areas = []
    for view in directions(32):
        seen = with_area_share(table, area_shares_at(views, row, abs(view[2])))
        areas.append(mean_area(seen, view[None])[0])
    return float(np.mean(areas))


@settings(max_examples=2, deadline=None)
@given(st.floats(0.6, 0.85))
def test_every_level_of_a_ball_covers_its_disc(radius):
    prototype = octree_prototype("ball", ball(radius), TINTS)
    finest = cover(prototype, DEPTH)
    assert finest == pytest.approx(np.pi * radius**2, rel=0.06)  # a voxel of 1/16 m
    for level in range(DEPTH):
        assert cover(prototype, level) == pytest.approx(finest, rel=0.05)


def test_no_light_gets_through_a_boulder():
    """Rays that pass its middle closer than half the way to its surface meet a ball."""
    (prototype,) = boulder_prototypes(0, 1)
    h = prototype.hierarchy
    middle = prototype.leaf.start[0]
    inside = 0.5 * np.linalg.norm(h.position[h.level == 6] - middle, axis=1).min()
    chance = np.random.default_rng(0)
    for level in range(7):
        table = level_table(prototype, level)
        for direction in directions(8):
            across = np.linalg.svd(direction[None])[2][1:]
            turn, far = chance.uniform(0, 2 * np.pi, 200), inside * np.sqrt(chance.random(200))
            rays = far[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
            balls = (table.start - middle) @ across.T
            away = ((rays[:, None] - balls) ** 2).sum(axis=2)
            assert (away < table.start_radius**2).any(axis=1).all(), level


def test_boulders_keep_cover_and_tone_from_level_to_level():
    prototype = boulder_prototypes(0, 1)[0]
    levels = range(int(prototype.hierarchy.level.max()) + 1)
    covers = [cover(prototype, level) for level in levels]
    assert covers == pytest.approx([covers[-1]] * len(covers), rel=0.05)
    tones = []
    for level in levels:
        rows = prototype.hierarchy.level == level
        weight = prototype.leaf.start_radius[rows] ** 2
        tones.append(np.average(prototype.tints[prototype.leaf.tint[rows]], axis=0, weights=weight))
    assert np.ptp(tones, axis=0).max() < 0.03
