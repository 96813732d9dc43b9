"""Every method has the property that its source states."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.frame_costs import Picture, window_preset
from bench.methods import known_methods as catalogue
from bench.methods.discrete_levels import (
    BAND,
    NOTHING,
    OMITTED,
    VERSIONS,
    cut_with_hysteresis,
    prepare,
    version_limits,
)
from bench.methods.known_methods import METHODS, culled_beyond, methods
from bench.methods.stochastic import (
    FADE,
    drawn_shares,
    elements_of,
    kept_objects,
    outline_areas,
)
from lod.errors import InputError
from lod.pruner import prune
from lod.shapes import triangle_areas
from lod.view import distance, in_view
from scenes import plugins
from scenes.scene import Scene

PLUGIN = Path(__file__).parents[2] / "plugin"
EXAMPLE = PLUGIN.parents[1] / "examples" / "plugin"
TINY = Picture("64x36", 1)
FEW = ("species.figure.prototypes=1", "species.figure.sizes=[1.0]", "species.tree.density=0")
GRASSLESS = "species.sward.density=0"


@pytest.fixture(scope="module")
def crowd():
    scene = Scene(window_preset("crowd", FEW, 60.0, TINY, None))
    ground = replace(scene.world.terrain, aggregate_cover=None)  # which takes minutes to measure
    return scene.with_world(replace(scene.world, terrain=ground))


@pytest.fixture(scope="module")
def trees():
    few = "species.figure.density=0", "species.tree.prototypes=2", GRASSLESS
    scene = Scene(window_preset("meadow", few, 12.0, TINY, None))
    ground = replace(scene.world.terrain, aggregate_cover=None)
    return scene.with_world(replace(scene.world, terrain=ground))


def standing(made):
    return next(each for each in made.displayed if each.name == "tree")


def trees_of(made):
    return standing(made).shape


def frame(crowd, name, setting, number=1):
    return METHODS[name].prepare(crowd, setting)(number, "scalar_rgb")


def people(made):
    return next(each for each in made.displayed if each.name == "figure")


# The unpruned reference, and culling


def test_the_unpruned_reference_is_every_part_of_everybody(crowd):
    shown = people(frame(crowd, "full", 0.0)).cut
    tree = crowd.world.fields[0].prototypes.part_tables.hierarchies[0]
    assert shown.displayed_parts == shown.displayed_objects * len(tree) > 1000


def test_what_stands_still_is_made_once_and_what_walks_is_not(crowd):
    still = window_preset("meadow", (*FEW, GRASSLESS), 5.0, TINY, None)
    for scene, same in ((Scene(still), True), (crowd, False)):
        update = METHODS["full"].prepare(scene, 0.0)
        first, second = update(1, "scalar_rgb"), update(2, "scalar_rgb")
        assert (second.displayed is first.displayed) is same


def test_culling_by_distance_keeps_the_near_whole_and_nothing_far(crowd):
    field, view = crowd.world.fields[0], replace(crowd.view(1), offscreen_detail=1.0)
    mine = culled_beyond(view, 30.0)
    kept = prune(field, mine).parts
    assert 0 < len(kept) and distance(mine, kept.position).max() < 30.0
    whole = prune(field, view).parts
    far = distance(view, whole.position[whole.parent < 0])
    reach = float(field.prototypes.part_tables.bound[0])
    assert np.count_nonzero(far < 30.0 - 2 * reach) <= np.count_nonzero(kept.parent < 0)


def test_culling_by_view_drops_what_is_out_of_it_and_nothing_else(crowd):
    """Whole objects, of which some part is in view: nobody's leaf appearance stands for parts."""
    view, field = crowd.view(1), crowd.world.fields[0]
    shown = people(frame(crowd, "in_view", 0.0)).cut
    kept, everybody = shown.parts, prune(field, view).parts
    tree = field.prototypes.part_tables.hierarchies[0]
    assert shown.displayed_parts == shown.displayed_objects * len(tree)
    roots = everybody.position[everybody.parent < 0]
    reach = float(field.prototypes.part_tables.bound[0])
    inside = in_view(view, roots, np.full(len(roots), reach))
    assert 0 < shown.displayed_objects == np.count_nonzero(inside) < len(roots)
    assert np.array_equal(kept.position[kept.parent < 0], roots[inside])


