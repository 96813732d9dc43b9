"""Leaf appearances send the light of what they hide: their colour is less by what shades itself."""

from dataclasses import replace

import numpy as np
import pytest

from bench.calibrate.canopy_light import calibration_trees, cut_at_level, outgoing
from bench.calibrate.leaf_light import albedo_factors, azimuth_tones
from scenes.models.catalogue import model_prototypes
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.tree import tree_prototypes
from scenes.preset.load import load_preset
from scenes.sticks.outline_area import mean_outline_areas
from scenes.sticks.view_angles import AZIMUTHS_DEG

_SHRUB = tree_species("shrub")
SHRUB = replace(_SHRUB, tables=replace(_SHRUB.tables, azimuth_tone=()))
"""As it looks from all sides together."""


@pytest.fixture(scope="module")
def trees():
    return tree_prototypes(1, 3, SHRUB)


@pytest.fixture(scope="module")
def unshaded():
    return tree_prototypes(1, 3, SHRUB.uncorrected())


def shapes(tree, level):
    """Mean albedo of the shapes that stand for what is hidden, by their area."""
    table, hides = cut_at_level(tree, SHRUB, level)
    area, colour = mean_outline_areas(table)[hides], tree.tints[table.tint][hides]
    return area @ colour / area.sum()


def test_a_cut_at_the_finest_level_hides_nothing_and_others_do(trees):
    h = trees[0].hierarchy
    for level in range(int(h.level.max()) + 1):
        table, hides = cut_at_level(trees[0], SHRUB, level)
        assert hides.any() == (level < h.level.max())
        assert (np.diff(table.first) == len(hides)).all()


@pytest.mark.parametrize("level", range(4))
def test_shapes_are_as_much_darker_as_the_species_says(trees, unshaded, level):
    for shaded, plain in zip(trees, unshaded, strict=True):
        assert np.array_equal(shaded.hierarchy.P, plain.hierarchy.P), "no shape moves"
        share = (shapes(shaded, level) / shapes(plain, level)).mean()
        # Colour is shared out by what is seen; of the few shapes of a whole tree the rest is much.
        assert share == pytest.approx(
            SHRUB.tables.albedo_factor[level], rel=0.045 if level else 0.15
        )


@pytest.mark.slow
def test_the_species_say_what_is_measured():
    for name in ("shrub", "birch"):
        assert albedo_factors(tree_species(name), "summer") == pytest.approx(
            tree_species(name).tables.albedo_factor, rel=0.01
        )
    dead, birch = tree_species("dead_tree"), tree_species("birch")
    assert albedo_factors(dead, "winter") == pytest.approx(dead.tables.albedo_factor, rel=0.01)
    assert albedo_factors(birch, "winter") == pytest.approx(
        birch.bare_tables.albedo_factor, rel=0.01
    )


@pytest.mark.parametrize("preset", ["aerial", "forest"])
@pytest.mark.parametrize("name", ["broadleaf", "birch", "conifer", "shrub"])
def test_what_is_measured_are_the_trees_that_worlds_have(preset, name):
    table = load_preset(preset).species[name]
    theirs = model_prototypes(table.model, table.prototypes, (1.0,), walks=False)
    for mine, each in zip(
        calibration_trees(tree_species(table.model), "summer"), theirs, strict=True
    ):
        assert np.array_equal(mine.hierarchy.position, each.hierarchy.position)


def test_one_share_for_all_sides_is_too_much_against_the_sun_and_too_little_with_it():
    """And it lies between them."""
    by_turn = azimuth_tones(SHRUB, 0, lines=2000)
    assert by_turn.shape == (len(AZIMUTHS_DEG),)
    assert by_turn[0] > 1.1 > 1.0 > 0.9 > by_turn[-1]


@pytest.mark.slow
def test_the_species_say_how_much_light_is_sent_to_each_side():
    shrub = tree_species("shrub")
    for level in (0, 3):
        assert azimuth_tones(shrub, level) == pytest.approx(
            np.array(shrub.tables.azimuth_tone[level]), abs=0.006
        )


def test_a_stand_sends_as_much_at_every_level(trees):
    finest = int(trees[0].hierarchy.level.max())
    made = [outgoing(trees, SHRUB, level, lines=2000) for level in range(finest + 1)]
    total = np.array([each.total.sum() for each in made])
    assert total[:-1] / total[-1] == pytest.approx(np.ones(finest), abs=0.05)
