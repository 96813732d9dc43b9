"""The study of leaf appearances: its trees, and what it says where the answer is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from scenes.model_files import tree_species_names
from tests.tools import leaf_appearances as judging
from tests.tools.leaf_appearances import (
    IMPORTED,
    OTHERS,
    UNSEEN,
    Case,
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


def test_the_page_has_the_table_of_the_record():
    root = Path(__file__).resolve().parents[3]
    text = (root / "docs" / "appearance.md").read_text(encoding="utf-8")
    assert markdown(read_findings(root / "results" / "appearance" / "judged.json")) in text
