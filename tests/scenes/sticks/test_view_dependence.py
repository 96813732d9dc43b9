"""Shapes that stand for hidden parts, and the height from which they are seen."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.calibrate.leaf_light import elevation_table
from lod.camera import Corner, camera_from_heading
from lod.errors import InputError
from lod.metric.family import METRICS
from lod.pruning.crossfade import view_angles
from lod.pruning.parts import BlendWeights
from lod.pruning.view import View
from scenes.far_cover.stand_appearance import full_detail_sticks
from scenes.field.part_tables import PartTables
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.tree import tree_prototypes
from scenes.rig.rigged_prototype import rigid_prototype
from scenes.sticks.outline_area import directions, largest_area, mean_outline_areas
from scenes.sticks.prototype import Prototype
from scenes.sticks.tone_steps import with_tone_steps
from scenes.sticks.union_area import areas_of_parts
from scenes.sticks.view_angles import (
    AZIMUTHS_DEG,
    ELEVATIONS_DEG,
    azimuth_index,
    azimuth_tone,
    elevation_index,
    interpolate,
)
from scenes.sticks.view_dependence import CONSTANT, TONE_STEP, ElevationTable, ViewDependence
from scenes.sticks.view_dependent_area import with_area_share

SLOPE = tuple(np.linspace(0.4, 1.0, len(ELEVATIONS_DEG)).tolist())


@pytest.fixture(scope="module")
def tree():
    return tree_prototypes(3, 1, tree_species("conifer"))[0]


def seen_from(prototype, height, row=0):
    """Sticks that one part shows as a leaf, and the colour of each."""
    part_tables = PartTables.of((rigid_prototype(prototype),))
    one = np.ones(1)
    found = part_tables.sticks_of(np.array([row]), BlendWeights(0 * one, one, height * one))
    return found, part_tables.tints[found.tint]


@given(st.floats(0, 90))
def test_between_two_heights_looks_go_evenly_with_the_angle(degrees):
    found = interpolate(np.array(SLOPE), elevation_index(math.sin(math.radians(degrees))))
    assert found == pytest.approx(0.4 + 0.6 * degrees / 90, abs=1e-6)


def test_the_eye_rises_by_the_sine_of_its_angle():
    camera = camera_from_heading(Corner(0, 0), np.array((3.0, 0.0, 4.0)), 0, 0, 60.0, (100, 100))
    points = camera.eye - np.array(
        [(3.0, 0.0, 4.0), (0.0, 0.0, 2.0), (1.0, 1.0, 0.0), (0, 0, -1), (0, 0, 0)]
    )
    found, turn = view_angles(points, View(camera, METRICS["blake"]))
    assert found == pytest.approx([0.8, 1.0, 0.0, -1.0, 0.0])
    assert np.isnan(turn).all(), "nobody said where the sun stands"


def test_the_eye_turns_from_the_sun():
    """With the sun in the east: who looks west, east, steeply to the east, north, and down."""
    camera = camera_from_heading(Corner(0, 0), np.array((1.0, 2.0, 30.0)), 0, 0, 60.0, (100, 100))
    away = np.array([(-5.0, 0, 0), (4.0, 0, 0), (3.0, 0, -4.0), (0, 3.0, 9.0), (0, 0, -7.0)])
    _, turn = view_angles(camera.eye + away, View(camera, METRICS["blake"], sun=(1.0, 0.0)))
    assert turn == pytest.approx([1.0, -1.0, -0.6, 0.0, 0.0])


@given(st.floats(0, 180))
def test_between_two_sides_tones_go_evenly_with_the_angle(degrees):
    tones = (1.3, 1.2, 1.1, 1.05, 1.0, 0.9, 0.8, 0.75, 0.7)
    view_dependence = ViewDependence.from_tables(np.array([0]), (CONSTANT,), (tones,))
    at = azimuth_index(math.cos(math.radians(degrees)))
    steps = azimuth_tone(view_dependence.azimuth_steps[0], at)
    expected = np.interp(degrees, AZIMUTHS_DEG, np.log(np.array(tones) / 1.3))
    assert steps * math.log(TONE_STEP) == pytest.approx(expected, abs=1e-6)


def test_from_all_sides_alike_tones_are_their_mean():
    view_dependence = ViewDependence.from_tables(
        np.array([0]), (CONSTANT,), (tuple(np.linspace(1.3, 0.7, len(AZIMUTHS_DEG))),)
    )
    steps = azimuth_tone(view_dependence.azimuth_steps[0], azimuth_index(math.nan))
    assert TONE_STEP**steps == pytest.approx(1 / 1.3)
    plain = ViewDependence.from_tables(np.array([0]), (CONSTANT,))
    assert (plain.azimuth_steps == 0).all()


@pytest.mark.parametrize("degrees", [0.0, 90.0, 150.0, None])
def test_shapes_are_as_bright_as_the_species_says_toward_each_side(degrees):
    """Over what they are where all sides are alike."""
    shrub = tree_prototypes(3, 1, tree_species("shrub"))[0]
    part_tables = PartTables.of((rigid_prototype(shrub),))
    limbs = np.flatnonzero(shrub.hierarchy.level == 1)
    one = np.ones(len(limbs))
    turn = np.nan if degrees is None else math.cos(math.radians(degrees))
    seen, plain = (
        part_tables.sticks_of(limbs, BlendWeights(0 * one, one, 0 * one, each * one))
        for each in (turn, np.nan)
    )
    ours, mean = (np.log(part_tables.tints[each.tint].sum(axis=1)).mean() for each in (seen, plain))
    wanted = (
        1.0
        if degrees is None
        else np.interp(degrees, AZIMUTHS_DEG, tree_species("shrub").tables.azimuth_tone[1])
    )
    assert np.exp(ours - mean) == pytest.approx(wanted, rel=0.01)
    assert np.array_equal(seen.share, plain.share)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0, -60.0])
def test_shapes_are_thinned_and_darkened_as_the_species_says(tree, degrees):
    species, height = tree_species("conifer"), math.sin(math.radians(degrees))
    found, colours = seen_from(tree, height)
    (first, last), kept = tree.leaf.first[:2], species.leaf_appearance.kept_segments[0]
    share = np.interp(abs(degrees), ELEVATIONS_DEG, species.tables.elevation[0].area_share)
    tone = np.interp(max(degrees, 0), ELEVATIONS_DEG, species.tables.elevation[0].albedo_factor)
    tone /= max(species.tables.azimuth_tone[0])
    assert found.share == pytest.approx([1.0] * kept + [share] * (last - first - kept))
    own = tree.tints[tree.leaf.tint[first:last]]
    assert colours[:kept] == pytest.approx(own[:kept])
    darker = (colours / own)[kept:]
    assert darker == pytest.approx(tone, rel=1.001 * (1 / TONE_STEP - 1))


def test_between_two_tones_sticks_share_themselves_out(tree):
    """So that many of them are as bright as they should be on average, not in steps."""
    limbs = np.flatnonzero(tree.hierarchy.level == 1)
    part_tables = PartTables.of((rigid_prototype(tree),))
    plain = PartTables.of((rigid_prototype(replace(tree, view_dependence=ViewDependence())),))
    for degrees in (12.0, 17.0, 23.0):
        rise, one = np.full(len(limbs), math.sin(math.radians(degrees))), np.ones(len(limbs))
        shown = [
            each.sticks_of(limbs, BlendWeights(0 * one, one, rise)) for each in (part_tables, plain)
        ]
        ours, own = (
            each.tints[sticks.tint].sum(axis=1)
            for each, sticks in zip((part_tables, plain), shown, strict=True)
        )
        tone = np.interp(
            degrees, ELEVATIONS_DEG, tree_species("conifer").tables.elevation[1].albedo_factor
        )
        tone /= max(tree_species("conifer").tables.azimuth_tone[1])
        assert np.exp(np.log(ours / own).mean()) == pytest.approx(tone, rel=0.004)


def test_what_minds_no_height_looks_the_same_from_all():
    shrub = tree_prototypes(3, 1, tree_species("shrub"))[0]
    a, b = (seen_from(shrub, height)[0] for height in (0.0, 1.0))
    for name in a._fields:
        assert np.array_equal(getattr(a, name), getattr(b, name))


def test_priority_is_of_the_tree_as_it_looks(tree):
    """P² is less than the shapes would cover if never thinned, and near the tree's own."""
    own = areas_of_parts(full_detail_sticks(tree)[0], directions()[::4]).max()
    assert tree.hierarchy.P[0] ** 2 < 0.97 * largest_area(tree.leaf)[0]
    assert tree.hierarchy.P[0] ** 2 == pytest.approx(own, rel=0.12)


