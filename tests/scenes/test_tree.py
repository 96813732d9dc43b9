"""Trees: branches on branches, a leafy crown, leaf appearances that keep cover and colour."""

from itertools import pairwise

import numpy as np
import pytest

from lod.errors import InputError
from scenes.stick_area import mean_area, mean_outline_areas
from scenes.stick_raster import areas_of_parts
from scenes.stick_table import StickTable
from scenes.tree import BLOBS, WOOD, grown, tree_prototypes
from scenes.tree_species import BROADLEAF

COLUMNS = ("start", "end", "start_radius", "end_radius", "tint")


@pytest.fixture(scope="module")
def trees():
    return tree_prototypes(1, 2)


def cut(p, level):
    """What is seen when every part up to a level is displayed, as one part."""
    h = p.hierarchy
    rows = h.level <= level
    owns = np.zeros(len(h), bool)
    owns[h.whole[1:][rows[1:]]] = True
    pieces = []
    for table, chosen in ((p.inner, rows & owns), (p.leaf, rows & ~owns)):
        pieces.append([getattr(table, c)[chosen[table.owner]] for c in COLUMNS])
    columns = [np.concatenate(pair) for pair in zip(*pieces, strict=True)]
    return StickTable(np.array([0, len(columns[-1])]), *columns)


def mean_tint(p, table):
    weight = mean_outline_areas(table)
    return (weight[:, None] * p.tints[table.tint]).sum(axis=0) / weight.sum()


