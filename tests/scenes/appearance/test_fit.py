"""Leaf appearances fitted to an object that is no tree: cover, what stays, and the cache.

No source file holds a value that was fitted to a model: a fit needs its shapes and albedos alone.
What comes with the package is made by the program (``test_fitted.py``).

The data files of the packages are presets, botany, anatomy, golden counts (which
``tests/bench/count`` counts again) and the sky's table (``tests.tools.sky_table``).
"""

import subprocess
import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from lod.shapes import StickTable
from scenes.appearance.fit import GREATEST, fit_appearances, measure_overlap
from scenes.appearance.visible_area import visible_areas
from scenes.sticks.areas import area_shares_at, directions, with_area_share
from scenes.sticks.prototype import PartSticks
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes

PALETTE = np.array([[0.1, 0.08, 0.06], [0.1, 0.2, 0.05], [0.2, 0.3, 0.1]])


def sticks(parts, owner, start, end, radius, tint):
    count = len(owner)
    radii = np.full(count, float(radius))
    ends = (np.asarray(each, np.float64) for each in (start, end))
    return StickTable.of(parts, np.array(owner), *ends, radii, radii, np.full(count, tint))


@pytest.fixture(scope="module")
def bush():
    """A pole, eight twigs around its upper half, and thirty leaves on each of them."""
    rng = np.random.default_rng(5)
    twigs, leaves = 8, 30
    turn = 2.4 * np.arange(twigs)
    base = np.column_stack((np.zeros((twigs, 2)), np.linspace(1.0, 2.0, twigs)))
    tip = base + np.column_stack((np.cos(turn), np.sin(turn), 0.3 * np.ones(twigs)))
    parent = np.concatenate(([-1], np.zeros(twigs), 1 + np.repeat(np.arange(twigs), leaves)))
    level = np.repeat([0, 1, 2], [1, twigs, twigs * leaves])
    n, along = len(parent), rng.uniform(0.2, 1.0, (twigs, leaves, 1))
    middle = base[:, None] + along * (tip - base)[:, None] + rng.normal(0, 0.1, (twigs, leaves, 3))
    middle, aside = middle.reshape(-1, 3), 0.06 * rng.normal(size=(twigs * leaves, 3))
    tables = [
        sticks(n, [0, 0], [(0, 0, 0), (0, 0, 1)], [(0, 0, 1), (0, 0, 2)], 0.06, 0),
        sticks(n, 1 + np.arange(twigs), base, tip, 0.015, 0),
        sticks(n, np.flatnonzero(level == 2), middle - aside, middle + aside, 0.05, 1),
    ]
    tints = np.concatenate((np.zeros(2 + twigs), rng.integers(1, 3, twigs * leaves)))
    own = StickTable.merge(tables)
    own = StickTable(own.first, *own.columns[:-1], tints.astype(np.int64))
    return PartSticks(parent.astype(np.int64), level, own, PALETTE)


def cover(table, view):
    return visible_areas(table, view[None], 0.02).sum()


def cut(parts, fitted, level, rise):
    """What is displayed down to a level, as it looks from a height."""
    of, views = fitted.leaf.owner, fitted.view_dependence
    shares = area_shares_at(views, views.rows(len(of)), rise)
    leaf = with_area_share(fitted.leaf, shares).take((parts.level == level)[of])
    inner = parts.own.take(parts.above(level)[parts.own.owner])
    return StickTable.as_one_part([inner, leaf])


def test_it_covers_as_much_from_every_side_at_every_level(bush):
    fitted = fit_appearances(bush)
    whole = StickTable.as_one_part([bush.own])
    for level, each in ((0, 0.4), (1, 0.15)):
        ratio = np.array(
            [
                cover(cut(bush, fitted, level, view[2]), view) / cover(whole, view)
                for view in directions(64)[::2]
            ]
        )
        assert ratio.mean() == pytest.approx(1, abs=0.05)
        assert abs(ratio - 1).max() < each
    assert fitted.leaf.count[0] <= 5


def test_what_is_seen_has_the_mean_albedo_of_all(bush):
    fitted = fit_appearances(bush)
    shown = fitted.leaf.of_parts(bush.level == 1)
    views = directions(8)
    colours = []
    for table in (shown, bush.own.take((bush.level == 2)[bush.own.owner])):
        area = visible_areas(StickTable.as_one_part([table]), views, 0.02).sum(axis=0)
        colours.append(area @ PALETTE[table.tint] / area.sum())
    assert colours[0] == pytest.approx(colours[1], rel=0.12)


