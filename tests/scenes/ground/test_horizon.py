"""Ground that is hidden, or beside the picture, is coarser; whatever is seen is not."""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import Parts, displayed, prune
from lod.view import View
from scenes.ground.mesh import Terrain, tile_xy
from scenes.ground.quadtree import horizon

RIDGES = Terrain(2, 190.0, 4096.0, 0.95, reach=20_000.0, finest=0.5, ridged=True)
HILLS = Terrain(seed=3, amplitude=120.0, wavelength=2048.0, hurst=0.9, reach=10_000.0)
CORNER = Corner(2025, -1431)


def view_of(terrain: Terrain, heading: float, above: float = 12.0, **settings: object) -> View:
    ground = terrain.height(CORNER, np.zeros((1, 2)))[0]
    eye = np.array((0.0, 0.0, ground + above))
    pitch = float(settings.pop("pitch", 2.0))
    metric = METRICS[str(settings.pop("metric", "blake"))]
    return View(
        camera_from_heading(CORNER, eye, heading, pitch, 60.0, (320, 180)), metric, **settings
    )


def coarser(terrain: Terrain, view: View, parts: Parts) -> np.ndarray:
    """Which tiles that count as in view have the limit of hidden ones."""
    return parts.limit < terrain.limits(view)[0][parts.level]


def points_on(terrain: Terrain, parts: Parts, rng: np.random.Generator) -> np.ndarray:
    """A point of the relief on each tile, (n, 3)."""
    grid = parts.state
    side = grid.root_side / 2.0**parts.level
    corner = np.array((grid.west, grid.south)) + side[:, None] * np.stack(tile_xy(parts.part), 1)
    xy = corner + side[:, None] * rng.random((len(parts), 2))
    return np.column_stack((xy, terrain.height(CORNER, xy)))


def in_picture(view: View, points: np.ndarray) -> np.ndarray:
    camera, offset = view.camera, points - view.camera.eye
    ahead = offset @ camera.forward
    sides = zip((camera.right, camera.up), camera.tan_half, strict=True)
    return np.logical_and.reduce([abs(offset @ axis) <= tan * ahead for axis, tan in sides])


def clearance(terrain: Terrain, view: View, points: np.ndarray) -> np.ndarray:
    """How far lines from the eye to points stay above the ground at least, as an angle, (n,)."""
    share = 1 - np.geomspace(2e-3, 1 - 1e-4, 200)
    line = view.camera.eye + share[:, None, None] * (points - view.camera.eye)
    ground = terrain.height(CORNER, line.reshape(-1, 3)[:, :2])
    over = line[:, :, 2] - ground.reshape(len(share), -1)
    return np.min(over / np.linalg.norm(line - view.camera.eye, axis=2), axis=0)


@pytest.mark.parametrize("terrain", [RIDGES, HILLS])
@pytest.mark.parametrize("heading", [0.0, 140.0, 300.0])
def test_nothing_of_a_coarser_tile_is_seen(terrain, heading):
    view = view_of(terrain, heading)
    asked, rng = terrain.parts_of(prune(terrain, view).parts, view), np.random.default_rng(1)
    hidden = asked.take(coarser(terrain, view, asked))
    points = np.concatenate([points_on(terrain, hidden, rng) for _ in range(4)])
    points = points[in_picture(view, points)]
    assert len(points) > 20
    assert np.all(clearance(terrain, view, points) < 0)


def test_of_many_refined_tiles_something_is_seen():
    view, rng = view_of(RIDGES, 300.0), np.random.default_rng(2)
    parts = prune(RIDGES, view).parts
    fine = parts.take(np.flatnonzero((parts.level > 3) & ~coarser(RIDGES, view, parts)))
    points = np.concatenate([points_on(RIDGES, fine, rng) for _ in range(8)])
    seen = in_picture(view, points) & (clearance(RIDGES, view, points) > 0)
    assert np.mean(seen.reshape(8, -1).any(axis=0)) > 0.35


@pytest.mark.parametrize(
    "settings", [{"look_around": True}, {"metric": "full"}, {"metric": "depth"}]
)
def test_nothing_is_hidden_where_all_counts(settings):
    view = view_of(RIDGES, 300.0, detail=4.0, **settings)
    parts = prune(RIDGES, view).parts
    assert not coarser(RIDGES, view, parts).any()


def test_looking_straight_down_has_no_horizon():
    assert horizon(RIDGES.relief, view_of(RIDGES, 0.0, pitch=-90.0), 1000.0) is None
    assert horizon(RIDGES.relief, view_of(RIDGES, 0.0, pitch=-80.0), 1000.0) is None
    assert horizon(RIDGES.relief, view_of(RIDGES, 0.0, pitch=-5.0), 1000.0) is not None


def test_parts_of_hidden_tiles_are_hidden():
    view = view_of(RIDGES, 300.0)
    parts = prune(RIDGES, view).parts
    rows = np.flatnonzero(parts.parent >= 0)
    hidden = coarser(RIDGES, view, parts)
    assert hidden[parts.parent[rows]].any()
    assert np.all(hidden[rows] >= hidden[parts.parent[rows]])
    assert displayed(parts, view).all()


SUNNY = replace(RIDGES, to_sun=(0.0, math.cos(0.4), math.sin(0.4)))
"""Ridges under a sun in the north, 23° high."""


def unlit(terrain: Terrain, view: View, parts: Parts) -> np.ndarray:
    """Which tiles are so coarse as those whose shadow is out of view as they are."""
    dim = terrain.limits(view)[3][parts.level]
    return np.isfinite(dim) & (parts.limit == dim) & (parts.limit_offscreen == dim)


@pytest.mark.parametrize("heading", [0.0, 140.0])
def test_neither_unlit_ground_nor_its_shadow_is_in_the_picture(heading):
    view, rng = view_of(SUNNY, heading), np.random.default_rng(3)
    parts = prune(SUNNY, view).parts
    asked = SUNNY.parts_of(parts, view)
    dim = asked.take(unlit(SUNNY, view, asked))
    assert len(dim) > 100
    points = np.concatenate([points_on(SUNNY, dim, rng) for _ in range(4)])
    assert not in_picture(view, points).any()
    drop = (points[:, 2:] + 3 * SUNNY.amplitude) / SUNNY.to_sun[2]
    for share in np.linspace(0.02, 1, 50):
        assert not in_picture(view, points - share * drop * np.array(SUNNY.to_sun)).any()


def test_ground_behind_the_eye_casts_its_shadow_where_the_sun_is_behind_it():
    """The eye looks from the sun, or along the horizon: what is behind or beside it matters."""
    shares = []
    for heading in (180.0, 0.0):
        view = view_of(SUNNY, heading)
        asked = SUNNY.parts_of(prune(SUNNY, view).parts, view)
        out = asked.take(~in_picture(view, asked.centre) & (asked.level > 2))
        shares.append(unlit(SUNNY, view, out).mean())
    assert shares[0] < 0.8 * shares[1]
