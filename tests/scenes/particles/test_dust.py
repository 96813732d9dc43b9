"""Dust behind walkers: where their feet strike, as a function of the time alone."""

from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from lod.camera import GRID_M, Corner, camera_from_heading
from lod.errors import InputError
from lod.metric import METRICS
from lod.view import View
from scenes.field.cells import CellSamples
from scenes.field.species_field import Species, SpeciesField, patrol_orbits
from scenes.figures.animal_file import animal
from scenes.ground.relief import Relief
from scenes.models.catalogue import people
from scenes.particles.dust import HIGH, LIFE_S, Dust, settling_speed, wind_near_ground
from scenes.particles.footfalls import Soil, Walkers, footfalls, landing
from scenes.presets.load import preset_from
from scenes.scene import Scene
from tests.scenes.particles.levels import drawn, level

HOME = Corner(0, 0)
SOIL = Soil(Relief(1, 0.0, 64.0, 0.8), "bare")


class Slope:
    """Ground that rises to the east by ``rise`` and is rough."""

    def __init__(self, rise=0.0, rough=0.0):
        self.rise, self.rough = rise, rough

    def height(self, corner, xy):
        x, y = (xy + GRID_M * np.array((corner.x, corner.y))).T
        return self.rise * x + self.rough * np.sin(3 * x) * np.cos(2 * y)

    def bounds(self):
        return -1000.0 * self.rise - self.rough, 1000.0 * self.rise + self.rough


@lru_cache(maxsize=1)
def prototypes():
    return (*people(0, 2), animal("rabbit").scaled(1.5), animal("windmill").scaled(0.3))


def dust(ground=None, wind=0.0, seed=3, few=False):
    """Of some walkers, or of two: a person and a rabbit."""
    extent, seed = (12.0, 3) if few else (30.0, seed)
    kind = Species("walker", prototypes(), 0.02, 6.0)
    return Dust(SpeciesField(kind, seed, ground or Slope(), extent), SOIL, wind)


def view(time_s=20.0, metric="blake", detail=0.2, corner=HOME):
    eye = np.array((-GRID_M * corner.x, -30.0 - GRID_M * corner.y, 3.0))
    camera = camera_from_heading(corner, eye, 0.0, 0.0, 60.0, (100, 60))
    return View(camera, METRICS[metric], detail, time_s=time_s)


def walks_of(it, at):
    return level(it, 0, at).state.sources


def named(it, wanted, at):
    """Places and radii of what stands for the parts of a level, by walker, name and number."""
    parts = level(it, wanted, at)
    shape = drawn(it, parts)
    owner = parts.object[shape.owner], parts.part[shape.owner]
    number = np.arange(len(shape)) - np.searchsorted(shape.owner, shape.owner)
    code = np.stack((*owner, number))
    return {
        tuple(name): (place, radius)
        for name, place, radius in zip(
            code.T.tolist(), shape.start, shape.start_radius, strict=True
        )
    }


def test_feet_strike_where_the_gait_has_them():
    it = dust(Slope(0.2))
    field, at = it.walkers, view()
    samples = field.sample_cells(HOME, *map(np.ravel, np.indices((9, 9)) - 4))
    variant, pace, rounds = patrol_orbits(field.species, field.prototypes, samples)
    walks = Walkers(HOME, field.cells.positions(HOME, samples), variant, pace, rounds, 0 * variant)
    falls = footfalls(walks, it.legs, np.arange(len(walks)), 3, at.time_s)
    falls = falls.take(it.legs.walks[variant[falls.owner], falls.leg])
    fell = landing(walks, it.legs, falls)
    assert len(fell.time_s) > 20
    for row in range(len(fell.time_s)):
        who, leg = falls.owner[row], falls.leg[row]
        one = CellSamples(*(getattr(samples, k)[[who]] for k in ("cell_x", "cell_y", "index", "u")))
        before, after = (
            field._place(HOME, one, float(fell.time_s[row]) + step, None) for step in (-1e-6, 1e-6)
        )
        feet = field.prototypes.rigged[variant[who]].motion.feet
        assert (before.phase - feet.strike[leg]) % 1 > 0.99
        assert (after.phase - feet.strike[leg]) % 1 < 0.01
        x, y = feet.sole[leg].mean(axis=0)
        turned = after.cos * x - after.sin * y, after.sin * x + after.cos * y
        sole = after.foot_contacts[0, leg, :2] + np.concatenate(turned)
        assert fell.xy[row] == pytest.approx(sole, abs=1e-4)


def test_nothing_is_there_before_the_foot_strikes_nor_after_its_life():
    it = dust()
    walks = walks_of(it, view())
    falls = footfalls(walks, it.legs, np.arange(len(walks)), it.legs.slots(LIFE_S), 20.0)
    falls = falls.take(it.legs.walks[walks.prototype[falls.owner], falls.leg])
    fell = landing(walks, it.legs, falls)
    for since in (-0.5, 0.0, 0.4, LIFE_S, LIFE_S + 1):
        total = []
        for row in range(0, len(fell.time_s), 3):
            one = falls.take(np.array([row]))
            puffs = it.puffs(walks, one, float(fell.time_s[row]) + since)
            total.append(puffs.mean_area.sum())
        if since == 0.4:
            assert min(total) > 0.05
        else:
            assert max(total) < 1e-4


