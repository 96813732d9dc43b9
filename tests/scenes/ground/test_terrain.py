"""The ground is one watertight surface, finer where it is nearer, and keeps the pruner's rules."""

from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import example, given, settings

from lod.camera import GRID_M, Corner
from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES
from lod.pruner import prune
from lod.view import distance
from scenes.ground.mesh import MOST_COARSER, QUADS, Terrain, lattice_mesh
from scenes.ground.quadtree import SIDES, Patches, balance
from scenes.sticks.prototype import GROUND_CONTRAST
from tests.scenes.ground.grounds import (
    FAR,
    FLAT,
    HILLS,
    RIDGED,
    assert_watertight,
    cut_and_mesh,
    grounds,
    map_areas,
    probe_count,
    random_patches,
    rim_edges,
    sides,
    view_of,
    views,
)

# --- what the pruner relies on


@settings(max_examples=15)
@given(terrain=grounds, view=views)
def test_parts_never_outreach_their_wholes(terrain, view):
    view = view_of(terrain, **view)
    parts = prune(terrain, view).parts
    rows = np.flatnonzero(parts.parent >= 0)
    whole = parts.parent[rows]
    assert np.all(parts.limit[rows] <= parts.limit[whole])
    assert np.all(parts.limit_offscreen[rows] <= parts.limit_offscreen[whole])
    apart = np.linalg.norm(parts.centre[rows] - parts.centre[whole], axis=1)
    assert np.all(apart + parts.bound[rows] <= parts.bound[whole])
    d = distance(view, parts.position)
    assert np.all(d[rows] >= d[whole] - 1e-9)
    assert np.all(parts.object[rows] == parts.object[whole])
    assert len(np.unique(np.stack((parts.level, parts.part)), axis=1).T) == len(parts)


@settings(max_examples=15)
@given(terrain=grounds, view=views)
def test_a_tile_is_inside_its_sphere_and_no_nearer_than_its_distance(terrain, view):
    view = view_of(terrain, **view)
    parts = prune(terrain, view).parts
    southwest, side = sides(terrain, parts)
    steps = np.random.default_rng(1).random((20, 2))
    for step in np.concatenate((steps, np.array(((0, 0), (1, 0), (0, 1), (1, 1))))):
        xy = southwest + side[:, None] * step
        ground = np.column_stack((xy, terrain.height(view.camera.corner, xy)))
        away = np.linalg.norm(ground - parts.centre, axis=1)
        assert np.all(away <= parts.bound)
        assert np.all(distance(view, ground) >= distance(view, parts.position) - 1e-9)


@pytest.mark.parametrize("reach", [16.0, 1000.0, 1e7])
def test_roots_cover_the_disc_and_are_never_dropped(reach):
    terrain = Terrain(seed=3, amplitude=30.0, wavelength=2048.0, hurst=0.95, reach=reach)
    view = view_of(terrain)
    roots = terrain.roots(view)
    southwest, side = sides(terrain, roots)
    rng = np.random.default_rng(2)
    turn, away = 2 * np.pi * rng.random(2000), reach * np.sqrt(rng.random(2000))
    xy = view.camera.eye[:2] + away[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    inside = (xy >= southwest[:, None]) & (xy < southwest[:, None] + side[:, None, None])
    assert np.all(inside.all(axis=2).sum(axis=0) == 1)
    assert np.all(roots.limit == np.inf) and np.all(roots.limit_offscreen == np.inf)
    assert len(roots) < 80


@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle", "depth", "full"])
def test_the_ground_is_coarse_where_the_air_hides_its_relief(metric):
    clear, hazy = (view_of(HILLS, metric=metric, detail=0.2, air=air) for air in (0.0, 0.02))
    gone = hazy.conditions.weighted(CONTRAST_CLASSES[GROUND_CONTRAST], hazy.m).vanishing_distance
    assert gone < 400
    for got, without in zip(HILLS.limits(hazy), HILLS.limits(clear), strict=True):
        if metric == "full":
            assert (got == without).all()
        else:
            assert (got[1:] == np.minimum(without[1:], gone)).all()
        assert got[0] == without[0]


def test_metric_full_is_blake_at_half_a_pixel_whatever_the_detail():
    half = prune(HILLS, view_of(HILLS, metric="blake", detail=0.5, look_around=True))
    for detail in (0.5, 7.0):
        full = prune(HILLS, view_of(HILLS, metric="full", detail=detail, look_around=True))
        assert full.parts.part.tobytes() == half.parts.part.tobytes()


def test_more_detail_than_memory_holds_is_refused():
    with pytest.raises(InputError, match="detail"):
        prune(HILLS, view_of(HILLS, detail=0.001))


# --- the mesh


@settings(max_examples=10)
@given(terrain=grounds, view=views)
def test_the_mesh_is_watertight(terrain, view):
    view = view_of(terrain, **view)
    cut, mesh = cut_and_mesh(terrain, view)
    assert_watertight(terrain, view, cut, mesh)
    assert terrain.triangle_count(cut.parts) == len(mesh)
    places = mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1]
    assert len(np.unique(places)) == len(places), "two vertices in one place"
    assert len(np.unique(mesh.faces)) == len(mesh.vertices), "a vertex that no face uses"


