"""Trees in the wind: smooth, each in its own way, within their limits in every pose."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from lod.crossfade import blend_weights
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import Placed, Species, SpeciesField
from scenes.model_files.names import tree_species_names
from scenes.models.catalogue import model_prototypes
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.sway import swaying_trees
from scenes.models.trees.tree import tree_prototypes
from scenes.models.trees.weather import Weather
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.rig.rotations import from_euler
from scenes.sticks.prototype import Prototype
from tests.scenes.rig.motion_phase import at_phase

KINDS = list(tree_species_names())


class Plain:
    """Flat ground."""

    def height(self, corner, xy):
        return np.zeros(len(xy))

    def bounds(self):
        return 0.0, 0.0


@lru_cache(maxsize=16)
def pair(name, wind=10.0):
    """The tree that stands still, and the same in the wind."""
    species = tree_species(name)
    still = tree_prototypes(3, 1, species)[0]
    return still, swaying_trees(3, 1, species, "summer", wind)[0]


def poses(tree, count=6):
    """Allowed poses: random ones, and every joint at its limit."""
    rng = np.random.default_rng(1)
    low, high = tree.rig.low, tree.rig.high
    corners = [np.where(rng.random(low.shape) < 0.5, low, high) for _ in range(count)]
    return [*tree.rig.random_turns(rng, count), *map(from_euler, (low, high, *corners))]


def test_without_wind_there_are_no_joints():
    (tree,) = model_prototypes("tree", 1, (1.0,), False, Weather("summer", 0.0))
    assert isinstance(tree, Prototype)
    (tree,) = model_prototypes("tree", 1, (1.0,), False, Weather("summer", 5.0))
    assert isinstance(tree, RiggedPrototype)


@pytest.mark.parametrize("name", KINDS)
def test_at_rest_it_is_the_tree_that_stands_still(name):
    still, sways = pair(name)
    rest = sways.posed()
    assert rest.hierarchy.position == pytest.approx(still.hierarchy.position, abs=1e-12)
    for mine, its in ((rest.inner, still.inner), (rest.leaf, still.leaf)):
        assert mine.start == pytest.approx(its.start, abs=1e-12)
        assert mine.end == pytest.approx(its.end, abs=1e-12)


@pytest.mark.parametrize("name", KINDS)
def test_only_the_whole_reaches_farther(name):
    still, sways = (each.hierarchy for each in pair(name))
    assert np.array_equal(still.P, sways.P)
    assert np.array_equal(still.R[1:], sways.R[1:])
    assert np.array_equal(still.B[1:], sways.B[1:])
    assert 1.0 < sways.R[0] / still.R[0] < 1.1
    more = sways.separation - still.separation
    assert (more >= 0).all()
    assert (more[still.level != 1] == 0).all()


@pytest.mark.parametrize("name", KINDS)
def test_everything_is_within_its_limits_in_every_pose(name):
    _, sways = pair(name, 20.0)
    h = sways.hierarchy
    for turns in poses(sways):
        p = sways.posed(turns)
        at = p.hierarchy.position
        apart = np.linalg.norm(at[1:] - at[h.parent[1:]], axis=1)
        assert (apart <= h.separation[1:] * (1 + 1e-9) + 1e-9).all()
        for table in (p.inner, p.leaf):
            for ends, r in ((table.start, table.start_radius), (table.end, table.end_radius)):
                seen, reach = table.owner, h.R
                for direct in (False, True):  # its own sticks, then those of its direct parts
                    rows = np.flatnonzero(seen >= 0)
                    far = np.linalg.norm(ends[rows] - at[seen[rows]], axis=1) + r[rows]
                    assert (far <= reach[seen[rows]] * (1 + 1e-9)).all(), direct
                    seen = np.where(seen >= 0, h.parent[seen], -1)
                far = np.linalg.norm(ends - at[0], axis=1) + r
                assert (far <= h.B[0]).all()


def test_p_holds_in_every_pose():
    """The largest cross-section drawn, over directions some 10° apart, which a pose turns."""
    from scenes.sticks.view_dependent_area import largest_area_in_view

    _, sways = pair("shrub", 20.0)
    for turns in poses(sways, 1):
        posed = sways.leaf.posed(*sways.rig.frames(turns))
        areas = largest_area_in_view(posed, sways.view_dependence)
        assert (np.sqrt(areas) <= sways.hierarchy.P * 1.02).all()


@pytest.mark.parametrize("name", ["tree", "shrub"])
def test_it_moves_smoothly_and_comes_back(name):
    _, sways = pair(name)
    period, fps = sways.motion.period, 24.0
    times = np.arange(int(period * fps) + 1) / fps
    tip = sways.hierarchy.position[:, 2].argmax()
    path = np.array([at_phase(sways, t / period).hierarchy.position[tip] for t in times[:120]])
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    jerk = np.linalg.norm(np.diff(path, 2, axis=0), axis=1)
    assert np.ptp(path, axis=0).max() > 0.02 * sways.hierarchy.position[tip, 2]
    assert step.max() < 0.2 * np.ptp(path, axis=0).max()
    assert jerk.max() < 0.3 * step.max()
    ends = (at_phase(sways, phase).hierarchy.position[tip] for phase in (0.0, 1.0 - 1e-9))
    assert next(ends) == pytest.approx(next(ends), abs=1e-6)


def test_it_grows_with_the_square_of_the_wind():
    def farthest(wind):
        still, sways = pair("tree", wind)
        away = [
            np.linalg.norm(
                at_phase(sways, phase).hierarchy.position - still.hierarchy.position, axis=1
            ).max()
            for phase in np.linspace(0, 1, 20)
        ]
        return max(away)

    assert farthest(10.0) == pytest.approx(4 * farthest(5.0), rel=0.05)
    assert 0.1 < farthest(10.0) < 0.8


def test_every_tree_has_a_phase_and_a_way_of_its_own():
    trees = swaying_trees(3, 2, tree_species("tree"), "summer", 8.0)
    assert not np.array_equal(trees[0].motion.rotations[:, 0], trees[1].motion.rotations[:, 0])
    field = SpeciesField(Species("tree", trees[:1], 2e-4), 5, Plain())
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 1.7)), 0, 0, 60.0, (200, 200))
    roots = field.roots(View(camera, METRICS["blake"], 30.0, look_around=True))
    phase = roots.state.instances.phase
    assert len(np.unique(phase)) == len(phase) > 5


def test_the_pruner_sees_it_where_it_is():
    """The compiled walk and the readable pose agree, branch by branch."""
    _, sways = pair("tree")
    tree = Placed("tree", sways, 0.0, 0.0, 90.0, Plain())
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, -12.0, 1.7)), 0, 0, 60.0, (200, 200))
    view = View(camera, METRICS["blake"], 0.2, look_around=True)
    for time in (0.0, 1.7, 100.3):
        cut = prune(tree, replace(view, time_s=time))
        parts = cut.parts
        there = at_phase(sways, time / sways.motion.period)
        assert parts.position == pytest.approx(there.hierarchy.position[parts.part], abs=1e-9)
        sticks = tree.appearance(parts, blend_weights(cut, view))
        assert sticks.start[:, 2].max() == pytest.approx(there.leaf.start[:, 2].max(), abs=0.3)


def test_sizes():
    _, sways = pair("shrub")
    double = sways.scaled(2.0)
    pose = at_phase(double, 0.3).hierarchy.position
    assert pose == pytest.approx(2 * at_phase(sways, 0.3).hierarchy.position)