def ball(parts, owner, x):  # so far round that no view has one behind the other
    turn = np.radians(9.0)
    at = x * np.array([[np.cos(turn), np.sin(turn), 0.0]])
    return sticks(parts, owner, at, at, 1.0, 0)


@pytest.mark.parametrize(("apart", "expected"), [(0.0, GREATEST), (20.0, 0.0)])
def test_the_overlap_of_what_is_the_same_place_and_of_what_is_far_away(apart, expected):
    """A ball that stands for another: in its place, or beside it in every view."""
    parent, level = np.array([-1, 0]), np.array([0, 1])
    leaf = StickTable.merge([ball(2, [0], apart), ball(2, [1], 0.0)])
    inner = leaf.take(np.zeros(0, np.int64))
    found = measure_overlap(parent, level, inner, leaf, PALETTE)
    assert found[1] == 0
    assert found[0] == pytest.approx(expected, abs=0.06)


@pytest.fixture(scope="module")
def chosen(bush):
    """The bush with one ball chosen for itself and one for each twig, of half the area or so."""
    inner = bush.owns
    owner = np.flatnonzero(inner)
    leaves = bush.own.only(~inner)
    whole = np.where(leaves.owner > 0, bush.parent[leaves.owner], 0)
    middles = [leaves.start[(whole == k) | (k == 0)].mean(axis=0) for k in owner]
    balls = sticks(len(bush.parent), owner, middles, middles, 0.2, 1)
    return replace(bush, chosen=balls.thickened(np.where(owner == 0, 3.0, 1.0)))


def test_chosen_shapes_stay_where_they_are_and_cover_what_they_hide(chosen):
    fitted = fit_appearances(chosen)
    own = chosen.owns[fitted.leaf.owner]
    np.testing.assert_array_equal(fitted.leaf.start[own], chosen.chosen.start)
    assert (fitted.view_dependence.table_row[own] == chosen.level[fitted.leaf.owner[own]]).all()
    full = StickTable.as_one_part([chosen.own])
    views = directions(24)
    for level in (0, 1):
        ratios = [cover(cut(chosen, fitted, level, v[2]), v) / cover(full, v) for v in views]
        assert np.mean(ratios) == pytest.approx(1, abs=0.06)


ROOT = Path(__file__).resolve().parents[3]

FITTED = {"area_share", "heights", "leaf_appearance", "lit", "lit_bare", "overlap", "sides", "tone"}
"""Names under which fitted values stood in files, and under which fits have them now."""

KINDS = {
    "scenes/figures/animals/*.toml",
    "scenes/figures/*.toml",
    "scenes/trees/species/*.toml",
    "scenes/presets/*.toml",
    "scenes/appearance/sky.csv",
}


def data_files() -> list[Path]:
    listed = ["git", "ls-files", "-z", "lod", "scenes", "bench"]
    said = subprocess.run(listed, cwd=ROOT, capture_output=True, check=True).stdout.decode()
    found = [Path(name) for name in said.split("\0") if name]
    return [each for each in found if each.suffix in (".toml", ".csv", ".json", ".npz", ".npy")]


def keys_of(values: object) -> set[str]:
    if isinstance(values, dict):
        return set(values).union(*map(keys_of, values.values()))
    return set().union(*map(keys_of, values)) if isinstance(values, list) else set()


def test_data_files_are_of_known_kinds_and_have_nothing_fitted() -> None:
    files = data_files()
    assert len(files) > 20
    for path in files:
        assert any(path.match(kind) for kind in KINDS), f"{path}: of which kind is it?"
        if path.suffix == ".toml":
            found = keys_of(tomllib.loads((ROOT / path).read_text(encoding="utf-8")))
            assert not found & FITTED, path


def test_a_fit_does_not_know_the_name_of_its_species() -> None:
    species = tree_species("dead_tree")
    (named,), (nameless,) = (
        tree_prototypes(6, 1, each) for each in (species, replace(species, name="none of yours"))
    )
    for name in ("first", "start", "end", "start_radius", "end_radius", "tint"):
        assert np.array_equal(getattr(named.leaf, name), getattr(nameless.leaf, name)), name
    views = named.view_dependence, nameless.view_dependence
    assert np.array_equal(*(each.area_share for each in views)) and len(views[0].area_share)
    assert np.array_equal(named.hierarchy.overlap, nameless.hierarchy.overlap)
    assert np.array_equal(named.hierarchy.P, nameless.hierarchy.P)