# Discrete levels


def test_a_version_is_used_until_what_the_next_leaves_out_can_be_seen():
    """By hand: a whole of 1 m with parts of 0.02 m, 0.1 m and 0.6 m, m = 0.01."""
    found = version_limits(np.array([1.0, 0.02, 0.1, 0.6]), np.zeros(4), 0.01)
    assert found == pytest.approx([100.0, 100 / 32, 100 / 8, 100.0])


@given(st.lists(st.floats(1e-3, 1.0), min_size=1, max_size=20), st.floats(1e-4, 1e-1))
def test_a_part_stays_at_least_as_long_as_the_error_asks(sizes, m):
    """No version in use leaves out a part that subtends m or more: D >= P/m, less than 32 times."""
    P = np.array([1.0, *sizes])
    D = version_limits(P, np.zeros_like(P), m)
    assert (D >= P / m * (1 - 1e-9)).all() and (D <= 1 / m * (1 + 1e-9)).all()
    assert len(set(np.round(D * m, 9))) <= len(OMITTED) - 1


def test_switching_back_and_forth_at_a_switch_changes_nothing(crowd):
    """An object that moves by less than the band about a switch keeps its version."""
    field = crowd.world.fields[0]
    view = replace(crowd.view(1), metric=VERSIONS, detail=2.0)
    first, memory = cut_with_hysteresis(field, view, NOTHING)
    for factor in (1 - BAND / 4, 1.0, 1 - BAND / 4, 1.0):
        moved = replace(view, detail=view.detail * factor)
        held, memory = cut_with_hysteresis(field, moved, memory)
    again, _ = cut_with_hysteresis(field, view, NOTHING)
    assert np.array_equal(first.object, again.object) and np.array_equal(first.part, again.part)
    assert held.displayed_parts >= first.displayed_parts
    for factor in (1 - BAND / 4, 1.0):
        moved = replace(view, detail=view.detail * factor)
        next_, memory = cut_with_hysteresis(field, moved, memory)
        assert np.array_equal(next_.part, held.part)
    wider, _ = cut_with_hysteresis(field, replace(view, detail=view.detail * 3), memory)
    assert wider.displayed_parts < held.displayed_parts


def test_a_version_is_a_connected_top_of_the_tree(crowd):
    cut = people(prepare(crowd, 2.0)(1, "scalar_rgb")).cut
    owned = cut.parent >= 0
    assert (cut.parent[owned] < np.flatnonzero(owned)).all()
    assert np.array_equal(cut.object[cut.parent[owned]], cut.object[owned])


# Stochastic simplification


@given(
    st.lists(st.tuples(st.integers(1, 300), st.floats(1e-4, 1.0)), min_size=1, max_size=12),
)
def test_a_share_of_every_object_is_drawn(objects):
    count, share = np.array([c for c, _ in objects]), np.array([s for _, s in objects])
    owner, number, left = drawn_shares(count, share)
    assert (np.diff(owner) >= 0).all() and (number < count[owner]).all()
    assert (left[share[owner] >= 1.0] == 1.0).all() and ((left >= 0.0) & (left <= 1.0)).all()
    drawn = np.bincount(owner, minlength=len(count))
    assert (np.abs(drawn - np.maximum(share * count, 1)) <= 1).all()
    assert (np.bincount(owner, left) > 0).all()


@given(st.floats(0.01, 3.0))
def test_objects_that_are_dropped_leave_their_area_to_others(expected):
    """Over many chances u the mean area is an object's own; less than u is not drawn."""
    u = (np.arange(20_000) + 0.5) / 20_000
    shown = kept_objects(np.full(len(u), expected), u)
    assert shown.mean() == pytest.approx(1.0, rel=2e-3) and (shown[u > expected] == 0).all()
    if expected >= 1 + FADE:
        assert (shown == 1).all()


