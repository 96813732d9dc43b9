"""Trees: branches on branches, leaves one by one, each kind as its seasons have it."""

from functools import lru_cache
from itertools import pairwise

import numpy as np
import pytest

from lod.errors import InputError
from scenes.model_files.names import tree_species_names
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.tree import grow_tree, tree_prototypes
from scenes.models.trees.weather import SEASONS
from scenes.sticks.outline_area import mean_area, mean_outline_areas

COLUMNS = ("start", "end", "start_radius", "end_radius", "tint")
HEIGHTS = {
    "tree": (7.5, 13),
    "birch": (8.5, 13.5),
    "conifer": (9.5, 16),
    "shrub": (1.0, 3.0),
    "dead_tree": (4.5, 12),
}


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

    def test_parts_belong_to_the_level_before(self, kind):
        h = tree(kind).hierarchy
        assert (h.level[1:] == h.level[h.parent[1:]] + 1).all()

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

    def test_chains_are_joined(self, kind):
        for level in grow_tree(tree_species(kind), 1, 0).levels[1:]:
            step = np.linalg.norm(np.diff(level.nodes, axis=1), axis=2).sum(axis=1)
            assert step == pytest.approx(level.length)

    def test_a_leaf_is_a_small_part_of_its_own_near_its_twig(self):
        for name in set(tree_species_names()) - {"dead_tree"}:
            p = tree(name)
            h, last = p.hierarchy, p.hierarchy.level.max()
            leaves = np.flatnonzero(h.level == last)
            assert (p.leaf.count[leaves] == 1).all()
            assert (h.P[leaves] < 0.25).all()
            assert (h.separation[leaves] < 1.6 * h.R[h.parent[leaves]]).all()
            assert len(leaves) > 1000

    def test_few_sticks_stand_for_many(self, kind):
        p = tree(kind)
        h = p.hierarchy
        for level, most in zip(range(h.level.max()), (7, 6, 5, 4), strict=False):
            assert p.leaf.count[h.level == level].max() <= most


class TestStanding:
    def test_foot_is_below_the_ground(self, kind):
        p = tree(kind)
        trunk = slice(p.inner.first[0], p.inner.first[1])
        assert p.inner.start[trunk][0, 2] == pytest.approx(-tree_species(kind).trunk.root_depth)
        assert p.inner.start[trunk][1] == pytest.approx(0)

    def test_trunks_are_flared_and_seen_from_afar(self):
        for name in set(tree_species_names()) - {"shrub"}:
            p = tree(name)
            radius = p.inner.start_radius[:3]
            assert radius[1] > 1.2 * radius[2]
            if name != "conifer":  # its boughs hide it
                assert p.leaf.start[0, 2] == pytest.approx(-tree_species(name).trunk.root_depth)

    def test_no_leaf_reaches_the_ground(self, kind):
        p = tree(kind)
        last = p.hierarchy.level[p.leaf.owner] == p.hierarchy.level.max()
        lowest = np.minimum(p.leaf.start[last, 2], p.leaf.end[last, 2]).min()
        assert lowest > (0.02 if kind == "shrub" else 0.1)

    def test_height(self, kind):
        p = tree(kind)
        last = p.hierarchy.level[p.leaf.owner] == p.hierarchy.level.max()
        scale = tree_species(kind).scale
        low, high = HEIGHTS.get(kind, (0.5 * scale, 1.5 * scale))
        assert low < p.leaf.end[last, 2].max() < high

    def test_a_conifer_is_a_cone_and_a_broadleaf_is_not(self):
        def width(name, low, high):
            p = tree(name)
            middle = p.leaf.start[p.hierarchy.level[p.leaf.owner] == p.hierarchy.level.max()]
            share = middle[:, 2] / middle[:, 2].max()
            some = middle[(share > low) & (share < high)]
            return np.quantile(np.hypot(*some[:, :2].T), 0.9)

        assert width("conifer", 0.1, 0.3) > 2.5 * width("conifer", 0.75, 0.9)
        assert width("tree", 0.4, 0.6) < 1.6 * width("tree", 0.75, 0.9)


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

    def test_spring_leaves_are_lighter_than_summer_leaves(self):
        for name in ("tree", "birch", "shrub"):
            greens = (
                grow_tree(tree_species(name), 1, 0, season) for season in ("spring", "summer")
            )
            spring, summer = (it.palette[it.foliage_tint].mean() for it in greens)
            assert spring > 1.2 * summer

    def test_tints_vary_and_are_few(self, kind):
        for season in SEASONS:
            it = grow_tree(tree_species(kind), 1, 0, season)
            assert len(it.palette) <= 15
            if len(it.foliage_tint):
                share = np.bincount(it.foliage_tint)[2:] / len(it.foliage_tint)
                assert share.min() > 0.03
                assert len(share) == 5

    def test_an_unknown_season(self):
        with pytest.raises(InputError, match=r"monsoon.*spring, summer"):
            tree_prototypes(1, 1, tree_species("tree"), "monsoon")


class TestLeafAppearance:
    def test_each_part_covers_what_it_hides(self):
        p = tree("tree")
        h = p.hierarchy
        for row in [*np.flatnonzero(h.level == 1)[:3], *np.flatnonzero(h.level == 3)[:3]]:
            held = {int(row)}
            for k in range(row + 1, len(h)):
                if int(h.parent[k]) in held:
                    held.add(k)
            rows = np.array(sorted(held))
            inner, leaf = np.isin(p.inner.owner, rows), np.isin(p.leaf.owner, rows)
            leaf &= h.part_count[p.leaf.owner] == 0
            hidden = _union(p, inner, leaf)
            seen = _union(p, np.zeros(len(p.inner), bool), p.leaf.owner == row)
            assert seen == pytest.approx(hidden, rel=0.2)  # level as a whole: test_silhouette

    def test_is_porous(self):
        """The blobs of a part hide little of one another, and gaps are left between them."""
        p = tree("tree")
        apart = np.bincount(p.leaf.owner, mean_outline_areas(p.leaf))
        limbs = np.flatnonzero(p.hierarchy.level == 1)
        covered = mean_area(p.leaf)[limbs]
        assert (covered > 0.65 * apart[limbs]).all()
        assert (covered < 0.35 * p.hierarchy.R[limbs] ** 2).all()


def _union(p, inner, leaf):
    from lod.shapes import StickTable

    pairs = [(getattr(p.inner, c)[inner], getattr(p.leaf, c)[leaf]) for c in COLUMNS]
    columns = [np.concatenate(pair) for pair in pairs]
    return mean_area(StickTable(np.array([0, len(columns[-1])]), *columns))[0]


class TestChance:
    def test_same_seed_same_tree(self):
        first = tree_prototypes(5, 1, tree_species("tree"))[0]
        tree_prototypes.cache_clear()
        second = tree_prototypes(5, 1, tree_species("tree"))[0]
        for name in COLUMNS:
            assert getattr(first.leaf, name).tobytes() == getattr(second.leaf, name).tobytes()
        assert first.hierarchy.P.tobytes() == second.hierarchy.P.tobytes()

    def test_trees_of_a_seed_and_of_other_seeds_differ(self):
        species, pairs = tree_species("tree"), ((1, 0), (1, 1), (2, 0))
        rows = {grow_tree(species, s, k).foliage.start.tobytes() for s, k in pairs}
        assert len(rows) == 3

    def test_none_at_all(self):
        with pytest.raises(InputError, match="at least one"):
            tree_prototypes(1, 0, tree_species("tree"))
