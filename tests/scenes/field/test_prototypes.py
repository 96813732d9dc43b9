"""Displayed sticks are the same in any number of runs, and those of each part by hand."""

from dataclasses import replace

import numpy as np
import pytest

from lod.pruner import BlendWeights
from scenes.field.part_tables import PartTables
from scenes.rig.rigged_prototype import rigged
from scenes.sticks.areas import ViewDependence
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes


@pytest.fixture(scope="module")
def part_tables():
    return PartTables.of(tuple(map(rigged, tree_prototypes(3, 2, tree_species("conifer")))))


def looked_at(parts):
    chance = np.random.default_rng(4)
    inner, leaf = np.round(chance.uniform(0, 1, (2, parts)) * chance.integers(0, 2, (2, parts)), 1)
    hidden = np.where(leaf > 0, chance.uniform(0.1, 1, parts), 0.0)
    rise, turn = chance.uniform(-1, 1, (2, parts))
    return BlendWeights(inner, leaf, rise, turn, hidden)


@pytest.mark.parametrize("shortest", [1, 50])
def test_runs_do_not_show(monkeypatch, part_tables, shortest):
    """Told by two threads and by one."""
    rows = np.random.default_rng(5).integers(0, len(part_tables.level), 301)
    whole = part_tables.sticks_of(rows, looked_at(len(rows)))
    monkeypatch.setattr("lod.kernels.get_num_threads", lambda: 2)
    monkeypatch.setattr("scenes.field.part_tables._SHORTEST_RUN", shortest)
    for alone, shared in zip(whole, part_tables.sticks_of(rows, looked_at(len(rows))), strict=True):
        assert alone.tobytes() == shared.tobytes() and alone.dtype == shared.dtype


def test_leaf_appearances_show_more_where_they_and_their_parts_lie_in_one_another():
    grown = tree_prototypes(3, 1, tree_species("birch"))[0]
    tree = rigged(replace(grown, view_dependence=ViewDependence()))
    h = tree.hierarchy
    shown = {}
    for overlap in (0.0, 0.5):
        laid = replace(h, overlap=np.where(h.level == 1, overlap, 0.0))
        part_tables = PartTables.of((replace(tree, hierarchy=laid),))
        rows = np.array([*np.flatnonzero(h.level == 1)[:2], *np.flatnonzero(h.level == 2)[:1]])
        weights = BlendWeights(
            np.ones(3), np.array((0.3, 0.8, 0.3)), hidden_area=np.array((0.6, 1.0, 0.6))
        )
        shown[overlap] = part_tables.sticks_of(rows, weights)
    plain, lapped = shown.values()
    assert np.array_equal(plain.stick, lapped.stick)
    leaf = plain.share < 1
    half = leaf & (plain.owner == 0)
    assert half.any()
    # 0.6 of its parts are hidden, 0.4 displayed: 0.6/(1 − 0.5·0.4) = 0.75; half of it fades itself.
    assert lapped.share[half] == pytest.approx(0.5 * 0.75)
    assert np.array_equal(lapped.share[~half], plain.share[~half])
