"""."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import lod.metric
from lod.camera import Corner, camera_from_heading
from lod.eye import CONTRAST_CLASSES
from lod.hierarchy import Hierarchy
from lod.law import (
    LIMITS,
    chained_limits,
    count_moments,
    count_variance,
    disc_areas,
    expected_count,
    ground_nodes,
)
from lod.metric import METRICS, limit_distances
from lod.view import View
from lod.viewing import BlurWidths, ViewingConditions, WeightedDistance

AREAS = st.lists(st.floats(0, 1e6), min_size=1, max_size=30).map(np.array)


def test_every_built_in_metric_with_a_law_has_a_formula_of_its_own_here():
    assert set(LIMITS) == {name for name, each in METRICS.items() if not each.along_axis}
    for name, formula in LIMITS.items():
        assert formula is not METRICS[name].limit


def tree_of(seed, parts=20):
    """A random tree; parts are often larger than what owns them, so that the clamp matters."""
    chance = np.random.default_rng(seed)
    whole = np.array([-1] + [int(chance.integers(0, i)) for i in range(1, parts)])
    position = np.cumsum(chance.normal(0, 1, (parts, 3)), axis=0) * 0.3
    separation = np.linalg.norm(position - position[np.maximum(whole, 0)], axis=1)
    P, R = chance.lognormal(0, 1, parts), chance.lognormal(0, 1, parts)
    B = R + P
    level = np.zeros(parts, int)
    for i in range(parts - 1, 0, -1):
        B[whole[i]] = max(B[whole[i]], separation[i] + B[i])
    for i in range(1, parts):
        level[i] = level[whole[i]] + 1
    contrast = chance.integers(0, len(CONTRAST_CLASSES), parts)
    to_whole = chance.uniform(0.1, 1, parts)
    return Hierarchy(whole, level, position, P, R, B, separation, contrast, to_whole)


def test_a_disc_by_hand():
    assert disc_areas(np.array([5.0, 1.0]), np.array([3.0, 2.0])) == pytest.approx(
        [16 * math.pi, 0.0]
    )
    assert expected_count(0.5, np.array([16.0, 4.0])) == 10.0


@given(AREAS)
def test_variance_is_the_double_sum(areas):
    double = np.minimum.outer(areas, areas).sum()
    assert count_variance(0.3, areas) == pytest.approx(0.3 * double)


SIGHTS = st.none() | st.builds(
    ViewingConditions,
    st.builds(BlurWidths, st.floats(1e-3, 0.5), st.floats(0, 1), st.floats(0, 0.1)),
    st.floats(0, 0.5),
    acuity=st.booleans(),
)


@settings(max_examples=20)
@given(seed=st.integers(0, 10**6), m=st.floats(1e-3, 0.5), sight=SIGHTS)
def test_limits_by_chains_agree_with_the_pruners(seed, m, sight):
    tree = tree_of(seed)
    for name in LIMITS:
        assert chained_limits(tree, METRICS[name], m, sight) == pytest.approx(
            limit_distances(tree, METRICS[name], m, sight)
        )


def test_the_law_does_not_ask_the_pruner_how_far_one_sees(monkeypatch):
    """It turns W round by itself: what the pruner does with the inverse has no bearing on it."""
    tree, sight = tree_of(1), ViewingConditions(BlurWidths(0.01), 0.05)
    before = chained_limits(tree, METRICS["blake"], 0.01, sight)
    assert (before < chained_limits(tree, METRICS["blake"], 0.01)).any()
    monkeypatch.setattr(WeightedDistance, "inverse", lambda *_: 1 / 0)
    monkeypatch.setattr(lod.metric, "perceptual_limits", lambda *_: 1 / 0)
    monkeypatch.setattr(lod.metric, "seen_by_contrast", lambda *_: 1 / 0)
    assert (chained_limits(tree, METRICS["blake"], 0.01, sight) == before).all()
    weighted = chained_limits(tree, METRICS["contrast_weighted"], 0.01, sight)
    assert (weighted <= before).all() and (weighted < before).any()


@pytest.mark.parametrize("name", ["blake", "solid_angle", "contrast_weighted"])
@pytest.mark.parametrize("air", [None, 0.02])
def test_the_net_gives_the_closed_form_on_flat_ground(name, air):
    tree = tree_of(3)
    camera = camera_from_heading(Corner(0, 0), np.array([4.0, 5.0, 1.7]), 0.0, 0.0, 60.0, (64, 36))
    sight = air and ViewingConditions(BlurWidths(camera.pixel_angle), air, acuity=False)
    view = View(camera, METRICS[name], look_around=True, conditions=sight)
    net = ground_nodes((tree,), view, 400 * 400)
    found = count_moments((tree,), view, net, np.zeros(len(net.area)))
    areas = disc_areas(
        chained_limits(tree, METRICS[name], view.m, sight), 1.7 - tree.position[:, 2]
    )
    assert found.objects == pytest.approx(areas[0], rel=2e-4)
    assert found.parts == pytest.approx(areas.sum(), rel=2e-4)
    assert found.parts_variance == pytest.approx(count_variance(1.0, areas), rel=5e-3)
    assert sum(found.parts_by_level) == pytest.approx(found.parts)


def test_a_view_holds_its_share_of_the_turn():
    """A small object far away: φ/2π of the disc in view, and the coarser disc out of it."""
    tree = Hierarchy(
        np.array([-1]),
        np.array([0]),
        np.zeros((1, 3)),
        *(np.array([x]) for x in (1.0, 0.0, 1e-6, 0.0)),
    )
    camera = camera_from_heading(
        Corner(0, 0), np.array([0.0, 0.0, 1e-3]), 30.0, 0.0, 60.0, (64, 6400)
    )
    view = View(camera, METRICS["blake"])
    net = ground_nodes((tree,), view, 200 * 600)
    found = count_moments((tree,), view, net, np.zeros(len(net.area)))
    D = 1.0 / view.m
    assert found.objects == pytest.approx(math.pi * D**2 * (1 / 6 + 5 / 6 / 16), rel=5e-4)


def parts_at(node, turn, tree, view):
    """Which parts of an object at a node are displayed, each by its own test alone."""
    c, s = math.cos(turn), math.sin(turn)
    position = tree.position @ np.array(((c, s, 0), (-s, c, 0), (0, 0, 1))) + node - view.camera.eye
    camera, seen = view.camera, np.ones(len(tree), bool)
    tan_x, tan_y = camera.tan_half
    planes = [camera.forward]
    for axis, tangent in ((camera.right, tan_x), (camera.up, tan_y)):
        planes += [(camera.forward * tangent + k * axis) / math.hypot(1, tangent) for k in (-1, 1)]
    for plane in planes:
        seen &= position @ plane > -tree.B
    m = np.where(seen | view.look_around, view.m, max(view.m, view.m_offscreen))
    limits = {each: chained_limits(tree, view.metric, each, view.conditions) for each in set(m)}
    limit = np.array([limits[each][k] for k, each in enumerate(m)])
    return np.linalg.norm(position, axis=1) < limit


@pytest.mark.parametrize("look_around", [False, True])
def test_the_integral_tests_every_part_at_every_node_by_itself(look_around):
    """However few of the tests it makes: what is surely displayed, or not, is not tested."""
    tree = tree_of(3)
    camera = camera_from_heading(
        Corner(0, 0), np.array([4.0, 5.0, 1.7]), 20.0, -5.0, 40.0, (64, 36)
    )
    sight = ViewingConditions(BlurWidths(camera.pixel_angle), 0.02, acuity=False)
    view = View(camera, METRICS["blake"], look_around=look_around, conditions=sight)
    net = ground_nodes((tree,), view, 16 * 12)
    height = np.sin(net.xy[:, 0])
    found = count_moments((tree,), view, net, height)
    nodes = np.column_stack((net.xy, height))
    shown = np.array([parts_at(n, t, tree, view) for n, t in zip(nodes, net.turn, strict=True)])
    count = shown.sum(axis=1)
    assert 0 < count.min() + shown.any(axis=1).sum() < shown.size  # some tests go either way
    assert found.objects == pytest.approx(net.area @ shown[:, 0], rel=1e-12)
    assert found.parts == pytest.approx(net.area @ count, rel=1e-12)
    assert found.parts_variance == pytest.approx(net.area @ count**2, rel=1e-12)
    by_level = [
        net.area @ shown[:, tree.level == k].sum(axis=1) for k in range(tree.level.max() + 1)
    ]
    assert found.parts_by_level == pytest.approx(by_level, rel=1e-12)