@settings(max_examples=10)
@given(terrain=grounds, view=views)
@example(
    Terrain(seed=3, amplitude=30.0, wavelength=2048.0, hurst=0.95, reach=3000.0, finest=0.125),
    {"above": -1.0, "offscreen_detail": 0.01, "metric": "blake"},
)
def test_vertices_lie_on_the_relief_and_look_like_ground(terrain, view):
    view = view_of(terrain, **view)
    _, mesh = cut_and_mesh(terrain, view)
    height = terrain.height(view.camera.corner, mesh.vertices[:, :2])
    np.testing.assert_array_equal(mesh.vertices[:, 2], height)
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, rtol=1e-6)
    way = view.camera.eye - mesh.vertices
    away = np.linalg.norm(way, axis=1)
    # Of what is right above an eye in the ground nothing says which way to turn it.
    turned = np.hypot(way[:, 0], way[:, 1]) > 1e-6 * away
    assert np.all(((mesh.normals * way).sum(axis=1) > -1e-6 * away)[turned])
    assert 0 < mesh.colours.min() and mesh.colours.max() < 0.5
    red, green, blue = mesh.colours.mean(axis=0)
    assert min(red, green) > blue and (green > red or terrain is RIDGED)  # which is steep: earth


@settings(max_examples=10)
@given(terrain=grounds, view=views)
def test_each_tile_draws_ground_of_its_own(terrain, view):
    cut, mesh = cut_and_mesh(terrain, view_of(terrain, **view))
    southwest, side = sides(terrain, cut.parts)
    middle = mesh.vertices[mesh.faces, :2].mean(axis=1)
    inside = (middle >= southwest[mesh.owner]) & (middle <= (southwest + side[:, None])[mesh.owner])
    assert np.all(inside)
    assert np.all(np.isin(np.setdiff1d(np.arange(len(cut.parts)), cut.parts.parent), mesh.owner)), (
        "a leaf tile that draws nothing"
    )


