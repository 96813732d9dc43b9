"""A scene: views and air as a preset asks for them, and inputs that redraw only what has moved."""

import math
from functools import cache

import numpy as np
import pytest

from lod.air import rgb_extinction
from lod.eye import CONTRAST_CLASSES, Display, Eye
from lod.pruner import prune
from lod.update_schedule import WINDOW
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


FEW = (
    "species.sward.density=0",
    "species.tree.density=0",
    "species.figure.prototypes=2",
    "render.size=320x180",
)


def sight(*settings, frame=1):
    preset = load_preset("meadow", (*FEW, *settings))
    scene = Scene(preset)
    return scene.view(frame).conditions


def test_haze_alone_prunes_by_the_clearest_band_it_is_painted_in():
    found = sight("air.visibility=5km")
    assert not found.acuity
    painted = rgb_extinction(Scene(load_preset("meadow", ["air.visibility=5km"])).air)
    assert found.extinction == painted.min() == painted[0]
    assert found.widths.effective == found.widths.pixel


@pytest.mark.parametrize("off", ["air.visibility=clear", "view.haze_aware=false"])
def test_clear_or_ignored_air_and_no_eye_are_nothing_at_all(off):
    assert sight(off) is None


def test_a_display_or_an_eye_means_that_someone_looks():
    display, eye = sight("display.pixels_per_degree=40"), sight("eye.signal_to_noise=4")
    assert display.acuity and eye.acuity
    assert (display.display, display.eye) == (Display(40.0), Eye())
    assert (eye.display, eye.eye) == (Display(), Eye(signal_to_noise=4.0))
    assert display.widths.eye > 0
    assert display.extinction > 0
    assert sight("eye={}", "view.haze_aware=false").extinction == 0


def test_haze_takes_only_what_is_beyond_the_last_of_its_contrast():
    """V = 500 m: what is left is nearer than where its class is gone; clear cuts go further."""
    people = (*FEW, "species.figure.density=1e-3", "render.size=640x360", "air.visibility=500m")
    aware = load_preset("meadow", people)
    blind = load_preset("meadow", (*people, "view.haze_aware=false"))
    scene = Scene(aware)
    world = scene.world
    views = scene.view(1), scene.with_preset(blind).view(1)
    assert views[0].m == views[1].m
    (field,) = world.fields
    contrast = np.concatenate([tree.contrast for tree in field.prototypes.part_tables.hierarchies])
    gone = np.array(
        [views[0].conditions.weighted(c, 1.0).vanishing_distance for c in CONTRAST_CLASSES]
    )
    kept, left = (prune(field, view).parts for view in views)
    for parts in (kept, left):
        far = np.linalg.norm(parts.position - views[0].camera.eye, axis=1)
        within = far < gone[contrast[parts.part]]
        assert within.all() == (parts is kept)
    assert set(map(tuple, kept.position.tolist())) < set(map(tuple, left.position.tolist()))


SMALL = (
    "render.size=64x36",
    "camera.fps=10",
    'species={figure={model="figure", density=0.01, prototypes=1}}',
)


def test_a_frame_holds_every_representation_once() -> None:
    preset = load_preset("meadow", SMALL)
    scene = Scene(preset)
    world = scene.world
    shot = scene.input(1, "scalar_rgb")
    assert [each.name for each in shot.displayed] == [each.name for each in world.representations]
    for each in shot.displayed:
        assert len(each.shape.owner)
        assert each.shape.owner.max() < len(each.cut)
        assert each.cut.part.max() < 2**32
    assert shot.quality.variant == "scalar_rgb"
    assert set(shot.seconds) == {"prune", "appearance"}
    assert (shot.camera.width, shot.camera.height) == (64, 36)


WINDY = (
    "render.size=64x36",
    "species.figure.density=0.01",
    "species.figure.prototypes=2",
    "species.figure.sizes=[1.0]",
    "species.tree.model=birch",  # its leaves are sticks: meshes are drawn in every frame
    "species.tree.density=0.0004",
    "species.tree.prototypes=1",
    "species.tree.sizes=[1.0]",
    "wind.speed=6",
    "camera.speed=1.4",
)


@cache
def made(*settings, frame=40):
    preset = load_preset("crowd", (*WINDY, *settings))
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
