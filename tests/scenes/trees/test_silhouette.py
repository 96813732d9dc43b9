"""A tree keeps its silhouette, its gaps and its colour when its parts go.

Colour is albedo here, of trees whose shapes are not darker for the shade in what they hide: that
is another fit (tests/scenes/appearance/test_tone.py).

Cuts are the pruner's own: a tree on flat ground, seen from farther and farther away; every
direction sees them as they look from there (``scenes.sticks.areas``). As long as all its
branches (level 2) are displayed, and none, some or all of what they bear, the mean cover over 32
directions stays within 5 % of the whole tree's, each direction within 15 %, mean albedo 3 %.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS, limit_distances
from lod.pruner import blend_weights, prune
from lod.shapes import StickTable, batches_of
from lod.view import View
from scenes.appearance.visible_area import first_met, visible_areas
from scenes.field.species_field import Placed
from scenes.model_files import tree_species_names
from scenes.sticks.areas import area_shares_at, directions, with_area_share
from scenes.sticks.prototype import Shapes
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes
from tests.scenes.flat_ground import FlatGround

TREES = [*((name, "summer") for name in tree_species_names()), ("birch", "winter")]
AROUND = directions(32) * np.where(np.arange(32) % 2, -1.0, 1.0)[:, None]
RAYS = 160


@lru_cache(maxsize=16)
def one(name, season):
    return tree_prototypes(2, 1, tree_species(name), season)[0]


def view_from(away, fade=0.0):
    """From ``away`` metres off, at the height of the crown."""
    camera = camera_from_heading(
        Corner(0, 0), np.array((0.8 * away, 0.6 * away, 5.0)), 0, 0, 60.0, (1000, 1000)
    )
    return View(camera, METRICS["blake"], look_around=True, fade=fade)


def displayed(p, view):
    """What is displayed of the tree, by the direction that it is seen from: its shapes, and the
    colour of each; and which of its parts."""
    tree = Placed(p.name, p, 0.0, 0.0, 0.0, FlatGround())
    cut = prune(tree, view)
    weights = blend_weights(cut, view)

    def toward(direction):
        rise = np.full(len(weights), direction[2])
        s, *flat = batches_of(tree.appearance(cut.parts, replace(weights, sin_elevation=rise)))
        columns = (s.start, s.end, s.start_radius, s.end_radius)
        sticks = StickTable(np.array([0, len(s)]), *columns, np.arange(len(s)))
        corners = [np.zeros((0, 3, 3)), *(each.vertices[each.faces] for each in flat)]
        colours = [np.zeros((0, 3)), *(each.colours[each.faces].mean(axis=1) for each in flat)]
        shown = Shapes(sticks, np.concatenate(corners), np.concatenate(colours))
        return shown, shown.albedos(s.tints[s.tint])

    return toward, np.sort(cut.parts.part)


def measured(p, view):
    """Cover in each direction [m²], and mean colour of what is seen."""
    toward, _ = displayed(p, view)
    cover, sent = [], np.zeros(3)
    for direction in AROUND:
        table, colour = toward(direction)
        area = visible_areas(table, direction[None], p.hierarchy.R[0] / RAYS)[0]
        cover.append(area.sum())
        sent += area @ colour
    return np.array(cover), sent / np.sum(cover)


def limits(p, level):
    """Limit distances of the parts of a level."""
    return limit_distances(p.hierarchy, METRICS["blake"], view_from(1.0).m)[
        p.hierarchy.level == level
    ]


def distances(p):
    """Where a third and two thirds of every level are gone, and all of it; while every
    branch is there.
    """
    last = limits(p, 2).min() - p.hierarchy.B[0]
    finest = int(p.hierarchy.level.max())
    found = [
        np.quantile(limits(p, level), share)
        for level in range(3, finest + 1)
        for share in (0.3, 0.7, 1.0)
    ]
    return sorted({round(min(1.01 * d, last), 1) for d in found})


@pytest.mark.parametrize(("name", "season"), TREES)
def test_silhouette_and_colour_hold_while_every_branch_is_there(name, season):
    p = one(name, season)
    cover, colour = measured(p, view_from(0.1))
    assert len(displayed(p, view_from(0.1))[1]) == len(p.hierarchy)
    for number, away in enumerate(distances(p)):
        view = view_from(away, 0.2 * (number % 2))
        parts = displayed(p, view)[1]
        assert np.isin(np.flatnonzero(p.hierarchy.level <= 2), parts).all()
        there, its_colour = measured(p, view)
        where = (away, view.fade, len(parts))
        assert there.mean() == pytest.approx(cover.mean(), rel=0.05), where
        assert np.abs(there / cover - 1).max() < 0.15, where
        assert np.linalg.norm(its_colour - colour) < 0.03 * np.linalg.norm(colour), where


@pytest.mark.parametrize(("name", "season"), TREES)
def test_no_distance_erodes_it(name, season):
    """Down to the last shapes, where branches and limbs go too, the mean cover stays near."""
    p = one(name, season)
    cover, _ = measured(p, view_from(0.1))
    for away in np.geomspace(limits(p, 2).min(), 0.99 * limits(p, 0).max(), 5):
        there, _ = measured(p, view_from(away))
        assert there.mean() == pytest.approx(cover.mean(), rel=0.15), away


@pytest.mark.parametrize("name", tree_species_names())
def test_boughs_are_as_flat_as_what_they_hide(name):
    """Every part of a depth displayed, and none below: cover from each height over the tree's own,
    about their mean (round blobs end to end would give a conifer a fifth more from the side than
    from above)."""
    p = one(name, "summer")
    finest = int(p.hierarchy.level.max())
    own, *cuts = (_from_heights(p, k) for k in range(finest, 0, -1))
    for cover in cuts:
        assert cover / own == pytest.approx((cover / own).mean(), rel=0.06)


@pytest.mark.parametrize("name", ["conifer", "tree", "birch", "shrub"])
def test_the_last_shapes_cover_as_much_from_every_height(name):
    """The whole as one part: cover from each height over the own, about their mean (round shapes
    of a conifer would give 1.17 from the side and 0.92 from 40°)."""
    p = one(name, "summer")
    own, cover = (_from_heights(p, k) for k in (int(p.hierarchy.level.max()), 0))
    assert cover / own == pytest.approx((cover / own).mean(), rel=0.04)


def _down_to(p, depth, height):
    """All parts down to a depth as they look from a height, as one table of sticks."""
    level, views = p.hierarchy.level, p.view_dependence
    shares = area_shares_at(views, views.rows(len(p.leaf)), height)
    leaf = with_area_share(p.leaf, shares)
    pairs = (p.inner, level[p.inner.owner] < depth), (leaf, level[leaf.owner] == depth)
    names = ("start", "end", "start_radius", "end_radius", "tint")
    columns = [np.concatenate([getattr(t, name)[row] for t, row in pairs]) for name in names]
    return StickTable(np.array([0, len(columns[-1])]), *columns)


def _from_heights(p, depth):
    """Mean cover over eight sides from each of five heights, of all parts down to a depth [m²]."""
    found, side = [], np.arange(8) * np.pi / 4 + 0.2
    for height in (0.05, 0.3, 0.55, 0.8, 0.97):
        level = np.sqrt(1 - height**2)
        views = np.stack((level * np.cos(side), level * np.sin(side), np.full(8, height)), axis=1)
        table = _down_to(p, depth, height)
        found.append(visible_areas(table, views, p.hierarchy.R[0] / RAYS).sum() / 8)
    return np.array(found)


@pytest.mark.parametrize(("name", "season"), TREES)
def test_crowns_let_as_much_light_through_and_in_as_many_places(name, season):
    """The gap fraction in squares a tenth of the crown wide, branches against the whole tree: a
    lump would have none, and neither may gaps gather in one place.
    """
    p = one(name, season)
    spacing = p.hierarchy.R[0] / 300
    near, _ = displayed(p, view_from(0.1))
    far, parts = displayed(p, view_from(limits(p, 2).min() - p.hierarchy.B[0]))
    assert p.hierarchy.level[parts].max() <= 3
    for direction in AROUND[::4]:
        tables = near(direction)[0], far(direction)[0]
        fine, coarse = (_gaps(first_met(t, direction, spacing, 300)) for t in tables)
        crown = (fine < 0.9) & (coarse < 1)
        weight = crown.sum()
        assert weight > 8
        assert fine[crown].mean() == pytest.approx(coarse[crown].mean(), abs=0.06)
        # Squares with a lump would be shut where the whole tree's are open.
        shut = (coarse < 0.02) & (fine > 0.35)
        assert shut.sum() < 0.05 * weight


def _gaps(seen):
    """Share of rays that pass in each square of 30 by 30."""
    return (seen < 0).reshape(20, 30, 20, 30).mean(axis=(1, 3))
