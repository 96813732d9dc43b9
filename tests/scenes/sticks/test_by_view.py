"""Shapes that stand for hidden parts, and the height from which they are seen."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import BlendWeights, view_angles
from lod.view import View
from scenes.field.part_tables import PartTables
from scenes.ground.stand import full_detail_sticks
from scenes.rig.rigged_prototype import rigged
from scenes.sticks.areas import (
    AZIMUTHS_DEG,
    ELEVATIONS_DEG,
    TONE_STEP,
    ViewDependence,
    areas_of_parts,
    azimuth_index,
    directions,
    elevation_index,
    interpolate,
    largest_area,
    mean_outline_areas,
    tone_steps_at,
    with_area_share,
    with_tone_steps,
)
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes

SLOPE = np.linspace(0.4, 1.0, len(ELEVATIONS_DEG))
TURN = np.linspace(1.3, 0.7, len(AZIMUTHS_DEG))


def views_of(rows, share=None, by_elevation=None, by_azimuth=None):
    """One table of view dependence: shares, and tones as a product of two factors."""
    heights, sides = np.ones(len(ELEVATIONS_DEG)), np.ones(len(AZIMUTHS_DEG))
    share = heights if share is None else share
    around = sides if by_azimuth is None else by_azimuth
    up = heights if by_elevation is None else by_elevation
    tone = up[:, None] * np.append(around, around.mean())
    return ViewDependence(np.array(rows), share[None], tone[None])


def toned(prototype):
    """A prototype whose shapes are darker from below and against the sun."""
    views = prototype.view_dependence
    tone = SLOPE[:, None] * np.append(TURN, TURN.mean())
    return replace(
        prototype,
        view_dependence=replace(views, tone=np.repeat(tone[None], len(views.area_share), axis=0)),
    )


@pytest.fixture(scope="module")
def tree():
    return tree_prototypes(3, 1, tree_species("conifer"))[0]


def seen_from(prototype, height, row=0):
    """Sticks that one part shows as a leaf, and the colour of each."""
    part_tables = PartTables.of((rigged(prototype),))
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
    steps = views_of([0], by_azimuth=TURN).tone_steps[0]
    found = tone_steps_at(steps, 0.0, azimuth_index(math.cos(math.radians(degrees))))
    expected = np.interp(degrees, AZIMUTHS_DEG, np.log(TURN / TURN.max()))
    assert found * math.log(TONE_STEP) == pytest.approx(expected, abs=1e-6)


@given(st.floats(0, 90))
def test_between_two_heights_tones_go_evenly_with_the_angle(degrees):
    steps = views_of([0], by_elevation=SLOPE).tone_steps[0]
    found = tone_steps_at(steps, elevation_index(math.sin(math.radians(degrees))), 2.5)
    expected = np.interp(degrees, ELEVATIONS_DEG, np.log(SLOPE))
    assert found * math.log(TONE_STEP) == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize("degrees", [0.0, 90.0, 150.0])
def test_shapes_are_as_bright_toward_each_side_as_their_table_says(tree, degrees):
    part_tables = PartTables.of((rigged(toned(tree)),))
    limbs = np.flatnonzero(tree.hierarchy.level == 1)
    one, turn = np.ones(len(limbs)), math.cos(math.radians(degrees))
    seen, plain = (
        part_tables.sticks_of(limbs, BlendWeights(0 * one, one, 0 * one, each * one))
        for each in (turn, np.nan)
    )
    dark = tree.view_dependence.table_row[np.isin(tree.leaf.owner, limbs)] >= 0
    ours, mean = (
        np.log(part_tables.tints[each.tint].sum(axis=1))[dark].mean() for each in (seen, plain)
    )
    wanted = np.exp(np.interp(degrees, AZIMUTHS_DEG, np.log(TURN))) / TURN.mean()
    assert np.exp(ours - mean) == pytest.approx(wanted, rel=0.01)
    assert np.array_equal(seen.share, plain.share)


@pytest.mark.parametrize("degrees", [0.0, 20.0, 60.0, -60.0])
def test_shapes_are_thinned_and_darkened_as_their_table_says(tree, degrees):
    views, height = tree.view_dependence, math.sin(math.radians(degrees))
    found, colours = seen_from(toned(tree), height)
    first, last = tree.leaf.first[:2]
    blobs = views.table_row[first:last] >= 0
    share = np.interp(abs(degrees), ELEVATIONS_DEG, views.area_share[0])
    tone = np.exp(np.interp(max(degrees, 0), ELEVATIONS_DEG, np.log(SLOPE))) * TURN.mean()
    assert found.share == pytest.approx(np.where(blobs, share, 1.0))
    own = tree.tints[tree.leaf.tint[first:last]]
    assert colours[~blobs] == pytest.approx(own[~blobs])
    darker = (colours / own)[blobs]
    assert darker == pytest.approx(tone, rel=1.001 * (1 / TONE_STEP - 1))


def test_between_two_tones_sticks_share_themselves_out(tree):
    """So that many of them are as bright as they should be on average, not in steps."""
    limbs = np.flatnonzero(tree.hierarchy.level == 1)
    blobs = tree.view_dependence.table_row[np.isin(tree.leaf.owner, limbs)] >= 0
    lit, plain = (PartTables.of((rigged(each),)) for each in (toned(tree), tree))
    for degrees in (12.0, 17.0, 23.0):
        rise, one = np.full(len(limbs), math.sin(math.radians(degrees))), np.ones(len(limbs))
        shown = [each.sticks_of(limbs, BlendWeights(0 * one, one, rise)) for each in (lit, plain)]
        ours, own = (
            each.tints[sticks.tint].sum(axis=1)
            for each, sticks in zip((lit, plain), shown, strict=True)
        )
        tone = np.exp(np.interp(degrees, ELEVATIONS_DEG, np.log(SLOPE))) * TURN.mean()
        assert np.exp(np.log(ours / own)[blobs].mean()) == pytest.approx(tone, rel=0.006)


def test_priority_is_of_the_tree_as_it_looks(tree):
    """P² is less than the shapes would cover if never thinned, and near the tree's own."""
    own = areas_of_parts(full_detail_sticks(tree)[0], directions()[::4]).max()
    assert tree.hierarchy.P[0] ** 2 < 0.97 * largest_area(tree.leaf)[0]
    assert tree.hierarchy.P[0] ** 2 == pytest.approx(own, rel=0.12)


def test_tones_that_are_too_bright_from_one_side_are_right_from_the_others():
    """A light tint at 2.5 times its albedo overhead, where no albedo is above 1, and at 1 level."""
    brighter = np.linspace(1.0, 2.5, len(ELEVATIONS_DEG))
    views = views_of([0], by_elevation=brighter)
    tint, palette = with_tone_steps(np.array([0]), np.array([[0.7, 0.7, 0.5]]), views)
    last = palette[tint[0] + math.ceil(math.log(1 / 2.5) / math.log(TONE_STEP))]
    assert last == pytest.approx(np.array([0.7, 0.7, 0.5]), rel=1 - TONE_STEP)
    assert palette.max() == 1.0


@given(st.floats(0.05, 1.0))
def test_thinned_sticks_cover_their_share(tree, share):
    """Of each stick's mean outline; cones a little off, as thinning leaves out a term of theirs."""
    areas = mean_outline_areas(with_area_share(tree.leaf, share)) / mean_outline_areas(tree.leaf)
    assert areas == pytest.approx(np.full(len(areas), share), rel=0.1)
