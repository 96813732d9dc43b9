"""The rule for P, R, B and separation, on objects small enough to know, and on the real ones.

Classes of inherent contrast: by hand, for every model, and safe whatever stands behind.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES, NEVER_LOST
from lod.shapes import StickTable
from scenes.figures.animal_file import standing_people
from scenes.models.catalogue import MODELS
from scenes.sticks.areas import area_shares_at, areas_of_parts, directions, with_area_share
from scenes.sticks.prototype import (
    GROUND,
    HORIZONS,
    LIT,
    SHADED,
    PartPlaces,
    Prototype,
    assemble_prototype,
    greatest_contrast,
    part_contrasts,
)
from scenes.trees.species import CALM_SUMMER, tree_species
from scenes.trees.tree import tree_prototypes


def sticks(parts, rows):
    """Rows are (owner, start, end, radius)."""
    owner, start, end, r = (np.array(c) for c in zip(*rows, strict=True))
    tint = np.zeros(len(rows), np.int64)
    return StickTable.of(parts, owner, start * 1.0, end * 1.0, r * 1.0, r * 1.0, tint)


def pole(**changes):
    """A whole 4 m tall with a branch at 3 m that owns a twig: every length is known by hand."""
    fields = {
        "name": "pole",
        "parent": np.array([-1, 0, 1]),
        "level": np.array([0, 1, 2]),
        "origin": np.array([(0, 0, 0), (0, 0, 3), (2, 0, 3)], float),
        "inner": sticks(3, [(0, (0, 0, 0), (0, 0, 3.9), 0.1), (1, (0, 0, 3), (2, 0, 3), 0.1)]),
        "leaf": sticks(
            3,
            [
                (0, (0, 0, 0.5), (0, 0, 3.5), 0.5),
                (1, (0, 0, 3), (2.5, 0, 3), 0.1),
                (2, (2, 0, 3), (2, 0, 4), 0.05),
            ],
        ),
        "tints": np.array([(0.5, 0.5, 0.5)]),
    }
    fields |= changes
    places = PartPlaces(*(fields.pop(key) for key in ("parent", "level", "origin")))
    return assemble_prototype(places=places, **fields)


def rigid_prototypes():
    """What has one pose only; P and R of people hold for every pose (test_rig)."""
    return tree_prototypes(1, 2, tree_species("tree"))


def by_themselves(h):
    """Rows of the parts that are one with no other (``lod.hierarchy``)."""
    with_whole = np.flatnonzero(h.separation[1:] == 0) + 1
    return np.setdiff1d(np.arange(len(h)), np.union1d(with_whole, h.parent[with_whole]))


def all_prototypes():
    return (*standing_people(1, 2), *tree_prototypes(1, 1, tree_species("tree")))


class TestByHand:
    def test_priority_is_the_root_of_the_largest_area(self):
        P = pole().hierarchy.P
        areas = (np.pi / 4 + 3, np.pi * 0.01 + 0.5, np.pi * 0.0025 + 0.1)
        assert pytest.approx(np.sqrt(areas)) == P

    def test_range_reaches_the_ends_of_the_part_and_of_its_own_parts(self):
        whole_to_branch_end = np.hypot(2.5, 3) + 0.1
        branch_to_twig_end = np.hypot(2, 1) + 0.05
        expected = (max(whole_to_branch_end, 4.0), max(2.6, branch_to_twig_end), 1.05)
        assert pole().hierarchy.R == pytest.approx(expected)

    def test_bound_is_nested(self):
        twig = 1.05
        branch = max(2.6, 2 + twig)
        assert pole().hierarchy.B == pytest.approx((max(4.0, 3 + branch), branch, twig))

    def test_separation_is_the_distance_between_origins(self):
        assert pole().hierarchy.separation == pytest.approx((0, 3, 2))


class TestRealObjects:
    def test_range_is_no_greater_than_it_must_be(self):
        for p in rigid_prototypes():
            h = p.hierarchy
            for row in by_themselves(h)[::11].tolist():
                rows = [row, *np.flatnonzero(h.parent == row)]
                reach = max(
                    _farthest(t, r, h.position[row]) for t in (p.inner, p.leaf) for r in rows
                )
                assert h.R[row] == pytest.approx(reach, rel=1e-12)

    def test_bound_holds_everything_below(self):
        for p in all_prototypes():
            h = p.hierarchy
            for table in (p.inner, p.leaf):
                for ends, r in ((table.start, table.start_radius), (table.end, table.end_radius)):
                    above = table.owner
                    while len(above) and (above >= 0).any():
                        held = above >= 0
                        reach = np.linalg.norm(ends - h.position[above], axis=1) + r
                        assert (reach[held] <= h.B[above[held]] * (1 + 1e-9)).all()
                        above = np.where(held, h.parent[above], -1)

    def test_priority_squared_is_the_largest_covered_area_within_three_percent(self):
        """Against many more directions than the rule uses."""
        dense = directions(2000)
        for p in rigid_prototypes():
            alone = by_themselves(p.hierarchy)
            rows = alone[np.unique(np.geomspace(1, len(alone), 12).astype(int) - 1)]
            part = StickTable(
                np.concatenate(([0], np.cumsum(p.leaf.count[rows]))),
                *(
                    np.concatenate(
                        [getattr(p.leaf, c)[p.leaf.first[r] : p.leaf.first[r + 1]] for r in rows]
                    )
                    for c in ("start", "end", "start_radius", "end_radius", "tint")
                ),
            )
            used = np.isin(p.leaf.owner, rows)
            views, tables = p.view_dependence, p.view_dependence.rows(len(p.leaf))[used]
            if len(views.area_share):  # as it looks from each
                areas = [
                    areas_of_parts(
                        with_area_share(part, area_shares_at(views, tables, each[2])), each[None]
                    )[:, 0]
                    for each in dense[::4]
                ]
                largest = np.max(areas, axis=0)
            else:
                largest = areas_of_parts(part, dense).max(axis=1)
            assert p.hierarchy.P[rows] == pytest.approx(np.sqrt(largest), rel=0.015)
            assert (p.hierarchy.P[rows] <= np.sqrt(largest) * 1.005).all()


def _farthest(table, row, origin):
    block = slice(table.first[row], table.first[row + 1])
    if block.start == block.stop:
        return 0.0
    start = np.linalg.norm(table.start[block] - origin, axis=1) + table.start_radius[block]
    end = np.linalg.norm(table.end[block] - origin, axis=1) + table.end_radius[block]
    return float(max(start.max(), end.max()))


class TestRefused:
    def test_empty_leaf_appearance(self):
        leaf = sticks(3, [(0, (0, 0, 0), (0, 0, 4), 0.5), (2, (2, 0, 3), (2, 0, 4), 0.05)])
        with pytest.raises(InputError, match="never empty"):
            pole(leaf=leaf)

    def test_tint_outside_the_palette(self):
        p = pole()
        leaf = StickTable.of(3, p.leaf.owner, *_columns(p.leaf)[:4], np.array([0, 1, 0]))
        with pytest.raises(InputError, match=r"leaf\.tint"):
            pole(leaf=leaf)

    @pytest.mark.parametrize("albedo", [-0.1, 1.1, np.nan])
    def test_albedo_outside_0_to_1(self, albedo):
        with pytest.raises(InputError, match="tints"):
            pole(tints=np.array([(0.5, albedo, 0.5)]))

    def test_sticks_beyond_the_range(self):
        p, longer = pole(), pole().leaf.scaled(2.0)
        with pytest.raises(InputError, match=r"R\[0\]"):
            Prototype("pole", p.hierarchy, p.inner, longer, p.tints)


def _columns(table):
    return [table.start, table.end, table.start_radius, table.end_radius, table.tint]


def test_a_dark_thing_stands_out_most_against_the_sky_and_a_white_one_against_shade():
    """By hand: (2 − 0.005)/(2 + 0.005), and (2.3 − 0.008)/(2·0.25) through air of 0.25."""
    found = greatest_contrast(np.array([0.05, 1.0]))
    assert found == pytest.approx([1.995 / 2.005, 2.292 / 0.5])


@given(
    albedo=st.floats(0.002, 1.0),
    light=st.floats(SHADED, LIT),
    ground=st.floats(SHADED * GROUND[0], LIT * GROUND[1]),
    horizon=st.floats(*HORIZONS),
    depth=st.floats(0.0, 8.0),
)
def test_no_modulation_left_is_above_what_the_class_promises(albedo, light, ground, horizon, depth):
    """The modulation of part and background through air, worked out directly (Koschmieder)."""
    through = np.exp(-depth)
    bound = greatest_contrast(np.array([albedo]))[0] * through
    seen = light * albedo * through + horizon * (1 - through)
    for behind in (ground, horizon):
        other = behind * through + horizon * (1 - through)
        assert abs(seen - other) / (seen + other) <= bound * (1 + 1e-9)


def test_a_whole_has_at_least_the_class_of_its_parts():
    """A black whole, a black part and on it a white one; beside them a grey one."""
    whole = np.array([-1, 0, 1, 0])
    table = StickTable(
        first=np.arange(5),
        start=np.zeros((4, 3)),
        end=np.ones((4, 3)),
        start_radius=np.ones(4),
        end_radius=np.ones(4),
        tint=np.array([0, 0, 1, 2]),
    )
    tints = np.array([[0.01] * 3, [0.9] * 3, [0.2] * 3])
    contrast, to_whole = part_contrasts(whole, table, tints)
    assert contrast.tolist() == [5, 5, 5, 3]
    assert to_whole == pytest.approx([1, 0.89 / 0.91, 0.89 / 0.91, 0.19 / 0.21])


def test_a_part_that_matches_its_whole_has_the_least_contrast_to_it():
    """And a dark one beside a bright whole as much as a bright one beside a dark whole."""
    ends = np.zeros((3, 3)), np.ones((3, 3)), np.ones(3), np.ones(3)
    tints = np.array([[0.3] * 3, [0.1] * 3])
    for tint in ([0, 0, 1], [1, 1, 0]):
        table = StickTable(np.arange(4), *ends, np.array(tint))
        found = part_contrasts(np.array([-1, 0, 0]), table, tints)[1]
        assert found == pytest.approx([1.0, CONTRAST_CLASSES[0], 0.5])


def test_the_mean_is_by_area_and_by_luminance():
    """A small white stick on a large black one changes nothing; pure blue is dark."""
    table = StickTable(
        first=np.array([0, 2, 3]),
        start=np.zeros((3, 3)),
        end=np.ones((3, 3)),
        start_radius=np.array([1.0, 0.01, 1.0]),
        end_radius=np.array([1.0, 0.01, 1.0]),
        tint=np.array([0, 1, 2]),
    )
    tints = np.array([[0.01] * 3, [1.0] * 3, [0.0, 0.0, 1.0]])
    assert part_contrasts(np.array([-1, -1]), table, tints)[0].tolist() == [3, 3]


@pytest.mark.parametrize("model", sorted(MODELS))
def test_every_part_of_every_model_can_be_lost(model):
    for prototype in MODELS[model](0, 1, CALM_SUMMER):
        contrast = prototype.hierarchy.contrast
        assert len(contrast) == len(prototype.hierarchy)
        assert contrast.min() >= CONTRAST_CLASSES.index(0.5)
        assert contrast.max() < NEVER_LOST
        whole = prototype.hierarchy.parent[1:]
        assert (contrast[whole] >= contrast[1:]).all()
