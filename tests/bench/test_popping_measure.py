"""Popping is seen where it is, and only there; with fading a walk has none."""

from dataclasses import replace

import numpy as np
import pytest

from bench.popping_measure import Frame, Seen, popped, unexplained, walk
from lod.camera import Corner, look
from lod.metric import METRICS
from lod.view import View
from scenes.preset import load_preset
from scenes.render.frame import SKY_Z, Layers
from scenes.render.variants import choose
from scenes.world import build_world

SIZE = (32, 18)
GREY, DARK = 0.5, 0.1


def wall(eye_x=0.0, corner=0, hole=None, far=20.0) -> Frame:
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
    parts = Seen(np.zeros((0, 4)), np.zeros(0), np.zeros((0, 3)), np.zeros(0))
    return Frame(View(camera, METRICS["blake"]), {"thing": parts}, layers)


def with_parts(frame, numbers, sizes, ahead=10.0) -> Frame:
    n = len(numbers)
    key = np.zeros((n, 4), int)
    key[:, 3] = numbers
    centre = np.tile((0.0, ahead, 0.0), (n, 1))
    return replace(frame, seen={"thing": Seen(key, np.array(sizes), centre, np.ones(n))})


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


def test_parts_pop_at_full_size_and_in_view_of_both():
    before = with_parts(wall(), [1, 2, 3], [1.0, 1.0, 0.2])
    assert popped(before, before) == 0
    assert popped(before, with_parts(wall(), [1, 2], [1.0, 1.0])) == 0, "3 had faded"
    assert popped(before, with_parts(wall(), [1], [1.0])) == 1
    assert popped(before, with_parts(wall(), [1, 2, 4], [1.0, 1.0, 0.9])) == 1
    behind = with_parts(wall(), [1, 2, 4], [1.0, 1.0, 0.9], ahead=-10.0)
    assert popped(with_parts(wall(), [1, 2], [1.0, 1.0]), behind) == 0


WALK = (
    "render.size=128x72",
    "render.spp=36",
    "world.extent=120.0",
    "species.tree.density=0.002",
    "species.figure.density=0.003",
    "species.tree.prototypes=2",
    "species.figure.prototypes=2",
    "species.tree.sizes=[0.6]",
    "camera.speed=2.8",
    "view.haze_aware=false",
    "view.detail=4.0",
    "terrain.reach=300.0",
    "terrain.amplitude=1.0",
    "terrain.wavelength=256.0",
)


def walked(*settings: str, name: str = "meadow", frames: int = 7):
    preset = load_preset(name, [*WALK, *settings])
    return walk(build_world(preset), preset, range(1, frames + 1), choose("auto"))


@pytest.mark.slow
def test_a_walk_with_fading_pops_nowhere_and_one_without_does():
    full, faded, clipped = walked("view.metric=full"), walked(), walked("view.fade=0.0")
    assert full.popped.sum() == 0
    assert faded.popped.sum() == 0
    assert clipped.popped.sum() > 10
    worst = [np.percentile(each.unexplained, 99.99) for each in (full, faded)]
    assert worst[1] <= 1.1 * worst[0]
