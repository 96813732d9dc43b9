"""What grows somewhere grows there alone, and the law knows."""

import numpy as np
import pytest

from bench.count.count_frame import count
from lod.camera import Corner, camera_from_heading
from lod.metric.family import METRICS
from lod.pruning.pruner import prune, prune_by_level
from lod.pruning.view import View
from scenes.far_cover.aggregate_cover import AggregateCover
from scenes.field.habitat import Habitat
from scenes.field.species import Species
from scenes.field.species_field import SpeciesField
from scenes.models.boulder import boulder_prototypes
from scenes.preset.load import load_preset
from scenes.sticks.appearance.sky import sky_at
from scenes.terrain.terrain import Terrain
from scenes.world.world import World, make_habitat

GROUND = Terrain(3, 20.0, 256.0, 0.9, reach=500.0)
HABITAT = Habitat(GROUND.relief, highest=8.0, thinning=12.0, steepest=0.6)
HOME, FAR = Corner(0, 0), Corner(62_500_000_123, -62_499_999_877)


def stones(habitat=HABITAT, density=0.02) -> SpeciesField:
    species = Species("stone", boulder_prototypes(0, 1), density, habitat=habitat)
    return SpeciesField(species, 5, GROUND)


def view(corner=HOME, size=(160, 90)) -> View:
    z = GROUND.height(corner, np.zeros((1, 2)))[0] + 2.0
    camera = camera_from_heading(corner, np.array((0.0, 0.0, z)), 20.0, 0.0, 60.0, size)
    return View(camera, METRICS["blake"], 2.0, look_around=True)


def test_the_share_falls_with_height_and_slope():
    xy = np.random.default_rng(1).uniform(-2000, 2000, (4000, 2))
    share, z = HABITAT.share(FAR, xy), GROUND.height(FAR, xy)
    assert share.min() == 0 and share.max() == 1
    assert np.all(share[z >= 8.0] == 0)
    flat = Habitat(GROUND.relief, 8.0, 12.0).share(FAR, xy)
    assert flat == pytest.approx(np.clip((8.0 - z) / 12.0, 0, 1))
    assert np.all(share <= flat) and (share < flat).any()
    assert np.all(Habitat(GROUND.relief).share(FAR, xy) == 1)


def test_homes_are_kept_by_their_share():
    field = stones()
    cells = (g.ravel() for g in np.indices((60, 60)))
    everywhere, kept = (each.instances_in_cells(HOME, *cells) for each, cells in
                        zip((stones(None), field), 2 * [tuple(cells)], strict=True))  # fmt: skip
    share = HABITAT.share(HOME, stones(None).homes(HOME, everywhere.samples))
    assert len(kept.samples) == pytest.approx(
        share.sum(), abs=4 * np.sqrt(np.sum(share * (1 - share)))
    )
    assert HABITAT.share(HOME, field.homes(HOME, kept.samples)).min() > 0
    assert 0.2 < len(kept.samples) / len(everywhere.samples) < 0.8


@pytest.mark.parametrize("corner", [HOME, FAR])
def test_the_walk_agrees_with_the_parts_own_tests(corner):
    field, at = stones(), view(corner)
    one, other = prune(field, at), prune_by_level(field, at)
    assert len(one) == len(other) > 50
    assert one.parts.position.tobytes() == other.parts.position.tobytes()


def test_the_law_predicts_what_grows():
    at, species = view(), stones().species
    shown = sum(prune(SpeciesField(species, seed, GROUND), at).displayed_objects
                for seed in range(12))  # fmt: skip
    told, bare = (
        count(World(GROUND, (each,)), at).objects.predicted for each in (stones(), stones(None))
    )
    assert shown == pytest.approx(12 * told, abs=4 * np.sqrt(12 * told))
    assert told < 0.8 * bare


def test_what_is_too_far_to_display_is_missing_only_where_it_grows():
    points = np.random.default_rng(2).uniform(-9000, 9000, (500, 3))
    points[:, 2] = GROUND.height(HOME, points[:, :2])
    cover = [AggregateCover((stones(h).species,), np.array((0.0, 0.6, 0.8)), sky_at(53.0, 3.0))
             for h in (HABITAT, None)]  # fmt: skip
    grown, all_over = (each.undisplayed(view(), points)[:, 0] for each in cover)
    assert grown == pytest.approx(all_over * HABITAT.share(HOME, points[:, :2]))


def test_presets_say_where():
    species = load_preset("mountain").species
    assert make_habitat(species["boulder"], GROUND) is None
    there = make_habitat(species["conifer"], GROUND)
    assert (there.highest, there.thinning, there.steepest) == (-20.0, 200.0, 1.0)