def test_tables_of_several_prototypes_lie_end_to_end(tree):
    one = tree.view_dependence
    both = ViewDependence.concatenate(
        [one, ViewDependence(), one], [len(tree.leaf), 3, len(tree.leaf)]
    )
    k, c = len(tree.leaf), len(one.area_share)
    assert np.array_equal(both.table_row[:k], one.table_row)
    assert (both.table_row[k : k + 3] == -1).all()
    assert np.array_equal(
        both.table_row[k + 3 :], np.where(one.table_row < 0, -1, one.table_row + c)
    )
    assert len(both.area_share) == 2 * c


def test_all_tones_of_a_tint_follow_it():
    looks = ElevationTable(SLOPE, SLOPE)
    view_dependence = ViewDependence.from_tables(np.array([-1, 0, 0, -1]), (looks,))
    tints = np.array([[0.2, 0.4, 0.1], [0.6, 0.5, 0.4]])
    tint, palette = with_tone_steps(np.array([0, 0, 1, 1]), tints, view_dependence)
    assert tint[[0, 3]].tolist() == [0, 1]
    steps = math.ceil(math.log(0.4) / math.log(TONE_STEP))
    for stick, own in ((1, 0), (2, 1)):
        block = palette[tint[stick] : tint[stick] + steps + 1]
        assert block == pytest.approx(tints[own] * TONE_STEP ** np.arange(steps + 1)[:, None])