def test_nothing_jumps_as_puffs_are_born_and_die():
    it, step = dust(Slope(0.2, 0.03), few=True), 1 / 240
    for wanted in (0, 1):
        before = named(it, wanted, view(20.0, "full"))
        thick = max(radius for _, radius in before.values())
        for time_s in 20 + step * np.arange(1, 80 if wanted == 0 else 12):
            now = named(it, wanted, view(float(time_s), "full"))
            for name in before.keys() ^ now.keys():
                assert (before.get(name) or now.get(name))[1] < 0.05 * thick
            for name in before.keys() & now.keys():
                (a, was), (b, is_) = before[name], now[name]
                assert abs(is_ - was) < 0.06 * thick
                assert np.linalg.norm(b - a) < 0.03 or max(was, is_) < 0.05 * thick
            before = now


def test_what_stands_for_hidden_grains_covers_as_much():
    it, at = dust(few=True), view(metric="full")
    trail, *finer = [np.sum(drawn(it, level(it, k, at)).start_radius ** 2) for k in range(4)]
    assert finer == pytest.approx([finer[-1]] * 3, rel=1e-4)
    assert trail == pytest.approx(finer[-1], rel=0.03)  # the mean of its wisps, not those there are


def test_dust_stays_while_the_walker_goes_on_and_settles():
    it = dust(few=True)
    now, later = (named(it, 1, view(time_s, "full")) for time_s in (20.0, 21.5))
    moved = np.array([later[k][0] - now[k][0] for k in now.keys() & later.keys()])
    assert len(moved) > 50
    assert np.linalg.norm(moved[:, :2], axis=1).max() < 1.0
    walked = walks_of(it, view()).rounds
    ways = walked.at(21.5).offset - walked.at(20.0).offset
    strides = walked.stride > 1
    assert np.linalg.norm(ways, axis=1)[strides].min() > 1.0
    tall = max(it.legs.stride)
    heights = drawn(it, level(it, 2, view(metric="full"))).start[:, 2]
    assert heights.min() >= 0 and heights.max() < 1.4 * HIGH * tall


def test_it_is_the_same_wherever_the_frame_counts_from():
    it, far = dust(Slope(0.2), few=True), Corner(40, -9)
    here, there = level(it, 2, view(metric="full")), level(it, 2, view(metric="full", corner=far))
    shift = np.array((GRID_M * far.x, GRID_M * far.y, 0.0))
    assert np.allclose(here.position, there.position + shift, atol=1e-9)
    assert np.array_equal(here.part, there.part)


def test_the_wind_takes_it_along():
    calm, blown = (level(dust(wind=w, few=True), 1, view(metric="full")) for w in (0, 9))
    away = (blown.position - calm.position)[:, :2]
    speed = wind_near_ground(9.0)
    assert 3.5 < speed < 5
    assert np.linalg.norm(away, axis=1).max() == pytest.approx(speed * LIFE_S, rel=0.1)
    assert np.all(away @ (np.sqrt(3) / 2, 0.5) >= 0)


def test_the_preset_says_where_the_wind_blows_to():
    plume = {"kind": "smoke", "position": (0.0, 0.0)}
    tables = {
        "wind": {"speed": 9.0, "direction": 180.0},
        "plumes": {"with_it": plume, "of_its_own": plume | {"wind": 30.0}},
        "species": {"figure": {"model": "figure", "density": 0.02, "patrol": 6.0, "dust": True}},
    }
    scene = Scene(preset_from(tables))
    world = scene.world
    assert [each.azimuth_deg for each in world.plumes] == [30.0, 180.0]
    (south,) = world.dust
    assert south.drift(1.0) == pytest.approx((0.0, -wind_near_ground(9.0)))
    default = replace(dust(wind=9, few=True), wind_azimuth_deg=180.0)
    calm, blown = (level(it, 1, view(metric="full")) for it in (dust(few=True), default))
    assert np.all((blown.position - calm.position)[:, 1] <= 0)


def test_grains_settle_by_stokes_law():
    speed = settling_speed(np.log(np.array((15, 60)) / 12) / np.log(70 / 12))
    # 2650 kg/m3 · 9.81 m/s2 · d2 / (18 · 1.81e-5 Pa s)
    assert speed == pytest.approx([0.01795, 0.2873], rel=1e-3)


@pytest.mark.parametrize("cover", ["bare", "grassy", "trodden", "snowy"])
def test_a_deep_layer_of_its_grains_has_the_colour_of_the_ground(cover):
    soil = replace(SOIL, cover=cover)
    gamma = np.sqrt(1 - soil.grain)
    assert (1 - gamma) / (1 + gamma) == pytest.approx(soil.ground, abs=1e-12)
    assert np.all((soil.tints > soil.ground) & (soil.tints < soil.grain))
    assert soil.tint(HOME, np.array([[0.0, 0.0], [400.0, 9.0]])).max() < len(soil.tints)


def test_only_who_is_asked_to_throws_up_dust():
    table = {"model": "rabbit", "density": 0.01, "patrol": 5.0}
    clean, dusty = (
        Scene(preset_from({"species": {"hare": table | asked}})).world
        for asked in ({}, {"dust": True})
    )
    assert clean.dust == () and clean.beside == ()
    assert [each.name for each in dusty.beside] == ["hare.dust"]
    assert dusty.dust[0] in dusty.representations


def test_what_stays_at_home_throws_up_none():
    with pytest.raises(InputError, match=r"species.oak.dust: True: only what walks"):
        preset_from({"species": {"oak": {"model": "tree", "density": 1.0, "dust": True}}})