class TestHierarchy:
    def test_size_and_levels(self, trees):
        for p in trees:
            h = p.hierarchy
            assert 2000 <= len(h) <= 4000
            assert set(h.level) == set(range(6))
            assert len(p.inner) >= 1000  # sticks of trunk, limbs, branches, branchlets, twigs
            branches = np.bincount(h.level)[:5]
            assert (np.diff(branches) > 0).all()

    def test_parts_belong_to_the_level_before(self, trees):
        for p in trees:
            h = p.hierarchy
            assert (h.level[1:] == h.level[h.whole[1:]] + 1).all()

    def test_every_branch_grows_out_of_its_whole(self, trees):
        """Its base lies on the chain of the branch that owns it."""
        for p in trees:
            h = p.hierarchy
            for row in np.flatnonzero((h.level >= 1) & (h.level <= 4))[::13]:
                whole = h.whole[row]
                block = slice(p.inner.first[whole], p.inner.first[whole + 1])
                a, b = p.inner.start[block], p.inner.end[block]
                along = ((h.position[row] - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1)
                near = a + np.clip(along, 0, 1)[:, None] * (b - a)
                assert np.linalg.norm(near - h.position[row], axis=1).min() < 1e-9

    def test_branches_are_thinner_than_what_bears_them(self):
        levels = grown(BROADLEAF, 1, 0).levels
        for above, level in pairwise(levels):
            assert (level.radii[:, 0] <= above.radii[level.parent].max(axis=1)).all()
            assert (np.diff(level.radii, axis=1) <= 1e-12).all()

    def test_chains_are_joined(self):
        for level in grown(BROADLEAF, 1, 0).levels[1:]:
            step = np.linalg.norm(np.diff(level.nodes, axis=1), axis=2).sum(axis=1)
            assert step == pytest.approx(level.length)


class TestStanding:
    def test_foot_is_below_the_ground_and_flared(self, trees):
        for p in trees:
            trunk = slice(p.inner.first[0], p.inner.first[1])
            start, radius = p.inner.start[trunk], p.inner.start_radius[trunk]
            assert start[0, 2] == pytest.approx(-BROADLEAF.below)
            assert start[1] == pytest.approx(0)
            assert radius[1] > 1.3 * radius[2]
            assert p.leaf.start[0, 2] == pytest.approx(-BROADLEAF.below)  # and as a blob

    def test_nothing_else_reaches_the_ground(self, trees):
        for p in trees:
            leaves = p.leaf.owner >= np.flatnonzero(p.hierarchy.level == 5)[0]
            assert p.leaf.start[leaves, 2].min() > 0.5

    def test_height(self, trees):
        for p in trees:
            top = cut(p, 5).end[:, 2].max()
            assert 8 < top < 14


class TestCrown:
    def test_reads_as_leafy(self, trees):
        """From the side leaves cover most of the crown, and hide most of the twigs."""
        for p in trees:
            h = p.hierarchy
            leaves = h.level[p.leaf.owner] == 5
            points = p.leaf.start[leaves]
            middle = np.abs(points - np.median(points, axis=0)).max(axis=0) / 2
            width, height = 2 * np.quantile(np.abs(points - points.mean(0)), 0.8, axis=0)[[1, 2]]
            side = np.array([[1.0, 0.0, 0.0]])
            t = StickTable(
                np.array([0, leaves.sum()]), *(getattr(p.leaf, c)[leaves] for c in COLUMNS)
            )
            core = np.pi / 4 * width * height
            assert areas_of_parts(t, side)[0, 0] > 0.8 * core
            assert middle.min() > 1.0

    def test_wood_is_a_small_share_of_what_is_seen(self, trees):
        for p in trees:
            weight = mean_outline_areas(p.leaf)
            assert weight[p.hierarchy.level[p.leaf.owner] == 5].sum() > 60  # m² of leaves

    def test_greens_vary(self, trees):
        for p in trees:
            foliage = p.leaf.tint[p.hierarchy.level[p.leaf.owner] == 5]
            share = np.bincount(foliage, minlength=7)[2:7] / len(foliage)
            assert share.min() > 0.05
            green = p.tints[2:7]
            assert (green[:, 1] > green[:, 0]).all()
            assert (green[:, 0] > green[:, 2]).all()
            bark = p.tints[:2]
            assert (bark[:, 0] > bark[:, 1]).all()


class TestLeafAppearance:
    def test_few_sticks(self, trees):
        for p in trees:
            h = p.hierarchy
            for level in range(5):
                most = p.leaf.count[h.level == level].max()
                assert most <= BLOBS[level] + WOOD[level]
                assert most <= (48 if level == 0 else 12)

    def test_mean_cover_at_every_cut(self, trees):
        for p in trees:
            full = mean_area(cut(p, 5))[0]
            for level, tolerance in ((4, 0.01), (3, 0.01), (2, 0.03), (1, 0.08), (0, 0.05)):
                assert mean_area(cut(p, level))[0] == pytest.approx(full, rel=tolerance), level

    def test_cover_from_the_side_and_from_above(self, trees):
        turn = np.arange(6) * np.pi / 6
        side = np.stack((np.cos(turn), np.sin(turn), 0 * turn), axis=1)
        above = np.array([[0.0, 0.0, 1.0]])
        for p in trees:
            for spread in (side, above):
                full = areas_of_parts(cut(p, 5), spread).mean()
                for level in (2, 3, 4):
                    cover = areas_of_parts(cut(p, level), spread).mean()
                    assert cover == pytest.approx(full, rel=0.05)

    def test_each_part_covers_what_it_hides(self, trees):
        p = trees[0]
        h = p.hierarchy
        for row in [*np.flatnonzero(h.level == 1)[:3], *np.flatnonzero(h.level == 3)[:5]]:
            held = {row}
            for k in range(row + 1, len(h)):
                if h.whole[k] in held:
                    held.add(k)
            rows = np.array(sorted(held))
            pieces = []
            for table, chosen in (
                (p.inner, rows),
                (p.leaf, rows[h.part_count[rows] == 0]),
            ):
                mask = np.isin(table.owner, chosen)
                pieces.append([getattr(table, c)[mask] for c in COLUMNS])
            columns = [np.concatenate(pair) for pair in zip(*pieces, strict=True)]
            hidden = mean_area(StickTable(np.array([0, len(columns[-1])]), *columns))[0]
            block = slice(p.leaf.first[row], p.leaf.first[row + 1])
            look = [getattr(p.leaf, c)[block] for c in COLUMNS]
            seen = mean_area(StickTable(np.array([0, len(look[-1])]), *look))[0]
            assert seen == pytest.approx(hidden, rel=0.03)

    def test_is_porous(self, trees):
        """The blobs of a part hide little of one another, and gaps are left between them."""
        for p in trees:
            h = p.hierarchy
            apart = np.bincount(p.leaf.owner, mean_outline_areas(p.leaf))
            limbs = np.flatnonzero(h.level == 1)
            covered = mean_area(p.leaf)[limbs]
            assert (p.leaf.count[limbs] > 5).all()
            assert (covered > 0.65 * apart[limbs]).all()
            assert (covered < 0.35 * h.R[limbs] ** 2).all()

    def test_mean_tint_at_every_cut(self, trees):
        for p in trees:
            full = mean_tint(p, cut(p, 5))
            for level in range(5):
                assert mean_tint(p, cut(p, level)) == pytest.approx(full, rel=0.06), level


class TestChance:
    def test_same_seed_same_tree(self):
        first = tree_prototypes(5, 1)[0]
        tree_prototypes.cache_clear()
        second = tree_prototypes(5, 1)[0]
        for name in COLUMNS:
            assert getattr(first.leaf, name).tobytes() == getattr(second.leaf, name).tobytes()
        assert first.hierarchy.P.tobytes() == second.hierarchy.P.tobytes()

    def test_trees_of_a_seed_and_of_other_seeds_differ(self, trees):
        rows = {
            t.leaves.start.tobytes()
            for s, k in ((1, 0), (1, 1), (2, 0))
            for t in [grown(BROADLEAF, s, k)]
        }
        assert len(rows) == 3
        assert trees[0].hierarchy.P[0] != trees[1].hierarchy.P[0]

    def test_none_at_all(self):
        with pytest.raises(InputError, match="at least one"):
            tree_prototypes(1, 0)
