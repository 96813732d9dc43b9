"""The skyline of the ground at τ = 1 is within a pixel of that of ground four times as fine."""

import math
from dataclasses import replace

import numpy as np
import pytest
from numba import njit

from lod.camera import Camera, Corner, camera_from_heading
from lod.crossfade import blend_weights
from lod.metric import METRICS
from lod.pruner import prune
from lod.shapes import Triangles
from lod.view import View, in_view
from scenes.ground.terrain import Terrain
from scenes.presets.load import load_preset
from scenes.world.camera_path import camera_at

REFERENCE = 0.25
"""τ of what the skyline is held against [px]."""

SLICE = 20
"""Columns of the reference that are built at once [px]."""

_NEAREST_M = 0.1


def ground_mesh(terrain: Terrain, view: View) -> tuple[int, Triangles]:
    """Prune the ground for a view: number of tiles displayed, and their mesh."""
    cut = prune(terrain, view)
    return len(cut), terrain.appearance(cut.parts, blend_weights(cut, view))


def skyline(triangles: Triangles, camera: Camera) -> np.ndarray:
    """Find the highest ground over each column's middle, (width,) [px from the axis]."""
    offset = triangles.vertices - camera.eye
    depth, across, up = (offset @ axis for axis in (camera.forward, camera.right, camera.up))
    scale = camera.width / (2 * camera.tan_half[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        x = camera.width / 2 + scale * across / depth - 0.5
        y = scale * up / depth
    return _highest_edges(x, y, depth > _NEAREST_M, triangles.faces, camera.width)


@njit(cache=True)
def _highest_edges(x, y, ahead, faces, width):  # type: ignore[no-untyped-def]
    """Find the highest edge over each column; edges that reach behind the eye are left out."""
    top = np.full(width, -np.inf)
    for f in range(len(faces)):
        for k in range(3):
            i, j = faces[f, k], faces[f, (k + 1) % 3]
            if not (ahead[i] and ahead[j]):
                continue
            if x[i] > x[j]:
                i, j = j, i
            first, last = max(0, int(np.ceil(x[i]))), min(width - 1, int(np.floor(x[j])))
            for column in range(first, last + 1):
                share = (column - x[i]) / (x[j] - x[i]) if x[j] > x[i] else 0.0
                top[column] = max(top[column], y[i] + share * (y[j] - y[i]))
    return top


def reference_skyline(terrain: Terrain, view: View) -> tuple[np.ndarray, int]:
    """Build the skyline at REFERENCE, (width,) [px from the axis], and count its triangles."""
    camera, triangles = view.camera, 0
    top = np.full(camera.width, -np.inf)
    for first in range(0, camera.width, SLICE):
        columns = slice(first, min(first + SLICE, camera.width))
        part = slice_camera(camera, columns)
        detail = REFERENCE * camera.pixel_angle / part.pixel_angle
        finer = replace(view, camera=part, detail=detail, offscreen_detail=0.01, fade=0.0)
        _, mesh = ground_mesh(terrain, finer)
        top[columns] = skyline(mesh, camera)[columns]
        triangles += len(mesh)
    return top, triangles


def slice_camera(camera: Camera, columns: slice) -> Camera:
    """Make a camera at the same place whose pyramid of view holds those columns of the picture."""
    tan_x, tan_y = camera.tan_half
    ends = [math.atan(tan_x * (2 * c / camera.width - 1)) for c in (columns.start, columns.stop)]
    turn, fov = sum(ends) / 2, ends[1] - ends[0]
    forward = math.cos(turn) * camera.forward + math.sin(turn) * camera.right
    width = columns.stop - columns.start
    height = math.ceil(1.2 * width * tan_y / math.tan(fov / 2))
    return replace(camera, forward=forward, fov_x=fov, width=width, height=height)


def test_the_skyline_of_a_gable_is_its_outline():
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, 0.0, 90.0, (40, 20))
    corners = np.array([(-5.0, 10.0, 2.0), (5.0, 10.0, 2.0), (0.0, 10.0, 5.0), (0.0, -9.0, 90.0)])
    faces, up = np.array([[0, 1, 2], [0, 1, 3]]), np.tile((0.0, 0.0, 1.0), (4, 1))
    gable = Triangles(corners, up, up, faces, np.zeros(2))
    top = skyline(gable, camera)
    across = (np.arange(40) + 0.5 - 20) / 20 * 10  # metres at 10 m: 45° is the picture's edge
    expected = np.where(abs(across) <= 5, (1 - abs(across) / 5) * 3 / 10 * 20, -np.inf)
    assert top == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("pitch", [0.0, -25.0])
def test_slices_hold_what_the_picture_shows(pitch):
    camera = camera_from_heading(Corner(0, 0), np.zeros(3), 30.0, pitch, 75.0, (48, 27))
    rng = np.random.default_rng(1)
    x, y = (rng.uniform(-1, 1, (4000, 2)) * camera.tan_half).T
    ray = camera.forward + x[:, None] * camera.right + y[:, None] * camera.up
    column = ((x / camera.tan_half[0] + 1) * 24).astype(int)
    for first in range(0, 48, 8):
        part = slice_camera(camera, slice(first, first + 8))
        shown = ray[column // 8 == first // 8]
        inside = in_view(View(part, METRICS["blake"]), shown, np.full(len(shown), 1e-9))
        assert np.all(inside)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["meadow", "mountain"])
def test_the_skyline_is_within_a_pixel(name):
    """In clear air: haze would leave some of the ground out."""
    preset = load_preset(name, ["render.size=160x90"])
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    camera = camera_at(preset.camera, preset.render.size, 1, terrain)
    view = View(camera, METRICS["blake"], fade=preset.view.fade)
    _, mesh = ground_mesh(terrain, view)
    finer, _ = reference_skyline(terrain, view)
    apart = abs(skyline(mesh, camera) - finer)
    assert np.mean(apart <= 1) > 0.99