@pytest.mark.parametrize("fade", [0.0, 0.3])
def test_every_plumb_line_meets_the_ground_once_and_within_a_pixel(fade):
    view = view_of(HILLS, look_around=True, above=30.0, size=(160, 90), fade=fade)
    _, mesh = cut_and_mesh(HILLS, view)
    rng = np.random.default_rng(3)
    turn, away = 2 * np.pi * rng.random(10_000), 10 ** rng.uniform(0, 3.47, 10_000)
    probes = view.camera.eye[:2] + away[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    probes = probes[np.argsort(probes[:, 0])]
    hits, z = probe_count(mesh.vertices, mesh.faces, probes)
    assert np.all(hits == 1)
    ground = np.column_stack((probes, HILLS.height(view.camera.corner, probes)))
    wrong = np.abs(z - ground[:, 2]) / (distance(view, ground) * view.camera.pixel_angle)
    assert np.sqrt(np.mean(wrong**2)) < 0.2
    assert wrong.max() < 1.0


def touching(patches: Patches) -> Iterator[tuple[int, int]]:
    """Pairs of patches with a side in common, found one by one."""
    size = 2 ** (patches.deepest - patches.depth)
    x, y = patches.x * size, patches.y * size
    for p in range(len(patches)):
        overlap_x = np.minimum(x + size, x[p] + size[p]) - np.maximum(x, x[p])
        overlap_y = np.minimum(y + size, y[p] + size[p]) - np.maximum(y, y[p])
        for q in np.flatnonzero(
            ((overlap_x == 0) & (overlap_y > 0)) | ((overlap_x > 0) & (overlap_y == 0))
        ):
            yield p, q


@pytest.mark.parametrize("seed", range(5))
def test_neighbours_differ_by_no_more_than_a_side_allows(seed):
    rough = random_patches(seed)
    assert max(rough.depth[p] - rough.depth[q] for p, q in touching(rough)) > MOST_COARSER
    patches, coarser = balance(rough, MOST_COARSER)
    expected = np.zeros_like(coarser)
    fine = patches.deepest - patches.depth
    for p, q in touching(patches):
        difference = patches.depth[p] - patches.depth[q]
        assert difference <= MOST_COARSER
        if difference > 0:
            moved = [
                ((patches.x[p] + dx) << fine[p], (patches.y[p] + dy) << fine[p]) for dx, dy in SIDES
            ]
            side = [(int(mx) >> int(fine[q]), int(my) >> int(fine[q])) for mx, my in moved]
            expected[p, side.index((patches.x[q], patches.y[q]))] = difference
    np.testing.assert_array_equal(coarser, expected)
    assert np.sum(4.0**-patches.depth) == np.sum(4.0**-rough.depth)


@pytest.mark.parametrize("seed", range(5))
def test_any_quadtree_makes_one_watertight_mesh(seed):
    patches, coarser = balance(random_patches(seed), MOST_COARSER)
    xy, faces, _ = lattice_mesh(patches, coarser)
    unit = QUADS << patches.deepest  # of a root's side; the roots fill 3 x 2 of them
    rim = xy[rim_edges(faces)].transpose(0, 2, 1)
    on_rim = (rim == 0) | (rim == np.array((3 * unit, 2 * unit))[:, None])
    assert np.all(on_rim.all(axis=2).any(axis=1))
    area = map_areas(xy, faces)
    assert np.all(area > 0)
    assert area.sum() == 6 * unit**2


# --- exactness


@pytest.mark.parametrize("home", [Corner(0, 0), FAR])
def test_the_frame_does_not_depend_on_where_its_corner_is(home):
    steps = (7, -4)
    near = view_of(HILLS, corner=home)
    shifted = view_of(
        HILLS,
        corner=Corner(home.x + steps[0], home.y + steps[1]),
        xy=(3.0 - GRID_M * steps[0], 14.0 - GRID_M * steps[1]),
    )
    (_, a), (_, b) = cut_and_mesh(HILLS, near), cut_and_mesh(HILLS, shifted)
    np.testing.assert_array_equal(a.faces, b.faces)
    np.testing.assert_array_equal(a.vertices[:, :2], b.vertices[:, :2] + GRID_M * np.array(steps))
    np.testing.assert_allclose(a.vertices[:, 2], b.vertices[:, 2], rtol=0, atol=1e-9)
    np.testing.assert_allclose(a.colours, b.colours, rtol=0, atol=1e-9)


def test_flat_ground_is_few_tiles_exactly_level_and_not_of_one_colour():
    cut, mesh = cut_and_mesh(FLAT, view_of(FLAT))
    assert np.all(cut.parts.level == 0)
    assert np.all(mesh.vertices[:, 2] == 0.0)
    assert np.all(mesh.normals == (0.0, 0.0, 1.0))
    assert np.all(mesh.colours.std(axis=0) > 0.005)
    assert FLAT.bounds() == (0.0, 0.0)
