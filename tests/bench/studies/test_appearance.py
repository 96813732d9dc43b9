"""The study of leaf appearances: its trees, and what it says where the answer is known."""

from dataclasses import replace

import numpy as np
import pytest
from click.testing import CliRunner

from bench.studies.appearance import light, silhouette, study
from bench.studies.appearance.cuts import UNSEEN, Case, cases, lone_tree, species_of
from scenes.model_files.names import tree_species_names

TREE = Case("dead_tree", 5)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(silhouette, "RAYS", 90)
    monkeypatch.setattr(light, "AZIMUTHS", 2)
    monkeypatch.setattr(light, "SUNS_DEG", (40.0,))
    monkeypatch.setattr(light, "SIZE_PX", 48)


def test_unseen_kinds_are_none_of_the_projects_own():
    assert not set(UNSEEN) & set(tree_species_names())
    assert len({each.kind for each in cases()}) == len(UNSEEN) + len(tree_species_names())
    for kind in UNSEEN:
        assert species_of(kind).foliage_colours("summer")


def test_the_whole_tree_is_as_itself_and_thinner_shapes_cover_less():
    tree = lone_tree(TREE)
    assert (silhouette.cover_ratios(tree, tree.finest) == 1).all()
    (prototype,) = tree.placed.prototypes.prototypes
    thin = replace(prototype, leaf=prototype.leaf.thickened(np.full(len(prototype.leaf), 0.6)))
    other = replace(tree, placed=replace(tree.placed, prototype=thin))
    view = np.array((0.6, 0.0, 0.8))
    covers = [silhouette._cover(each, 2, view) for each in (other, tree)]
    assert 0.5 < covers[0] / covers[1] < 0.95


def test_darker_shapes_are_darker():
    tree = lone_tree(TREE)
    (prototype,) = tree.placed.prototypes.prototypes
    dark = replace(prototype, tints=prototype.tints / 2)
    other = replace(tree, placed=replace(tree.placed, prototype=dark))
    whole, half = (light._mean_radiance(each, tree.finest) for each in (tree, other))
    for key in whole:
        assert 0.4 < half[key] / whole[key] < 0.55


def test_it_says_which_levels_are_within_the_limits(monkeypatch):
    monkeypatch.setattr(study, "cases", lambda: [TREE])
    said = CliRunner().invoke(study.command, ["dead_tree"])
    assert said.exit_code == 0, said.output
    assert "dead_tree, seed 5" in said.output and ("yes" in said.output or "no" in said.output)
