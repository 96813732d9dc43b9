"""Frames that draw anew only what has moved: bounded errors, and nothing else is changed."""

from functools import cache

import numpy as np
import pytest

from lod.update_schedule import WINDOW
from scenes.presets.load import load_preset
from scenes.scene import Scene

SMALL = (
    "render.size=64x36",
    "species.figure.density=0.01",
    "species.figure.prototypes=2",
    "species.figure.sizes=[1.0]",
    "species.tree.density=0.0004",
    "species.tree.prototypes=1",
    "species.tree.sizes=[1.0]",
    "wind.speed=6",
    "camera.speed=1.4",
)


@cache
def made(*settings, frame=40):
    preset = load_preset("crowd", (*SMALL, *settings))
    return Scene(preset).input(frame, "scalar_rgb")


def sticks(shot, name="figure"):
    return next(each.shape for each in shot.displayed if each.name == name)


def off_px(shot, true, name):
    """How far the ends of drawn sticks are from where they belong."""
    eye, theta = shot.camera.eye, shot.camera.pixel_angle
    apart = []
    for end in ("start", "end"):
        u, v = (getattr(sticks(each, name), end) - eye for each in (shot, true))
        cross = np.linalg.norm(np.cross(u, v), axis=1)
        apart.append(np.arctan2(cross, (u * v).sum(axis=1)) / theta)
    return np.maximum(*apart)


def test_without_a_threshold_there_is_no_schedule():
    assert made().counts == {}


@pytest.mark.parametrize("threshold", [0.25, 1.0])
@pytest.mark.parametrize("name", ["figure", "tree"])
def test_nothing_is_drawn_farther_off_than_the_threshold(threshold, name):
    shot = made(f"view.update_threshold={threshold}")
    off = off_px(shot, made(), name)
    assert 0 < off.max() <= threshold
    assert shot.counts["farthest_off_mpx"] <= 1000 * threshold
    assert 0 < shot.counts["parts_redrawn"] < 0.9 * shot.counts["parts_scheduled"]


def test_a_higher_threshold_keeps_more():
    few, many = (made(f"view.update_threshold={t}").counts["parts_redrawn"] for t in (1.0, 0.25))
    assert few < many


def test_the_first_frame_of_all_is_drawn_whole():
    shot = made("view.update_threshold=64", frame=1)
    assert shot.counts["parts_redrawn"] == shot.counts["parts_scheduled"]
    assert off_px(shot, made(frame=1), "figure").max() == 0


def test_nothing_is_kept_for_longer_than_a_window():
    """At a threshold that nothing passes turns alone are taken, about one part's in WINDOW."""
    counts = made("view.update_threshold=64").counts
    share = counts["parts_redrawn"] / counts["parts_scheduled"]
    assert 0.5 / WINDOW < share < 2 / WINDOW


def test_while_the_shutter_is_open_only_what_is_drawn_anew_moves():
    shot = made("view.update_threshold=1", "view.shutter=180", "camera.speed=0")
    first, last = (sticks(instant()) for instant in (shot.subframes[0], shot.subframes[-1]))
    moved = (first.start != last.start).any(axis=1)
    assert 0 < moved.sum() < len(moved)


def test_where_nothing_moves_by_itself_a_moving_camera_asks_for_no_update():
    still = ("species.figure.patrol=0", "wind.speed=0", "camera.turn=90")
    assert made("view.update_threshold=0.25", *still).counts == {}
