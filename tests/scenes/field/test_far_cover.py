"""What lies beyond the limit leaves its cover, colour and height on the ground."""

from dataclasses import replace

import numpy as np
import pytest

from lod.shapes import StickTable
from scenes.appearance.sky import SKY_COLUMNS, SKY_ROWS, Sky, sky_at
from scenes.field.far_cover import AggregateCover
from scenes.field.species_field import Habitat, Species
from scenes.ground import stand as stand_appearance
from scenes.ground.relief import Relief
from scenes.ground.stand import DEPRESSIONS_DEG, measure_stand, randoms_per_path
from scenes.presets.load import load_preset
from scenes.scene import Scene
from scenes.sticks.prototype import PartPlaces, assemble_prototype

GREY = 0.2


def ball(z=3.0, r=1.0, tint=GREY):
    """A whole of one part: a ball above the ground."""
    centre = np.array(((0.0, 0.0, z),))
    radius = np.array((r,))
    table = StickTable(
        np.array((0, 1)), centre, centre + np.array((1e-3, 0.0, 0.0)), radius, radius, np.zeros(1)
    )
    nothing = StickTable(np.array((0, 0)), *np.zeros((2, 0, 3)), *np.zeros((2, 0)), np.zeros(0))
    flat = PartPlaces(np.array((-1,)), np.array((0,)), centre)
    return assemble_prototype("ball", flat, nothing, table, np.full((1, 3), tint))


def test_a_stand_is_measured_once_and_again_where_anything_else_is_asked(monkeypatch, tmp_path):
    """Within a process, and in the cache folder for the next; nothing else is taken for it."""
    monkeypatch.setenv("LODBENCH_CACHE", str(tmp_path))
    traced = []

    def note(*words):
        traced.append(words[3])
        return trace(*words)

    trace = stand_appearance.trace_lines
    monkeypatch.setattr(stand_appearance, "trace_lines", note)
    sky = Sky(np.full((SKY_ROWS, SKY_COLUMNS, 3), 0.5))
    found = []
    for density, elevation in ((0.01, 50.0), (0.01, 50.0), (0.02, 50.0), (0.01, 40.0)):
        measure_stand.cache_clear()
        found.append(measure_stand((((ball(2.0),), density),), elevation, sky, lines=50))
    assert len(traced) == 3 * len(DEPRESSIONS_DEG)
    assert np.array_equal(found[0].radiance, found[1].radiance)
    assert not np.array_equal(found[0].radiance, found[2].radiance)
    assert not np.array_equal(found[0].radiance, found[3].radiance)


@pytest.mark.parametrize(("sky", "direct", "from_ground"), [(0.0, 2 / 3, 0.0), (1.0, 5 / 6, 1 / 6)])
def test_a_thin_stand_of_balls_is_lit_as_lambert_says(sky, direct, from_ground):
    """From overhead under an overhead sun the mean cosine over the disc is 2/3; of an even sky the
    ball sees (1 + cos)/2, and of the ground, which the sky lights, the rest."""
    stand = measure_stand(
        (((ball(9.0),), 0.004),), 90.0, Sky(np.full((SKY_ROWS, SKY_COLUMNS, 3), sky)), lines=50_000
    )
    assert stand.area[0] == pytest.approx(np.full(len(DEPRESSIONS_DEG), np.pi), rel=0.02)
    few = pytest.approx(GREY * direct, rel=0.1)
    assert stand.radiance[0, :, :, 0].mean(axis=1)[-1] == few
    if sky:
        assert stand.ground_bounce[0, -1].mean() == pytest.approx(GREY * from_ground, rel=0.3)
    assert stand.ground[-1].min() > (0.97 if sky else 0.999)
    assert (stand.height >= 0).all() and (stand.height <= 10).all()


def test_light_is_followed_as_far_as_the_preset_says():
    """A dense stand of white balls is brighter the more bounces count, and never unlit."""
    kinds = (((ball(1.0, 1.0, tint=1.0),), 0.3),)
    sky = Sky(np.full((SKY_ROWS, SKY_COLUMNS, 3), 1.0))
    seen = [
        measure_stand(kinds, 60.0, sky, max_depth, lines=500).radiance.mean()
        for max_depth in (1, 2, 3, 4, 12)
    ]
    assert seen[0] == seen[1] and (np.diff(seen[1:]) > 0.01).all()
    assert [randoms_per_path(depth) for depth in (1, 2, 4, 64)] == [2, 2, 6, 126]
    preset = load_preset("meadow", ["render.max_depth=7"])
    assert Scene(preset).world.terrain.aggregate_cover.max_depth == 7


@pytest.fixture(scope="module")
def covered():
    keys = ["render.size=640x360", "camera.height=60", "air.visibility=clear", "view.detail=12"]
    balls = Species("balls", (ball(4.0, 2.0),), 0.02)
    preset = load_preset("meadow", keys)
    cover = AggregateCover((balls,), np.array((0.6, 0.0, 0.8)), sky_at(53.0, 3.0))
    return cover, Scene(preset).view(1)


def ground(view, distances):
    x, y = view.camera.forward[:2] / np.hypot(*view.camera.forward[:2])
    along = np.sqrt(np.maximum(distances**2 - 50.0**2, 0))
    return view.camera.eye + np.column_stack((x * along, y * along, np.full(len(along), -50.0)))