def test_all_methods_are_given_the_same_beside_themselves(crowd, monkeypatch):
    """Air, fading and what is off screen: without each of them every method with a knob differs."""
    plain = {name: _drawn(crowd, name) for name in ("blake", "discrete", "stochastic")}
    view = Scene.view
    for change in ({"offscreen_detail": 1.0}, {"fade": 0.0}):
        monkeypatch.setattr(Scene, "view", lambda *of, change=change: replace(view(*of), **change))
        for name, before in plain.items():
            if (name, change) != ("stochastic", {"fade": 0.0}):  # it fades by itself
                assert _drawn(crowd, name) != before, (name, change)


def _drawn(scene, name):
    shape = people(frame(scene, name, 4.0)).shape
    return len(shape), float(shape.start_radius.sum())


def test_what_is_drawn_from_afar_is_drawn_from_near():
    """The subset is stable: fewer are a beginning of more, and the last of them have shrunk."""
    count = np.array([200])
    drawn = [drawn_shares(count, np.array([share]))[1] for share in (0.1, 0.3, 0.31)]
    for fewer, more in itertools.pairwise(drawn):
        assert np.array_equal(fewer, more[: len(fewer)])
    area = drawn_shares(count, np.array([0.3]))[2]
    assert area[-1] < 0.2 * area[0] and (np.diff(area) <= 0).all()


def test_near_sticks_are_all_drawn_as_they_are(crowd):
    whole, some = frame(crowd, "full", 0.0), frame(crowd, "stochastic", 1e-6)
    drawn, finest = people(some).shape, elements_of(crowd.world.fields[0].prototypes)
    assert len(drawn) == finest.counts[0] * people(whole).cut.displayed_objects
    ends = {tuple(np.round(row, 6)) for row in people(whole).shape.start}
    assert all(tuple(np.round(row, 6)) in ends for row in drawn.start[::97])


def test_near_trees_have_all_their_leaves_as_they_are(trees):
    whole, some = (trees_of(frame(trees, *of)) for of in (("full", 0.0), ("stochastic", 1e-6)))
    for one, other in ((whole.sticks, some.sticks), (whole.triangles, some.triangles)):
        assert len(one) == len(other) > 1000
    corners, drawn = (
        np.concatenate((each.triangles.vertices, each.triangles.colours), axis=1)
        for each in (whole, some)
    )
    order = [each[np.lexsort(np.round(each, 3).T)] for each in (corners, drawn)]
    assert order[1] == pytest.approx(order[0], abs=2e-3)


def test_fewer_elements_of_about_the_same_area_from_afar(crowd, trees):
    """Their §3.2: what is drawn is made larger, so that everybody covers as much as before."""
    for scene, of, setting in ((crowd, people, 0.5), (trees, standing, 0.5)):
        near, far = (of(frame(scene, "stochastic", each)) for each in (1e-6, setting))
        assert len(far.shape) < 0.5 * len(near.shape)
        assert covered(far) == pytest.approx(covered(near), rel=0.02)


def covered(made):
    """The mean outline area of every object, that of a leaf as a sheet's."""
    sticks, n = getattr(made.shape, "sticks", made.shape), len(made.cut)
    found = np.bincount(sticks.owner, outline_areas(sticks), n)
    if leaves := getattr(made.shape, "triangles", None):
        areas = triangle_areas(leaves.vertices, leaves.faces)
        found += np.bincount(leaves.owner, areas / 2, n)
    return found


def test_nothing_is_drawn_whole_where_others_simplify():
    scene = Scene(window_preset("forest", (GRASSLESS, "view.copies=4"), 60.0, TINY, None))
    for name in ("blake", "bare"):
        shown = METHODS[name].prepare(scene, 4.0)(1, "llvm_ad_rgb").displayed
        assert all(each.copies is None for each in shown), name


# The door


def test_a_method_of_another_package_enters(monkeypatch):
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.syspath_prepend(str(PLUGIN))
    plugins.installed.cache_clear()
    try:
        found = methods()
        assert found["nearest"].settings == (3.0, 2.0) and set(METHODS) < set(found)
    finally:
        plugins.installed.cache_clear()


def test_a_method_of_a_taken_name_is_refused(monkeypatch):
    monkeypatch.setattr(catalogue, "installed", lambda group: {"blake": None})
    with pytest.raises(InputError, match="no method has"):
        methods()
