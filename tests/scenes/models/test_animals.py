import numpy as np
import pytest

from lod.errors import InputError
from scenes.model_files.names import animal_names
from scenes.models.animals.catalogue import animal, animal_tables
from scenes.models.people.people import people_at_rest
from scenes.rig.foot_placement import Placements, place_on_ground
from scenes.rig.pose import pose_points
from scenes.rig.pose_tables import PoseTables
from scenes.rig.rotations import matrices, to_euler
from tests.scenes.gait.contact_errors import foot_slide, lowest_heights, sample_cycle
from tests.scenes.rig.motion_phase import at_phase, motion_at

WALKERS = [name for name in animal_names() if animal_tables(name).gait.legs]
LIVING = ["rabbit", "giraffe", "ostrich"]


@pytest.mark.parametrize("name", animal_names())
def test_no_joint_goes_beyond_its_limits(name):
    it = animal(name)
    seen = sample_cycle(it)
    assert it.rig.limit_excess(seen.rotations).max() < 1e-6
    assert np.all(it.motion.shift >= it.rig.shift_low - 1e-12)
    assert np.all(it.motion.shift <= it.rig.shift_high + 1e-12)


@pytest.mark.parametrize("name", WALKERS)
def test_feet_stay_where_they_stand(name):
    it, gait = animal(name), animal_tables(name).gait
    seen, height = sample_cycle(it), it.rig.frames()[0][0, 2]
    assert foot_slide(it, gait, seen) < min(0.02, 0.02 * height)
    assert lowest_heights(it, seen).min() > -min(0.01, 0.02 * height)


@pytest.mark.parametrize("name", ["giraffe", "ostrich", "insect"])
def test_walkers_always_stand_on_something(name):
    it = animal(name)
    seen = sample_cycle(it)
    assert lowest_heights(it, seen).max() < 0.01 * it.rig.frames()[0][0, 2] + 1e-3


def test_a_rabbit_leaves_the_ground():
    it = animal("rabbit")
    assert lowest_heights(it, sample_cycle(it)).max() > 0.001  # with all four feet


def test_giraffes_put_down_their_feet_in_lateral_sequence():
    hind, fore = animal_tables("giraffe").gait.legs
    order = [hind.strike, fore.strike, hind.strike + hind.apart, fore.strike + fore.apart]
    assert order == sorted(order)
    assert np.allclose(np.diff(order), 0.25, atol=0.05)


def test_an_insect_walks_on_alternating_tripods():
    fore, mid, hind = animal_tables("insect").gait.legs
    assert fore.strike == hind.strike
    assert (mid.strike - fore.strike) % 1 == fore.apart == 0.5


def test_sails_go_round_once_a_cycle():
    it = animal("windmill")
    hub = it.rig.row("hub")
    turned = [to_euler(motion_at(it.motion, k / 60)[0][hub])[0] for k in range(61)]
    assert np.allclose(np.diff(np.unwrap(turned, period=360)), 6.0, atol=1e-6)
    assert it.motion.speed == 0


@pytest.mark.parametrize("name", animal_names())
def test_levels_run_from_blob_to_detail(name):
    h = animal(name).hierarchy
    assert set(np.unique(h.level)) >= {0, 1, 2, 3}
    assert h.P[0] == h.P[h.level <= 1].max() or name == "windmill"


@pytest.mark.parametrize("name", [*LIVING, "person"])
def test_parts_of_living_things_shrink_with_depth(name):
    h = people_at_rest(1, 1, 0.0)[0].hierarchy if name == "person" else animal(name).hierarchy
    assert np.all(h.P[1:] <= 1.0 * h.P[h.parent[1:]])


def test_an_artifact_has_big_bits_tacked_on():
    h, names = animal("windmill").hierarchy, animal_tables("windmill").anatomy.part_names
    sail = names.index("sail 1")
    assert h.P[sail] > 3 * h.P[h.parent[sail]]


@pytest.mark.parametrize("name", animal_names())
def test_every_pose_of_the_motion_stays_within_R(name):
    it = animal(name)
    for phase in np.linspace(0, 1, 9):
        at_phase(it, float(phase))  # a prototype refuses sticks beyond R


def test_the_compiled_walk_poses_them_all_as_their_rigs_do():
    them = tuple(animal(name) for name in animal_names())
    phases = np.array((0.0, 0.31, 0.99, 0.999))
    for variant, it in enumerate(them):
        n, count = len(it.rig), len(phases)
        rows, joints = np.divmod(np.arange(count * n), n)
        cast, same = PoseTables.of(them), (np.zeros((count, 2)), np.ones(count), np.zeros(count))
        drawn = np.full(count, variant), phases, np.ones(count)
        instances = place_on_ground(cast, lambda xy: np.zeros(len(xy)), Placements(*same, *drawn))
        corners = [
            pose_points(cast, instances, rows, joints, np.tile(corner, (n, 1)), np.arange(n))
            for corner in np.vstack((np.zeros(3), np.eye(3)))
        ]
        for o, phase in enumerate(phases.tolist()):
            at, facing = it.rig.frames(*motion_at(it.motion, phase))
            origin, *axes = (corner[rows == o] for corner in corners)
            assert np.allclose(origin, at, atol=1e-12)
            turned = np.stack([axis - origin for axis in axes], axis=-1)
            assert np.allclose(turned, matrices(facing), atol=1e-12)


def test_an_unknown_kind_is_named():
    with pytest.raises(InputError, match="rabbit"):
        animal_tables("gryphon")