def test_nothing_is_left_where_nothing_is_missing_and_it_runs_on_smoothly(covered):
    cover, view = covered
    D = view.limits(cover.species[0].prototypes[0].hierarchy)[0][0]
    points = ground(view, np.linspace(60.0, 2 * D, 4000))
    bare, up = np.full((4000, 3), 0.1), np.tile((0.0, 0.0, 1.0), (4000, 1))
    left = cover.residual(view, points)
    lift, colours = left.lift, left.colours(up, bare)
    near = np.linalg.norm(points - view.camera.eye, axis=1) <= D * (1 - view.fade)
    assert near.any() and not near.all()
    assert (lift[near] == 0).all() and np.array_equal(colours[near], bare[near])
    assert (left.covered[near] == 0).all() and 0 < left.covered.max() < 1
    assert (lift[~near][1:] > 0).all() and lift.max() <= 6.0
    assert np.abs(np.diff(lift)).max() < 0.05 and np.abs(np.diff(colours, axis=0)).max() < 2e-3
    assert np.isfinite(colours).all() and colours.min() >= 0 and colours.max() <= 1


def test_what_is_displayed_is_buried_where_the_ground_is_lifted_and_painted_on_it(covered):
    view, kinds = covered[1], (ball(1.0, 1.0), ball(4.0, 2.0))
    cover = replace(covered[0], species=(Species("balls", kinds, 0.04),))
    D = view.limits(kinds[1].hierarchy)[0][0]
    points = ground(view, np.linspace((1 - view.fade) * D, D, 200))
    left, gone = cover.residual(view, points), np.multiply(*cover.undisplayed(view, points))[:, 0]
    assert gone[0] == pytest.approx(0.2, abs=0.01) and gone[-1] == pytest.approx(1.0)
    above = np.interp(left.lift, cover.stand.levels, cover.stand.above)
    assert left.lines.share == pytest.approx(1 - (1 - gone) * above)
    assert (left.lines.share - gone).max() > 0.05 and above.min() < 0.9


def test_the_share_of_outlines_above_a_height_falls_from_all_to_none(covered):
    """All of a stand of balls 2 m in radius, 4 m up, is where their middles are."""
    stand = covered[0].stand
    assert stand.above[0] == pytest.approx(1.0) and stand.above[-1] > 0
    assert (np.diff(stand.above) <= 0).all() and stand.levels[-1] == pytest.approx(4.0)


def test_where_half_of_it_grows_half_of_it_is_left(covered):
    cover, view = covered
    # So high above the flat datum that half of it has thinned out.
    habitat = Habitat(Relief(1, 0.0, 64.0, 0.9), highest=50.0, thinning=100.0)
    half = replace(cover, species=(replace(cover.species[0], habitat=habitat),))
    D = view.limits(cover.species[0].prototypes[0].hierarchy)[0][0]
    points = ground(view, np.linspace((1 - view.fade) * D, 1.5 * D, 100))
    left, all_over = half.residual(view, points), cover.residual(view, points)
    assert np.allclose(left.lines.share + left.lines.rest, 0.5)
    far = all_over.rows[all_over.lines.share == 1]
    assert np.allclose(
        np.multiply(*half.undisplayed(view, points)),
        np.multiply(*cover.undisplayed(view, points)) / 2,
    )
    assert (left.covered[far] < all_over.covered[far]).all() and (left.covered[far] > 0).all()


def test_under_the_shade_of_what_is_displayed_it_sends_what_the_whole_stand_does(covered):
    """What is painted on the ground is shaded by what still stands there, and must not be twice."""
    cover, view = covered
    D = view.limits(cover.species[0].prototypes[0].hierarchy)[0][0]
    points = ground(view, np.linspace((1 - view.fade) * D, 1.1 * D, 300))
    bare, up = np.full((300, 3), 0.1), np.tile((0.0, 0.0, 1.0), (300, 1))
    left = cover.residual(view, points)
    rows, lines, stand = left.rows, left.lines, cover.stand
    share, shade = lines.share[:, None], lines.at(stand.ground)
    assert 0 < share.min() < 0.5 and share.max() == pytest.approx(1.0) and shade.max() < 0.99
    assert np.allclose(lines.share + lines.rest, 1)
    seen = left.colours(up, bare)[rows] * shade ** (1 - share)  # displayed balls cast that share
    sent = lines.at(stand.radiance[0]) + bare[rows] * lines.at(stand.ground_bounce[0])
    hidden = left.covered[rows, None]
    assert np.allclose(seen, (1 - hidden) * bare[rows] * shade + hidden * sent)


def test_a_stand_that_no_light_comes_through_is_not_white(covered):
    cover, view = covered
    D = view.limits(cover.species[0].prototypes[0].hierarchy)[0][0]
    points = ground(view, np.linspace((1 - view.fade) * D, 1.1 * D, 300))
    closed = replace(cover)
    vars(closed)["stand"] = replace(cover.stand, ground=0 * cover.stand.ground)
    bare, up = np.full((300, 3), 0.1), np.tile((0.0, 0.0, 1.0), (300, 1))
    assert closed.residual(view, points).colours(up, bare).max() < 0.5


def test_a_world_and_its_window_have_the_same_ground():
    keys = ["species.tree.density=0", "render.size=48x27", "view.detail=12"]
    views = [load_preset("meadow", [*keys, *more]) for more in ([], ["world.extent=50"])]
    shapes = []
    for preset in views:
        scene = Scene(preset)
        world = scene.world
        view = scene.view(1)
        tiles = world.terrain.roots(view)
        lifted = world.terrain.aggregate_cover.residual(view, tiles.centre).lift
        shapes.append(lifted)
    assert np.array_equal(*shapes) and shapes[0].max() > 0
