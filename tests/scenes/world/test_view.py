"""Views that presets ask for."""

import math

import numpy as np
import pytest

from lod.view import compile_view, in_view, sphere_in_frustum
from scenes.presets.load import load_preset
from scenes.scene import Scene


def test_a_panorama_is_pruned_all_round_at_one_angle():
    preset = load_preset(
        "meadow", ["camera.projection=panorama", "render.size=1024x512", "species={}"]
    )
    view = Scene(preset).view(1)
    assert view.look_around
    assert view.m == pytest.approx(2 * math.pi / 1024)
    behind = view.camera.eye - 5 * view.camera.forward
    assert in_view(view, behind[None], np.zeros(1)).all()
    assert sphere_in_frustum(compile_view(view), *behind.tolist(), 0.0)
