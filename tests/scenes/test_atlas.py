"""Displayed sticks of an atlas: the same in any number of runs, and those of each part by hand."""

import numpy as np
import pytest

from lod.parts import Look
from scenes.atlas import Atlas
from scenes.rig_prototype import rigid
from scenes.tree import tree_prototypes
from scenes.tree_species import SPECIES


@pytest.fixture(scope="module")
def atlas():
    return Atlas.of(tuple(map(rigid, tree_prototypes(3, 2, SPECIES["conifer"]))))


def looked_at(parts):
    chance = np.random.default_rng(4)
    inner, leaf = np.round(chance.uniform(0, 1, (2, parts)) * chance.integers(0, 2, (2, parts)), 1)
    return Look(inner, leaf, chance.uniform(-1, 1, parts))


@pytest.mark.parametrize("shortest", [1, 50])
def test_runs_do_not_show(monkeypatch, atlas, shortest):
    """Told by two threads and by one."""
    rows = np.random.default_rng(5).integers(0, len(atlas.level), 301)
    whole = atlas.sticks_of(rows, looked_at(len(rows)))
    monkeypatch.setattr("lod.runs.get_num_threads", lambda: 2)
    monkeypatch.setattr("scenes.atlas._SHORTEST_RUN", shortest)
    for alone, shared in zip(whole, atlas.sticks_of(rows, looked_at(len(rows))), strict=True):
        assert alone.tobytes() == shared.tobytes() and alone.dtype == shared.dtype


def test_sticks_are_those_of_both_appearances_in_order(atlas):
    rows = np.random.default_rng(6).integers(0, len(atlas.level), 60)
    look, first = looked_at(len(rows)), atlas.sticks.first
    shown = [
        (number, stick)
        for number, row in enumerate(rows.tolist())
        for side, share in enumerate((look.inner[number], look.leaf[number]))
        if share > 0
        for stick in range(first[2 * row + side], first[2 * row + side + 1])
    ]
    found = atlas.sticks_of(rows, look)
    assert list(zip(found.owner.tolist(), found.stick.tolist(), strict=True)) == shown
