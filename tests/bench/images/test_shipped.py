"""Presets as shipped: places follow their rule, verdicts their samples, and nothing is lost."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.differences import Looks, errors, flips, sum_land
from bench.images.shipped import (
    BANDS,
    EVERYTHING,
    FINEST,
    GROUND,
    GROUND_STEPS,
    NOTHING,
    REST,
    Place,
    band_edges,
    display_ground,
    display_others,
    finest_within,
    light_ratios,
    measure,
    places,
)
from bench.records.records import Column, Point, columns, merge_points
from bench.seeds import BUILDING_SEEDS, JUDGED_SEED, QUICK_SEED, first_seed
from scenes.frame.layers import SKY_Z
from scenes.presets.load import load_preset, preset_names
from scenes.render.variants import choose
from scenes.scene import Scene

SHIPPED = EXPERIMENT.topics["fidelity_shipped"]
SIZE = "32x18"


def test_every_preset_is_judged_and_stands_apart_from_all():
    assert set(SHIPPED.full["presets"]) == {name for name, _ in preset_names()}
    assert SHIPPED.apart and not EXPERIMENT.topics["fidelity"].apart


def test_places_are_those_of_the_rule_and_none_that_is_built_with():
    assert tuple(first_seed(each["unseen"]) for each in (SHIPPED.full, SHIPPED.quick)) == (
        JUDGED_SEED,
        QUICK_SEED,
    )
    assert QUICK_SEED + 6 <= BUILDING_SEEDS
    own = {load_preset(name, ()).seed for name, _ in preset_names()}
    for name, count in SHIPPED.full["presets"].items():
        presets = [place.load() for place in places(name, count, SIZE, JUDGED_SEED)]
        seeds = [preset.seed for preset in presets]
        assert len(set(seeds)) == count and min(seeds) > BUILDING_SEEDS >= max(own)
        assert {place.load().seed for place in places(name, 2, SIZE, QUICK_SEED)} == {900, 901}
        suns = {preset.light.sun_elevation: 0 for preset in presets}
        if name in ("campfire", "fly_in"):
            assert suns == {load_preset(name, ()).light.sun_elevation: 0}
        else:
            elevations = [preset.light.sun_elevation for preset in presets]
            assert sorted(elevations) == [20.0] * 3 + [55.0] * 3
    flight = places("fly_in", 3, SIZE, JUDGED_SEED)
    assert [place.frame for place in flight] == [1, 24, 48]
    assert {place.load().view.detail for place in flight} == {1.0}
    assert (
        load_preset("aerial", ()).view.detail
        == places("aerial", 1, SIZE, JUDGED_SEED)[0].load().view.detail
    )


def test_the_eye_goes_round_the_fire_and_faces_it():
    seen = [place.load().camera for place in places("campfire", 6, SIZE, JUDGED_SEED)]
    for camera in seen:
        x, y = camera.position
        assert math.hypot(x, y) == pytest.approx(math.hypot(*seen[0].position), abs=1e-4)
        to_fire = math.degrees(math.atan2(-x, -y))
        off = (camera.heading - to_fire + 180) % 360 - 180
        first = (seen[0].heading - math.degrees(math.atan2(-3.2, 9.5)) + 180) % 360 - 180
        assert off == pytest.approx(first, abs=1e-3) and abs(off) < 1
    assert len({round(camera.position[0], 3) for camera in seen}) == 6


def test_a_reference_is_as_fine_as_fits_and_what_cannot_fit_is_not_tried():
    tried = []

    def bytes_at(detail):
        tried.append(detail)
        return round(100 + 100 / detail**2)

    assert finest_within(bytes_at, 1.0, 10_000) == (0.125, 6500)
    assert tried == [1.0, 0.5, 0.25, 0.125], "1/16 would need four times as much"
    assert finest_within(bytes_at, 1.0, 10**9)[0] == FINEST
    assert finest_within(bytes_at, 2.5, 150) == (2.5, 116)


def test_the_light_of_the_land_is_without_sky_and_by_distance():
    edges = band_edges(load_preset("meadow", ()))
    assert edges[0] == 0 and edges[-1] == SKY_Z and len(edges) == BANDS + 1
    assert edges[1:-1] / edges[1] == pytest.approx(np.geomspace(1, edges[-2] / edges[1], BANDS - 1))
    Z = np.array([[1.0, edges[1] * 1.01, edges[-2] * 2, SKY_Z]], np.float32)
    rgb = np.ones((1, 4, 3), np.float32) * np.array([1, 2, 4, 100])[:, None]
    land = sum_land([(rgb, Z)] * 3, edges)
    assert land.light == pytest.approx([3, 6, *[0] * (BANDS - 3), 12])
    assert land.rays.tolist() == [3, 3, *[0] * (BANDS - 3), 3]


def test_flip_is_of_pictures_with_as_many_samples_at_one_exposure():
    rng = np.random.Generator(np.random.Philox(3))
    plain = [rng.uniform(0.1, 0.9, (24, 32, 3)) for _ in range(2)]
    assert flips(plain, plain) == pytest.approx([0.0, 0.0], abs=1e-6)
    one, other = flips([plain[0], plain[1] * 1.3], plain)
    assert one < 1e-6 < 0.01 < other


def planted(preset, pruned, a, light=1.0, band_light=1.0, step=1.0):
    """A point of six places: error ``a``; the land so bright, and its last band so bright."""
    scatter = np.array([-2, -1, 0, 0, 1, 2]) * 1e-4
    flip = [
        Column("flip_ppm", [round(1e6 * (a + s + 0.2 / n**0.5)) for s in scatter], {"samples": n})
        for n in (16, 64, 256)
    ]
    sums = []
    for k in range(BANDS):
        more = light * (band_light if k == BANDS - 1 else 1.0)
        for which, factor in (("tested", more), ("reference", 1.0)):
            keys = {"picture": which, "band": k}
            rays = 1000 if k else 1  # the first band holds next to nothing
            sums.append(Column("light", [round(1e3 * rays * factor)] * 6, keys))
            sums.append(Column("rays", [rays] * 6, keys))
    counts = {
        "place": list(range(6)),
        "sticks": [5] * 6,
        "triangles": [round(1e5 / step)] * 6,
        "detail_ppm": [round(1e6 * step)] * 6,
        "reference_ppm": [125_000] * 3 + [250_000] * 3,
    }
    case = {"topic": "fidelity_shipped", "preset": preset, "pruned": pruned, "step": step}
    return Point(case, samples=(*columns(counts), *flip, *sums))


def verdicts(*points):
    found = EXPERIMENT.judged((planted("meadow", NOTHING, 0.0), *points))
    return {
        (each.estimand.split()[0], each.condition.get("pruned")): each.verdict for each in found
    }


def test_verdicts_follow_from_samples():
    good = verdicts(planted("meadow", EVERYTHING, 0.009), planted("meadow", REST, 0.001, 1.005))
    assert set(good.values()) == {"holds"} and len(good) == 7
    assert verdicts(planted("meadow", GROUND, 0.011))["FLIP", GROUND] == "refuted"
    near = verdicts(planted("meadow", EVERYTHING, 0.00995))
    assert near["FLIP", EVERYTHING] == "inconclusive"
    bright = verdicts(planted("meadow", EVERYTHING, 0, 1.02))
    assert bright["luminance", EVERYTHING] == "refuted"
    far = verdicts(planted("meadow", EVERYTHING, 0, 1.0, 1.03))
    assert far["bands", EVERYTHING] == "refuted"
    assert EXPERIMENT.judged((planted("meadow", NOTHING, 0.01),))[0].verdict == "refuted"


def test_as_shipped_is_what_a_user_renders_and_details_apart_are_of_the_ground_and_the_rest():
    place = Place("meadow", 0, (f"render.size={SIZE}", "seed=101"))
    preset = place.load()
    scene = Scene(preset)
    world, view, frame = scene.world, scene.view(1), scene.input(1)
    mine = (*display_ground(world, view, 1.0, 1.0), *display_others(world, view, 1.0))
    for ours, theirs in zip(mine, frame.displayed, strict=True):
        assert ours.name == theirs.name and len(ours.shape) == len(theirs.shape)
    assert np.array_equal(mine[0].shape.colours, frame.displayed[0].shape.colours)
    fine, coarse = (display_ground(world, view, d, 8.0)[0].shape for d in (0.1, 1.0))
    assert len(fine) > len(coarse) == len(mine[0].shape)
    assert not np.allclose(coarse.colours, mine[0].shape.colours), "more is left on the ground"


@pytest.mark.slow
def test_a_place_gives_a_point_of_every_way_and_places_are_merged():
    looks = Looks((4, 16), 4)
    coarse = "render.size=48x27", "seed=101", "view.detail=8"
    place = Place("meadow", 0, (*coarse, "species.sward.density=0"))
    rest = True, looks, choose(), 10**9, 0
    made = measure(place, *rest)
    ways = [(p.case["pruned"], p.case["step"]) for p in made]
    assert ways == [(NOTHING, 1), (EVERYTHING, 1), (REST, 1), *((GROUND, s) for s in GROUND_STEPS)]
    flip = {way: p.column("flip_ppm", samples=16)[0] for way, p in zip(ways, made, strict=True)}
    assert flip[EVERYTHING, 1] > max(flip[REST, 1], flip[GROUND, 1]) > flip[NOTHING, 1]
    triangles = [p.column("triangles")[0] for p in made if p.case["pruned"] == GROUND]
    assert triangles == sorted(triangles, reverse=True) and triangles[0] > triangles[-1]
    assert made[0].column("reference_ppm")[0] <= 250_000
    land = light_ratios(made[0])
    assert land == pytest.approx([1.0], abs=1e-9), "the light is of the same samples"
    other = measure(replace(place, number=1), *rest)
    merged = merge_points((*made, *other))
    assert len(merged) == len(made) and len(errors(merged[1])) == 2