@given(st.floats(0.05, 1.0))
def test_thinned_sticks_cover_their_share(tree, share):
    """Of each stick's mean outline; cones a little off, as thinning leaves out a term of theirs."""
    areas = mean_outline_areas(with_area_share(tree.leaf, share)) / mean_outline_areas(tree.leaf)
    assert areas == pytest.approx(np.full(len(areas), share), rel=0.1)


def test_rows_that_do_not_fit_the_sticks_are_refused(tree):
    for rows in (np.zeros(3), np.full(len(tree.leaf), 7)):
        with pytest.raises(InputError, match="view_dependence"):
            view_dependence = replace(tree.view_dependence, table_row=rows)
            Prototype(tree.name, tree.hierarchy, tree.inner, tree.leaf, tree.tints, view_dependence)


@pytest.mark.slow
@pytest.mark.parametrize("level", [0, 1, 2])
def test_the_conifer_says_what_is_measured(level):
    """To two decimals: paths of light are drawn from one seed. (Others, and fewer, give tones that
    differ by up to 9 %.)"""
    species = tree_species("conifer")
    factor, looks = elevation_table(species, level)
    assert factor == pytest.approx(species.tables.albedo_factor[level], rel=0.002)
    assert looks.area_share == pytest.approx(species.tables.elevation[level].area_share, abs=0.006)
    assert looks.albedo_factor == pytest.approx(
        species.tables.elevation[level].albedo_factor, abs=0.006
    )
