"""Popping is seen where it is, and only there; with fading a walk has none."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from bench.experiments.popping import WALK_WAYS
from bench.motion_residual import (
    SKY_SHARE,
    Frame,
    Seen,
    frames_of,
    measure_walk,
    popped,
    rows_missing,
    silhouettes,
)
from lod.camera import Corner, camera_from_heading
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import Placed
from scenes.frame.frame_input import DisplayedRepresentation, Light, Quality, display
from scenes.ground.mesh import Terrain
from scenes.models.stone import boulder_prototypes
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import Scene

SIZE = (32, 18)
GROUND = Terrain(0, 0.0, 64.0, 0.8, reach=32.0)


def view(east=0.0, corner=0) -> View:
    eye = np.array((east - 16.0 * corner, -7.0, 2.0))
    return View(
        camera_from_heading(Corner(corner, 0), eye, 0.0, -8.0, 60.0, SIZE), METRICS["blake"]
    )


def displayed(at: View, *distances: float) -> tuple[DisplayedRepresentation, ...]:
    """Even ground out to 30 m, and a boulder at each of these distances."""
    stone = boulder_prototypes(0, 1)[0]
    things = [Placed(f"stone {y}", stone, 0.0, y - 7.0, 0.0, GROUND) for y in distances]
    return tuple(display(each, prune(each, at), at) for each in (GROUND, *things))


def pictures(shown, at: View, *samples: int):
    quality = Quality(choose("auto"), 25)
    return silhouettes(shown, at.camera, 0.0, Light(0.0, 40.0), quality, samples)


@pytest.mark.parametrize("elevation", [20.0, 90.0])
def test_shaded_ground_is_as_bright_as_its_slope_to_the_sun(elevation):
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 2.0)), 0.0, -60.0, 40.0, (16, 9))
    down = View(camera, METRICS["blake"])
    ground = (display(GROUND, prune(GROUND, down), down),)
    looks = camera, 0.0, Light(0.0, elevation), Quality(choose("auto"), 4), (1,)
    (plain,), (shaded,) = (silhouettes(ground, *looks, each) for each in (False, True))
    wanted = SKY_SHARE + (1 - SKY_SHARE) * np.sin(np.radians(elevation))
    assert shaded.mean() / plain.mean() == pytest.approx(wanted, rel=0.02)


def test_motion_explains_all_of_what_stays():
    """The same things from another place, and in the coordinates of another corner."""
    at, after = view(), view(east=0.2, corner=1)
    (moved,), (now, other) = (
        pictures(displayed(seen, 6.0), after, *samples)
        for seen, samples in ((at, [2]), (after, [2, 3]))
    )
    assert abs(now - moved).max() < 0.05, "but for the detail of the ground and the stone"
    assert abs(now - other).max() > 2 * abs(now - moved).max(), "noise is there with other samples"


def test_what_vanishes_is_seen_in_full():
    at = view()
    both, one = (pictures(displayed(at, *where), at, 4)[0] for where in ((6.0, 3.0), (6.0,)))
    stone = abs(both - one)
    assert 10 < (stone > 0.05).sum() < 200
    assert 0.1 < stone.max() < 0.5


@dataclass(frozen=True, eq=False)
class Going(Frame):
    """A frame all of whose objects go the same way; ``around`` is what out of view is displayed."""

    goes: tuple[float, float, float] = (0.0, 0.0, 0.0)
    around: Seen | None = None

    def walked(self, name, time_s):
        return np.tile(self.goes, (len(self.seen[name].key), 1))

    def all_round(self, name):
        return self.around or self.seen[name]


def with_parts(numbers, sizes, ahead=10.0, goes=(0.0, 0.0, 0.0)) -> Frame:
    n = len(numbers)
    key = np.zeros((n, 4), int)
    key[:, 3] = numbers
    centre = np.tile((0.0, ahead, 2.0), (n, 1))
    return Going(view(), (), {"thing": Seen(key, np.array(sizes), centre, np.ones(n))}, goes)


def test_parts_pop_at_full_size_and_in_view_of_both():
    before = with_parts([1, 2, 3], [1.0, 1.0, 0.2])
    assert popped(before, before) == 0
    assert popped(before, with_parts([1, 2], [1.0, 1.0])) == 0, "3 had faded"
    assert popped(before, with_parts([1], [1.0])) == 1
    assert popped(before, with_parts([1, 2, 4], [1.0, 1.0, 0.9])) == 1
    behind = with_parts([1, 2, 4], [1.0, 1.0, 0.9], ahead=-30.0)
    assert popped(with_parts([1, 2], [1.0, 1.0]), behind) == 0


def test_what_swings_out_of_view_has_not_popped():
    """A hand whose arm swings is not where the walk of its object alone would have it."""
    both, one = with_parts([1, 2], [1.0, 1.0]), with_parts([1], [1.0])
    swung = with_parts([1, 2], [1.0, 1.0]).seen["thing"]
    assert popped(both, replace(one, around=swung)) == 1, "in view, and not displayed"
    aside = replace(swung, centre=swung.centre + np.array(((0, 0, 0), (50, 0, 0))))
    assert popped(both, replace(one, around=aside)) == 0


def test_hands_of_people_swing_out_of_the_picture_in_the_wood():
    """Two frames of `popping_shipped`: hands at the edge leave with the swing of their arms."""
    words = ("render.size=320x180", "seed=4100", "light.sun_elevation=20", "camera.speed=1.4")
    trees = ("broadleaf", "birch", "conifer", "dead_tree", "shrub", "sward")
    bare = [f"species.{name}.density=0" for name in trees]
    preset = load_preset("forest", (*words, *bare))
    frames = [*frames_of(Scene(preset), (11, 12))]
    assert popped(*frames) == 0


@pytest.mark.parametrize("fade", [0.2, 0.0])
def test_a_tuft_whose_blades_thin_out_shows_nothing_as_a_whole(fade):
    """New tufts come at each step of a walk, and pop with their blades alone."""
    bare = "species.figure.density=0", "species.tree.density=0", "camera.speed=1.4"
    looks = "render.size=160x90", f"view.fade={fade}", "view.detail=2"
    frames = [*frames_of(Scene(load_preset("meadow", (*bare, *looks))), (1, 2))]
    new = rows_missing(frames[1].seen["sward"].key, frames[0].seen["sward"].key)
    assert len(new) > 10
    assert (popped(*frames) == 0) == (fade > 0)


@pytest.mark.slow
def test_a_walk_in_the_wood_that_fades_is_as_an_unpruned_one_and_one_that_clips_is_not():
    """A pair of frames in which large branches come and go."""
    wood = "species.sward.density=0", "world.extent=60.0", "terrain.reach=300.0"
    looks = "view.haze_aware=false", "render.size=160x90", "render.spp=36", "view.detail=6"
    walks = {}
    for way, settings in WALK_WAYS.items():
        scene = Scene(load_preset("forest", (*wood, *looks, *settings)))
        walks[way] = measure_walk(scene, (36, 37), choose("auto"))
    same = {way: np.quantile(found.switched, 0.9999) for way, found in walks.items()}
    assert walks["unpruned"].popped.sum() == walks["fading"].popped.sum() == 0
    assert walks["clipped"].popped.sum() > 2
    assert same["unpruned"] < 0.01 and same["fading"] < 0.5 * same["clipped"]
