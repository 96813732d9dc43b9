"""The skyline that the benchmark of the ground measures with."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench.studies.terrain_skyline import command, skyline, slice_camera
from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.shapes import Triangles
from lod.view import View, in_view


def test_the_skyline_of_a_gable_is_its_outline():
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, 0.0, 90.0, (40, 20))
    corners = np.array([(-5.0, 10.0, 2.0), (5.0, 10.0, 2.0), (0.0, 10.0, 5.0), (0.0, -9.0, 90.0)])
    faces, up = np.array([[0, 1, 2], [0, 1, 3]]), np.tile((0.0, 0.0, 1.0), (4, 1))
    gable = Triangles(corners, up, up, faces, np.zeros(2))
    top = skyline(gable, camera)
    across = (np.arange(40) + 0.5 - 20) / 20 * 10  # metres at 10 m: 45° is the picture's edge
    expected = np.where(abs(across) <= 5, (1 - abs(across) / 5) * 3 / 10 * 20, -np.inf)
    assert top == pytest.approx(expected, abs=1e-9)


def test_it_says_how_true_the_ground_is(monkeypatch):
    monkeypatch.setattr("bench.studies.terrain_skyline.SIZES", ("64x36",))
    monkeypatch.setattr("bench.studies.terrain_skyline.PRESETS", ("meadow",))
    said = CliRunner().invoke(command, ["--quick"])
    assert said.exit_code == 0, said.output
    assert "meadow" in said.output and "100.00%" in said.output


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
