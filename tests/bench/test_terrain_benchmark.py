"""The skyline that the benchmark of the ground measures with."""

import numpy as np
import pytest
from click.testing import CliRunner

from bench.terrain_benchmark import main, skyline
from lod.camera import Corner, look
from lod.parts import Triangles


def test_the_skyline_of_a_gable_is_its_outline():
    camera = look(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, 0.0, 90.0, (40, 20))
    corners = np.array([(-5.0, 10.0, 2.0), (5.0, 10.0, 2.0), (0.0, 10.0, 5.0), (0.0, -9.0, 90.0)])
    faces, up = np.array([[0, 1, 2], [0, 1, 3]]), np.tile((0.0, 0.0, 1.0), (4, 1))
    gable = Triangles(corners, up, up, faces, np.zeros(2))
    top = skyline(gable, camera)
    across = (np.arange(40) + 0.5 - 20) / 20 * 10  # metres at 10 m: 45° is the picture's edge
    expected = np.where(abs(across) <= 5, (1 - abs(across) / 5) * 3 / 10 * 20, -np.inf)
    assert top == pytest.approx(expected, abs=1e-9)


def test_it_says_how_true_the_ground_is(monkeypatch):
    monkeypatch.setattr("bench.terrain_benchmark.SIZES", ("64x36",))
    monkeypatch.setattr("bench.terrain_benchmark.PRESETS", ("meadow",))
    said = CliRunner().invoke(main, ["--quick"])
    assert said.exit_code == 0, said.output
    assert "meadow" in said.output and "100.00%" in said.output
