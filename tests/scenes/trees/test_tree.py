"""Trees: branches on branches, leaves one by one, each kind as its seasons have it.

Trees in the wind: smooth, each in its own way, within their limits in every pose.

A species of tree is one TOML file, and what is wrong in it is said.
"""

import shutil
from dataclasses import replace
from functools import lru_cache
from importlib import resources
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from lod.errors import InputError
from scenes.appearance.visible_area import visible_areas
from scenes.model_files import tree_species_names
from scenes.models.catalogue import model_prototypes
from scenes.rig.rig import from_euler
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import directions, mean_outline_areas
from scenes.sticks.prototype import Prototype, Shapes
from scenes.trees.species import SEASONS, Weather, read_species, tree_species
from scenes.trees.tree import grow_tree, swaying_trees, tree_prototypes
from tests.scenes.figures.motion_phase import at_phase


@lru_cache(maxsize=8)
def tree(name):
    return tree_prototypes(1, 1, tree_species(name))[0]


@pytest.fixture(params=tree_species_names())
def kind(request):
    return request.param


class TestHierarchy:
    def test_size_and_levels(self, kind):
        p = tree(kind)
        count = np.bincount(p.hierarchy.level)
        species = tree_species(kind)
        assert len(count) == len(species.levels) + 1 + (species.foliage is not None)
        assert (np.diff(count) > 0).all()
        assert 150 < len(p.hierarchy) < 8000

    def test_every_branch_grows_out_of_its_whole(self, kind):
        """Its base lies on the chain of the branch that owns it."""
        p = tree(kind)
        h = p.hierarchy
        branches = (h.level >= 1) & (h.level <= len(tree_species(kind).levels))
        for row in np.flatnonzero(branches)[::13]:
            whole = h.parent[row]
            block = slice(p.inner.first[whole], p.inner.first[whole + 1])
            a, b = p.inner.start[block], p.inner.end[block]
            along = ((h.position[row] - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1)
            near = a + np.clip(along, 0, 1)[:, None] * (b - a)
            assert np.linalg.norm(near - h.position[row], axis=1).min() < 1e-9

    def test_branches_are_thinner_than_what_bears_them(self, kind):
        levels = grow_tree(tree_species(kind), 1, 0).levels
        for above, level in pairwise(levels):
            assert (level.radii[:, 0] <= above.radii[level.parent].max(axis=1)).all()
            assert (np.diff(level.radii, axis=1) <= 1e-12).all()


class TestStanding:
    def test_foot_is_below_the_ground(self, kind):
        p = tree(kind)
        trunk = slice(p.inner.first[0], p.inner.first[1])
        assert p.inner.start[trunk][0, 2] == pytest.approx(-tree_species(kind).trunk.root_depth)
        assert p.inner.start[trunk][1] == pytest.approx(0)


@pytest.mark.parametrize("name", ["tree", "shrub"])
class TestFlatLeaves:
    """They are drawn, and the cones counted: alike in cover, and within the cones' limits."""

    def test_they_cover_what_the_cones_do(self, name):
        p = tree(name)
        leaves = np.flatnonzero(p.has_mesh)
        assert np.array_equal(leaves, np.flatnonzero(p.hierarchy.level == p.hierarchy.level.max()))
        spread = directions(64)
        for leaf in leaves[:: len(leaves) // 8]:
            only = np.arange(len(p.hierarchy)) == leaf
            flat = Shapes.of(p.leaf.only(only & False), p.meshes.only(only))
            seen = visible_areas(flat, spread, 2e-3).sum(axis=1).mean()
            assert seen == pytest.approx(mean_outline_areas(p.leaf.only(only))[0], rel=0.03)

    def test_they_reach_no_farther_and_face_as_they_lie(self, name):
        p = tree(name)
        h, meshes = p.hierarchy, p.meshes
        leaf = meshes.vertex_owner
        for whole in (leaf, h.parent[leaf]):
            far = np.linalg.norm(meshes.vertices - h.position[whole], axis=1)
            assert (far <= h.R[whole] * (1 + 1e-9)).all()
        a, b, c = (meshes.vertices[meshes.faces[:, k]] for k in range(3))
        ahead = np.cross(b - a, c - a)[:, None] * meshes.normals[meshes.faces]
        assert (ahead.sum(axis=2) > 0).all()


class TestSeasons:
    def test_the_wood_is_the_same_all_year(self):
        for species in map(tree_species, ("tree", "conifer")):
            every = [grow_tree(species, 1, 0, season) for season in SEASONS]
            for one in every[1:]:
                for a, b in zip(every[0].levels, one.levels, strict=True):
                    assert np.array_equal(a.nodes, b.nodes)

    def test_only_evergreens_have_leaves_in_winter(self):
        trees = {
            name: grow_tree(tree_species(name), 1, 0, "winter") for name in tree_species_names()
        }
        assert [name for name, it in trees.items() if len(it.foliage.twig)] == ["conifer"]
        for season in SEASONS:
            assert not len(grow_tree(tree_species("dead_tree"), 1, 0, season).foliage.twig)

    def test_leaves_are_green_in_summer_and_turn_in_autumn(self):
        for name in set(tree_species_names()) - {"dead_tree", "conifer"}:
            for season, turned in (("spring", False), ("summer", False), ("autumn", True)):
                it = grow_tree(tree_species(name), 1, 0, season)
                red, green, blue = it.palette[it.foliage_tint].mean(axis=0)
                assert (red > green) == turned
                assert min(red, green) > 2 * blue


KINDS = list(tree_species_names())


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
    from scenes.sticks.areas import largest_area_in_view

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


@pytest.mark.parametrize("levels", [1, 2])
def test_leaves_grow_on_however_few_levels_of_branches(levels):
    birch = tree_species("birch")
    grown = grow_tree(replace(birch, levels=birch.levels[:levels]), 1, 0)
    assert set(grown.foliage.twig) <= set(range(len(grown.levels[levels]))) != set()


FOLDER = Path(str(resources.files("scenes.trees") / "species"))


@pytest.fixture
def willow(tmp_path):
    """The file of a species of one's own, and a way to read it with some text replaced."""
    shutil.copy(FOLDER / "birch.toml", tmp_path / "willow.toml")

    def read(old="", new=""):
        path = tmp_path / "willow.toml"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))
        return read_species(path)

    return read


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("scale = 11.0", "scale = -11.0", r"willow.toml: scale: -11.0: greater than 0"),
        ("scale = 11.0", "scail = 11.0", r"willow.toml: scail: 11.0: no such key"),
        ("scale_v = 1.0", "", r"willow.toml: scale_v: 'missing': a required key"),
        ("summer = {", "monsoon = {", r"foliage.albedo.monsoon.*spring"),
    ],
)
def test_errors_name_the_file_the_key_what_arrived_and_the_rule(willow, old, new, message):
    with pytest.raises(InputError, match=message):
        willow(old, new)
