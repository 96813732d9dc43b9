"""The study of leaf appearances: its trees, and what it says where the answer is known."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from bench.studies.appearance import light, silhouette, study
from bench.studies.appearance.cases import IMPORTED, KINDS, OTHERS, UNSEEN, Case, cases, species_of
from bench.studies.appearance.cuts import lone_object
from bench.studies.appearance.record import (
    BEGIN,
    END,
    Judged,
    markdown,
    read_findings,
    with_table,
)
from lod.errors import InputError
from scenes.imported.library import read_model
from scenes.model_files.names import tree_species_names
from tests.scenes.imported.sample_models import lamp_tree, mill

TREE = Case("dead_tree", 5)


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(silhouette, "RAYS", 90)
    monkeypatch.setattr(light, "AZIMUTHS", 2)
    monkeypatch.setattr(light, "SUNS_DEG", (40.0,))
    monkeypatch.setattr(light, "SIZE_PX", 48)


def test_unseen_kinds_are_none_of_the_projects_own():
    assert not set(UNSEEN) & set(tree_species_names())
    others = len(UNSEEN) + len(IMPORTED) + len(OTHERS)
    assert len({each.kind for each in cases()}) == others + len(tree_species_names())
    for kind in UNSEEN:
        assert species_of(kind).foliage_colours("summer")


def test_the_whole_tree_is_as_itself_and_thinner_shapes_cover_less():
    tree = lone_object(TREE)
    assert (silhouette.cover_ratios(tree, tree.finest) == 1).all()
    (prototype,) = tree.placed.prototypes.prototypes
    thin = replace(prototype, leaf=prototype.leaf.thickened(np.full(len(prototype.leaf), 0.6)))
    other = replace(tree, placed=replace(tree.placed, prototype=thin))
    view = np.array((0.6, 0.0, 0.8))
    covers = [silhouette._cover(each, 2, view) for each in (other, tree)]
    assert 0.5 < covers[0] / covers[1] < 0.95


def test_sun_and_eye_go_round_the_object():
    sun, turn = np.array(light.azimuths(16)).T
    eye = np.round((sun + turn) % 360, 6)
    assert len(np.unique(sun)) == 16 and len(np.unique(turn)) == 16
    assert len(np.unique(eye)) == 8
    np.testing.assert_allclose(np.diff(np.unique(eye)), 45)


def test_darker_shapes_are_darker():
    tree = lone_object(TREE)
    (prototype,) = tree.placed.prototypes.prototypes
    dark = replace(prototype, tints=prototype.tints / 2)
    other = replace(tree, placed=replace(tree.placed, prototype=dark))
    whole, half = (light._mean_radiance(each, tree.finest) for each in (tree, other))
    for key in whole:
        assert 0.4 < half[key] / whole[key] < 0.55


def test_it_keeps_what_it_has_judged_and_judges_it_once(monkeypatch, tmp_path):
    monkeypatch.setattr(study, "cases", lambda: [TREE])
    page = tmp_path / "page.md"
    page.write_text(f"# A page\n{BEGIN}\nold\n{END}\nmore\n")
    words = ["dead_tree", "-o", str(tmp_path), "--page", str(page)]
    said = CliRunner().invoke(study.command, words)
    assert said.exit_code == 0, said.output
    assert "dead_tree, seed 5" in said.output
    found = read_findings(tmp_path / "judged.json")
    assert {each.level for each in found} == {2}
    assert [len(each.covers) for each in found] == [64] and len(found[0].radiances) == 2
    assert page.read_text() == f"# A page\n{BEGIN}\n{markdown(found)}{END}\nmore\n"
    monkeypatch.setattr(study, "judged", lambda *_: pytest.fail("judged again"))
    assert CliRunner().invoke(study.command, ["-o", str(tmp_path)]).output == said.output
    monkeypatch.setattr(study, "fit_digest", lambda: "another")
    refused = CliRunner().invoke(study.command, ["-o", str(tmp_path)])
    assert isinstance(refused.exception, InputError) and "--again" in str(refused.exception)


def test_the_page_has_the_table_of_the_record():
    root = Path(__file__).resolve().parents[3]
    text = (root / "docs" / "appearance.md").read_text(encoding="utf-8")
    found = read_findings(root / "results" / "appearance" / "judged.json")
    assert text == with_table(text, found)
    assert {each.kind for each in found} >= set(IMPORTED)


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
