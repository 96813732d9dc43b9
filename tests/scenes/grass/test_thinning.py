"""Grass thins out: a random subset of blades, as much wider as it is smaller, and no jumps."""

from dataclasses import replace

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import blend_weights, prune
from lod.shapes import triangle_areas
from lod.view import View
from scenes.field.part_tables import PLAIN, emit_meshes
from scenes.field.species_field import Species, SpeciesField
from scenes.grass.sward import LEAST, PIXELS, RANKINGS, ranked, swards, tuft_prototypes
from scenes.ground.mesh import Terrain
from scenes.trees.species import Weather

FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)
(TUFT,) = tuft_prototypes(0, 1)
TUFTS = ranked(TUFT)
FIELD = SpeciesField(Species("sward", TUFTS, 2.0, metric=METRICS["bounded"]), 5, FLAT)


def view(metric: str = "bounded", x: float = 0.0, **more) -> View:
    eye = np.array((x, 0.0, 1.7))
    camera = camera_from_heading(Corner(0, 0), eye, 0, 0, 60.0, (320, 180))
    return View(camera, METRICS[metric], 1.0, **{"fade": 0.2, "look_around": True, **more})


def test_every_blade_gets_all_ranks_in_turn():
    """However few are left, as many of all lengths: over rankings a share λ of each blade."""
    ranks = 1 / np.array([t.hierarchy.stands_for[1:] for t in TUFTS])
    assert ranks.shape[0] == RANKINGS and ranks.min() == LEAST
    for share in (0.1, 0.3, 0.7):
        left = (ranks < share).mean(axis=0)
        assert np.abs(left - share).max() <= 1 / RANKINGS
        assert abs((ranks < share).mean() - share) < 0.02


@pytest.mark.parametrize("wind", [0.0, 8.0])
def test_p_counts_the_parts_that_it_stands_for(wind):
    (tuft,) = swards(0, 1, Weather("summer", wind))
    area = np.mean(tuft.hierarchy.P[1:] ** 2)
    for each in ranked(tuft):
        h = each.hierarchy
        assert np.allclose(h.P**2, area / PIXELS * h.stands_for)
        assert h.stands_for[0] == h.stands_for[1:].max() and (h.R >= tuft.hierarchy.R).all()
        assert (h.B > tuft.hierarchy.B + 1.0).all(), "it counts as in view for its shadow"


def displayed_area(seen: View, low: float, high: float) -> float:
    """Area of all blades from one distance to another [m²]; no triangle is a plain one there."""
    cut = prune(FIELD, seen)
    parts, weights = cut.parts, blend_weights(cut, seen)
    d = np.linalg.norm(parts.position - seen.camera.eye, axis=1)
    rows = np.flatnonzero((d >= low) & (d < high))
    mesh = FIELD.appearance(parts.take(rows), weights.take(rows)).triangles
    return float(triangle_areas(mesh.vertices, mesh.faces).sum())


@pytest.mark.parametrize(("low", "high"), [(3.0, 10.0), (15.0, 20.0), (20.0, 26.0)])
def test_what_is_left_covers_as_much_as_all(low, high):
    """Within a few per cent, by the number of blades that there are."""
    whole = replace(FIELD, extent=100.0)
    cut = prune(whole, view("full"))
    d = np.linalg.norm(cut.parts.position - view().camera.eye, axis=1)
    rows = np.flatnonzero((d >= low) & (d < high))
    weights = blend_weights(cut, view("full"))
    mesh = whole.appearance(cut.parts.take(rows), weights.take(rows)).triangles
    every = float(triangle_areas(mesh.vertices, mesh.faces).sum())
    assert displayed_area(view(), low, high) == pytest.approx(every, rel=0.04)


def test_nothing_jumps_as_the_eye_moves():
    """A blade gets narrower and wider by a hundredth of what it covers at most in 2 cm."""
    found = []
    for x in (0.0, 0.02):
        cut = prune(FIELD, view(x=x))
        names = cut.parts.state.samples
        keys = (names.cell_x, names.cell_y, names.index)
        owner = np.stack([key[cut.object] for key in keys], axis=1)
        weights = blend_weights(cut, view(x=x)).leaf
        rows = zip(map(tuple, np.column_stack((owner, cut.part)).tolist()), weights, strict=True)
        found.append(dict(rows))
    before, after = found
    changes = [abs(before.get(k, 0.0) - after.get(k, 0.0)) for k in before | after]
    widest = max(before.values())
    assert widest > 20 and max(changes) < 0.02 * widest
    assert np.mean(changes) > 0, "but it does change"


def test_the_ground_takes_over_what_is_missing():
    tables, seen = FIELD.prototypes.part_tables, view()
    d = np.linspace(1.0, 1.2 * float(tables.limits(seen)[0].max()), 500)
    still = np.zeros(len(d))
    missing = tables.missing_cover(d, seen, still)
    assert missing[0] == 0 and missing[-1] == 1 and (np.diff(missing) >= -1e-12).all()
    assert np.diff(missing).max() < 0.05
    rows = np.full(len(d), 1)
    kept = tables.kept(rows, d, seen, still)
    assert kept[0] == 1 and kept.min() == LEAST and (np.diff(kept) <= 1e-12).all()
    assert tables.kept(rows, d, seen, still + 0.5).max() <= 1  # between two steps of motion


def test_wider_blades_are_no_longer_and_far_ones_plain():
    """Of the same area above the ground, and darker."""
    meshes = TUFT.meshes
    assert not meshes.shrinks_to_point[1] and meshes.shrinks_to_point[0]
    wide = meshes.with_area_share(3.0)
    ratio = triangle_areas(wide.vertices, wide.faces) / triangle_areas(
        meshes.vertices, meshes.faces
    )
    assert np.allclose(ratio, 3.0) and np.allclose(wide.vertices[4::5], meshes.vertices[4::5])
    tables, poses = FIELD.prototypes.part_tables, FIELD.prototypes.pose_tables
    samples = FIELD.sample_cells(Corner(0, 0), np.zeros(1, np.int64), np.arange(1))
    instances = FIELD.instances_in_view(samples, view()).instances
    objects, parts = np.zeros(2, np.int64), np.array((1, 1))
    found = emit_meshes(poses, tables, instances, objects, parts, np.array((0.99, 1.0)) * PLAIN)
    assert found.owner.tolist() == [0, 0, 0, 1] and len(found.vertices) == 8
    assert (found.colours[-1] < meshes.colours[4]).all()
    heights = [found.vertices[rows, 2].max() for rows in (slice(5), slice(5, 8))]
    assert heights[0] == pytest.approx(heights[1])
