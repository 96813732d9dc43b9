"""What switches is what plane geometry says, and verdicts follow from counts."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from bench.experiments.popping import (
    CLIPPED,
    EXPERIMENT,
    QUANTILE,
    SHIPPED,
    SHIPPED_WAYS,
    WALK_WAYS,
    in_one_only,
    measure_pairs,
)
from bench.motion_residual import frames_of, popped
from bench.records.records import Column, Point, columns, predictions
from scenes.presets.load import load_preset
from scenes.render.variants import choose
from scenes.scene import Scene


def test_area_in_one_disc_only():
    """Nothing without a step, both discs when apart, 4·r·s for a small step."""
    assert in_one_only(np.array([3.0]), 0.0)[0] == pytest.approx(0.0)
    assert in_one_only(np.array([3.0, 0.0]), 6.1).tolist() == pytest.approx([2 * math.pi * 9, 0])
    assert in_one_only(np.array([100.0]), 0.1)[0] == pytest.approx(4 * 100 * 0.1, rel=1e-6)
    rng = np.random.Generator(np.random.Philox(1))
    x, y = rng.uniform(-3, 5, (2, 400_000))
    inside = (np.hypot(x, y) < 2) != (np.hypot(x - 1.5, y) < 2)
    assert in_one_only(np.array([2.0]), 1.5)[0] == pytest.approx(64 * inside.mean(), rel=0.02)


def switches_and_walks(switches=100.0, popped=0, worst=1.0):
    rng = np.random.Generator(np.random.Philox(5))
    counts = rng.poisson(switches, 200).tolist()
    sizes = (400 + np.arange(100) % 7).tolist()
    samples = {"switches": counts, "size_mpx": sizes, "distance_mm": [9000, 20_000] * 50}
    case = {"topic": "popping", "what": "switches", "species": "tree"}
    points = [Point(case, predictions({"switches": 100.0}), columns(samples))]
    for way, share in zip(WALK_WAYS, (0.001, 0.3 * worst, 1.0), strict=True):
        rows = {QUANTILE: [round(1e6 * share) + k for k in range(6)]}
        many = [popped, popped + 1, popped] if way == "clipped" else [popped] * 3
        changes = (Column("switched", row, {"quantile": q}) for q, row in rows.items())
        case = {"topic": "popping", "what": "walk", "way": way}
        points.append(Point(case, samples=(*columns({"popped": many}), *changes)))
    return tuple(points)


def moving(way, change, popped=0):
    """Two pairs of frames in each of four worlds, which change by about a share of white."""
    around = np.rint(1e6 * change * (1 + 0.05 * np.array([-1, 1] * 4))).astype(int).tolist()
    worlds = np.repeat(range(7, 11), 2).tolist()
    samples = {"frame": [1, 13] * 4, "world_seed": worlds, "popped": [popped] * 8}
    samples["changed_ppm"] = sorted(around)
    case = {"topic": "popping_shipped", "preset": "forest", "way": way}
    return Point(case, samples=columns(samples))


def shipped(change, popped=0):
    return moving(SHIPPED, change, popped)


def clipped():
    return moving(CLIPPED, 0.2, 9)


def verdicts(*points):
    return [each.verdict for each in EXPERIMENT.judged(points)]


def test_verdicts_follow_from_counts():
    """Switches, their size, parts popped, faded and clipped, then what is left of a switch."""
    sure = ["holds", "holds", "holds", "inconclusive"]
    assert verdicts(*switches_and_walks()) == [*sure, "holds", "holds", "holds"]
    assert verdicts(*switches_and_walks(worst=2.0))[-2:] == ["holds", "refuted"]
    wrong = ["refuted", "holds", "refuted", "expected violation", "holds", "refuted", "refuted"]
    assert verdicts(*switches_and_walks(120.0, 9, 4.0)) == wrong
    assert verdicts(shipped(0.03), clipped()) == ["holds"] * 3
    assert verdicts(shipped(0.03, popped=1), clipped()) == ["refuted", "holds", "holds"]
    assert verdicts(shipped(0.12), clipped()) == ["holds", "refuted", "refuted"]
    assert verdicts(shipped(0.05), clipped())[1] == "inconclusive"


STOP = (
    "view.shutter=180",
    "camera.keys=[{frame=1, position=[0, -30], height=1.7, target=[-32, -10, 1.7]},"
    "{frame=15, position=[0, -30], height=1.7, target=[3.5, -0.7, 1.7]},"
    "{frame=16, position=[0, -30], height=1.7, target=[6, 0, 1.7]},"
    "{frame=99, position=[0, -30], height=1.7, target=[6, 0, 1.7]}]",
)


def stopping():
    """A turn of the camera that stops, among people alone on bare ground."""
    people = "species.tree.density=0", "species.figure.prototypes=1", "species.figure.density=0.02"
    field = "world.extent=120.0", "species.sward.density=0", "terrain.reach=300.0"
    looks = (
        "render.size=160x90",
        "render.spp=36",
        "terrain.amplitude=1.0",
        "terrain.wavelength=256.0",
    )
    scene = Scene(load_preset("meadow", (*field, *looks, *people, *STOP)))
    bare = replace(scene.world.terrain, aggregate_cover=None)
    return scene.with_world(replace(scene.world, terrain=bare))


def test_nothing_comes_at_full_size_when_the_camera_stops(monkeypatch):
    """Where nothing eases what the turn hides, hundreds of parts come in the frame of the stop."""

    def pops():
        return [popped(*both) for both in pairwise(frames_of(stopping(), range(15, 18)))]

    assert pops() == [0, 0]
    eased = Scene.view

    def not_eased(scene, number):
        view = eased(scene, number)
        return replace(view, shutter=replace(view.shutter, neighbour=None))

    monkeypatch.setattr(Scene, "view", not_eased)
    assert max(pops()) > 200


def test_a_frame_of_a_stop_alone_is_that_of_the_sequence():
    scene = stopping()
    for number in (14, 15, 16):
        after = scene.input(number, "scalar_rgb")
    alone = stopping().input(16, "scalar_rgb")
    for one, other in zip(after.displayed, alone.displayed, strict=True):
        assert np.array_equal(one.cut.part, other.cut.part)
        a, b = (next(iter(vars(each.shape).values())) for each in (one, other))
        assert len(a) and a.tobytes() == b.tobytes()


@pytest.mark.slow
def test_clipped_walks_are_measured():
    """Of a wood without grass in which large branches come and go, with pixels as large as they."""
    wood = "world.extent=60.0", "terrain.reach=300.0", "view.haze_aware=false"
    wood = *wood, "species.sward.density=0"
    looks = *wood, "render.size=64x36", "render.spp=4", "view.detail=2.4"
    found = [measure_pairs("forest", way, looks, 4, choose(), 4, 0) for way in SHIPPED_WAYS]
    assert [p.column("frame") for p in found] == [[1, 13, 25, 37]] * 3
    shipped, clipped, _ = (p.values("popped") for p in found)
    assert shipped.sum() == 0 and clipped.sum() > 2
    shipped, clipped, _ = (p.values("changed_ppm").mean() for p in found)
    assert 0 < shipped < clipped
