"""Smoke and flames: functions of the time alone, and as much of them at every level."""

from dataclasses import replace

import numpy as np
import pytest

from lod.camera import GRID_M, Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import prune
from lod.shapes import StickTable, Triangles
from lod.view import View
from scenes.particles.system import KINDS, PARTICLES_PER_BALL, SMOKE, Plume
from scenes.sticks.areas import directions, mean_area
from tests.scenes.flat_ground import FlatGround
from tests.scenes.particles.levels import drawn, level

HOME = Corner(0, 0)


def plume(kind="smoke", **changes):
    return Plume(kind, KINDS[kind], 7, 3.0, -2.0, FlatGround(), **changes)


def view(time_s=20.0, corner=HOME, detail=1.0):
    eye = np.array((-GRID_M * corner.x, -30.0 - GRID_M * corner.y, 3.0))
    camera = camera_from_heading(corner, eye, 0.0, 0.0, 60.0, (100, 60))
    return View(camera, METRICS["blake"], detail, time_s=time_s)


def cover(it, wanted, at):
    """Mean area over directions that a level covers, all of it together [m²]."""
    shape = drawn(it, level(it, wanted, at))
    zero = np.zeros(len(shape), np.int64)
    ends = shape.start, shape.end, shape.start_radius, shape.end_radius
    return float(mean_area(StickTable.of(1, zero, *ends, zero), directions(24))[0])


def test_every_level_of_smoke_covers_as_much():
    smoke, shares = plume(), []
    for time_s in (0.0, 13.0, 57.0, 101.0):
        finest = cover(smoke, 2, view(time_s))
        shares.append([cover(smoke, each, view(time_s)) / finest for each in (0, 1)])
    assert np.mean(shares, axis=0) == pytest.approx([1, 1], abs=0.1)


def test_stand_ins_have_the_area_of_those_they_stand_for():
    for name in KINDS:
        it, at = plume(name), view()
        areas = []
        for each in range(3):
            shape = drawn(it, level(it, each, at))
            if isinstance(shape, Triangles):
                tops = shape.vertices[:, 2].reshape(-1, 6)
                areas.append(np.sum((tops.max(axis=1) - tops.min(axis=1)) ** 2))
            else:
                areas.append(np.sum(shape.start_radius**2))
        assert areas == pytest.approx([areas[2]] * 3, rel=1e-9)


def test_puffs_are_born_at_their_rate_move_on_and_die():
    it = plume()
    ages = [len(level(it, 1, view(time_s))) for time_s in np.linspace(0, 200, 60)]
    mean_life = SMOKE.life_s * 0.875
    assert np.mean(ages) == pytest.approx(SMOKE.rate * mean_life, rel=0.05)
    before, after = level(it, 1, view(20.0)), level(it, 1, view(20.04))
    same = np.isin(after.part, before.part)
    rows = np.searchsorted(before.part, after.part[same])
    moved = after.position[same] - before.position[rows]
    assert np.all(moved[:, 2] > 0)
    assert np.linalg.norm(moved, axis=1).max() < 0.3
    assert not set(level(it, 1, view(32.0)).part.tolist()) & set(before.part.tolist())


def test_it_stands_in_the_plane_wherever_the_frame_counts_from():
    it, far = plume(), Corner(40, -9)
    here, there = level(it, 2, view()), level(it, 2, view(corner=far))
    shift = np.array((GRID_M * far.x, GRID_M * far.y, 0.0))
    assert np.allclose(here.position, there.position + shift, atol=1e-9)
    moved = level(replace(it, x=10.0), 2, view())
    assert np.allclose(moved.position - here.position, (7.0, 0.0, 0.0))


def test_from_afar_a_plume_is_a_few_large_puffs():
    it = plume()
    near, far = (len(prune(it, view(detail=detail))) for detail in (0.1, 40.0))
    assert near > 3000 and 1 <= far < 120
    parts = prune(it, view(detail=1e-3)).parts
    assert len(drawn(it, parts.take(parts.level == 1))) == (
        np.count_nonzero(parts.level == 1) * SMOKE.particles // PARTICLES_PER_BALL
    )


def test_flames_glow_and_smoke_does_not():
    shape = drawn(plume("flames"), level(plume("flames"), 2, view()))
    assert shape.glows.min() > 0
    assert np.all(np.diff(shape.glows[:, 0]) < 0), "hotter below"
    outward = shape.vertices[shape.faces]
    normal = np.cross(outward[:, 1] - outward[:, 0], outward[:, 2] - outward[:, 0])
    assert np.all((normal * shape.normals[shape.faces].sum(axis=1)).sum(axis=1) > 0)
