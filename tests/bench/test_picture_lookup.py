"""What vanishes is found by looking pixels up in the other picture; what motion explains is not."""

import numpy as np
import pytest

from bench.picture_lookup import Shot, unexplained
from lod.camera import Corner, look
from lod.metric import METRICS
from lod.view import View
from scenes.render.frame import SKY_Z, Layers

SIZE = (32, 18)
GREY, DARK = 0.5, 0.1


def wall(eye_x=0.0, corner=0, hole=None, far=20.0) -> Shot:
    """A striped wall to the north, sky above 3 m; a dark square before it, of a part of its own."""
    camera = look(Corner(corner, 0), np.array((eye_x, 0.0, 0.0)), 0.0, 0.0, 60.0, SIZE)
    tan_x, tan_y = camera.tan_half
    across = tan_x * (2 * (np.arange(SIZE[0]) + 0.5) / SIZE[0] - 1)
    height = tan_y * (1 - 2 * (np.arange(SIZE[1]) + 0.5) / SIZE[1])
    x, z = np.meshgrid(far * across + eye_x + 16 * corner, far * height)
    albedo = np.where(z > 3, 0.0, GREY + 0.01 * np.sin(x / 3))
    away = far * np.sqrt(1 + across[None] ** 2 + height[:, None] ** 2)
    Z = np.where(z > 3, SKY_Z, away)
    if hole is not None:
        inside = (np.abs(x / far * hole - (eye_x + 16 * corner) * (hole / far - 1)) < 2) & (
            np.abs(z / far * hole) < 2
        )
        albedo[inside], Z[inside] = DARK, Z[inside] * hole / far
    flat = np.repeat(albedo[..., None], 3, axis=2)
    zero = np.zeros(Z.shape)
    layers = Layers(flat, Z, np.zeros_like(flat), flat, zero, zero, zero)
    return Shot(View(camera, METRICS["blake"]), layers)


def test_what_motion_explains_is_not_counted():
    assert unexplained(wall(), wall()).max() == 0
    for after in (wall(0.4), wall(-15.8, corner=1)):
        assert unexplained(wall(), after).max() < 0.01
    both = unexplained(wall(hole=10.0), wall(0.2, hole=10.0))
    assert both.max() < 0.01, "what the square hides and uncovers is explained"


@pytest.mark.parametrize("moved", [0.0, 0.2])
def test_what_vanishes_or_appears_is_seen(moved):
    for pair in (
        (wall(hole=10.0), wall(moved)),
        (wall(), wall(moved, hole=10.0)),
    ):
        assert unexplained(*pair).max() == pytest.approx(GREY - DARK, abs=0.02)
