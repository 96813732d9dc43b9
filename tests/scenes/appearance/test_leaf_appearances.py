"""The study of leaf appearances: its trees, and what it says where the answer is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from scenes.imported.library import read_model
from scenes.model_files.names import tree_species_names
from tests.scenes.imported.sample_models import lamp_tree, mill
from tests.tools import leaf_appearances as judging
from tests.tools.leaf_appearances import (
    IMPORTED,
    KINDS,
    OTHERS,
    UNSEEN,
    Case,
    Judged,
    cases,
    lone_object,
    markdown,
    read_findings,
    species_of,
)

TREE = Case("dead_tree", 5)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(judging, "RAYS", 90)
    monkeypatch.setattr(judging, "AZIMUTHS", 2)
    monkeypatch.setattr(judging, "SUNS_DEG", (40.0,))
    monkeypatch.setattr(judging, "SIZE_PX", 48)


def test_unseen_kinds_are_none_of_the_projects_own():
    assert not set(UNSEEN) & set(tree_species_names())
    others = len(UNSEEN) + len(IMPORTED) + len(OTHERS)
    assert len({each.kind for each in cases()}) == others + len(tree_species_names())
    for kind in UNSEEN:
        assert species_of(kind).foliage_colours("summer")


def test_the_whole_tree_is_as_itself_and_thinner_shapes_cover_less():
    tree = lone_object(TREE)
    assert (judging.cover_ratios(tree, tree.finest) == 1).all()
    (prototype,) = tree.placed.prototypes.prototypes
    thin = replace(prototype, leaf=prototype.leaf.thickened(np.full(len(prototype.leaf), 0.6)))
    other = replace(tree, placed=replace(tree.placed, prototype=thin))
    view = np.array((0.6, 0.0, 0.8))
    covers = [judging._cover(each, 2, view) for each in (other, tree)]
    assert 0.5 < covers[0] / covers[1] < 0.95


def test_sun_and_eye_go_round_the_object():
    sun, turn = np.array(judging.azimuths(16)).T
    eye = np.round((sun + turn) % 360, 6)
    assert len(np.unique(sun)) == 16 and len(np.unique(turn)) == 16
    assert len(np.unique(eye)) == 8
    np.testing.assert_allclose(np.diff(np.unique(eye)), 45)


def test_darker_shapes_are_darker():
    tree = lone_object(TREE)
    (prototype,) = tree.placed.prototypes.prototypes
    dark = replace(prototype, tints=prototype.tints / 2)
    other = replace(tree, placed=replace(tree.placed, prototype=dark))
    whole, half = (judging._mean_radiance(each, tree.finest) for each in (tree, other))
    for key in whole:
        assert 0.4 < half[key] / whole[key] < 0.55


def test_one_object_is_judged_and_stands_in_the_table(monkeypatch, tmp_path):
    monkeypatch.setattr(judging, "cases", lambda: [TREE])
    path = tmp_path / "judged.json"
    said = CliRunner().invoke(judging.command, ["dead_tree", "-o", str(path)])
    assert said.exit_code == 0, said.output
    (found,) = read_findings(path)
    assert (found.level, len(found.covers), len(found.radiances)) == (2, 64, 2)
    assert markdown([found]) in said.output


def test_the_page_has_the_table_of_the_record():
    root = Path(__file__).resolve().parents[3]
    text = (root / "docs" / "appearance.md").read_text(encoding="utf-8")
    assert markdown(read_findings(root / "results" / "appearance" / "judged.json")) in text


def test_limits_are_those_that_the_page_names():
    held = Judged("tree", 1, 2, (1.04, 1.04, 0.98), (1.029, 0.971))
    assert held.within and held.worst == 1.04
    for change in ({"covers": (1.16, 0.9)}, {"covers": (1.06,)}, {"radiances": (0.969,)}):
        assert not replace(held, **change).within


def test_models_are_those_of_the_tests_and_have_at_least_four_levels(tmp_path):
    made = {"mill": mill(tmp_path / "mill.usda"), "lamp_tree": lamp_tree(tmp_path / "lamps.glb")}
    for name, path in made.items():
        ours = read_model(KINDS / IMPORTED[name])
        assert ours.digest == read_model(path).digest
        assert ours.level.max() >= 4
