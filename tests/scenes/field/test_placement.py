"""What a preset places stands where it is put.

What grows somewhere grows there alone, and the law knows.
"""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.frame_counts import count
from lod.camera import GRID_M, Corner, camera_from_heading, split_position
from lod.metric import METRICS
from lod.pruner import blend_weights, prune, prune_by_level
from lod.view import View
from scenes.appearance.sky import sky_at
from scenes.field.far_cover import AggregateCover
from scenes.field.species_field import Habitat, Placed, Species, SpeciesField
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import at_rest, people
from scenes.models.stone import boulder_prototypes
from scenes.scene import World
from scenes.trees.species import tree_species
from scenes.trees.tree import tree_prototypes
from tests.scenes.field.brute_force import instances_in_cells


class Ground:
    """Flat, or a slope to the east that begins at the corner."""

    def __init__(self, level=0.0, slope=0.0):
        self.level, self.slope = level, slope

    def height(self, corner, xy):
        return self.level + self.slope * (xy[:, 0] + GRID_M * corner.x)

    def bounds(self):
        return -1e9, 1e9


def view_from(x, y, height=1.6, time_s=0.0, cell=(0, 0)):
    corner, x, y = split_position(x, y, *cell)
    camera = camera_from_heading(corner, np.array((x, y, height)), 0.0, 0.0, 60.0, (100, 100))
    return View(camera, METRICS["blake"], 0.1, look_around=True, time_s=time_s)


def origin_of(placed, view):
    parts = placed.roots(view)
    return parts.state.instances.origin[0]


def displayed(placed, view):
    cut = prune(placed, view)
    return cut.parts, placed.appearance(cut.parts, blend_weights(cut, view))


def test_it_stands_where_it_is_put_on_the_ground():
    man = Placed("man", at_rest(people(0, 1)[0]), 20.25, -35.5, 0.0, Ground(level=7.0))
    view = view_from(18.0, -30.0, 8.0)
    corner = view.camera.corner
    here = (20.25 - GRID_M * corner.x, -35.5 - GRID_M * corner.y, 7.0)
    assert origin_of(man, view) == pytest.approx(here, abs=1e-12)
    _, sticks = displayed(man, view)
    for axis in (0, 1):
        middle = (sticks.start[:, axis] + sticks.end[:, axis]).mean() / 2
        assert middle == pytest.approx(here[axis], abs=0.2)
    lows = np.minimum(
        sticks.start[:, 2] - sticks.start_radius, sticks.end[:, 2] - sticks.end_radius
    )
    assert lows.min() == pytest.approx(7.0, abs=1e-6)


@pytest.mark.parametrize("heading", [0.0, 90.0, 180.0, -45.0, 300.0])
def test_it_faces_its_heading(heading):
    """The nose is ahead of the middle of the head; clockwise from north."""
    it = at_rest(people(0, 1)[0])
    placed = Placed("man", it, 0.0, 0.0, heading, Ground())
    parts, _ = displayed(placed, view_from(0.0, -2.0))
    here = dict(zip(parts.part.tolist(), parts.position, strict=True))
    nose, head = (it.rig.row(name) for name in ("nose", "head"))
    rows = [int(np.flatnonzero(it.joint == joint)[0]) for joint in (nose, head)]
    ahead = (here[rows[0]] - here[rows[1]])[:2]
    facing = np.array((math.sin(math.radians(heading)), math.cos(math.radians(heading))))
    assert ahead / np.linalg.norm(ahead) == pytest.approx(facing, abs=1e-6)


@given(
    cell=st.tuples(*(st.integers(-(2**44), 2**44),) * 2),
    x=st.floats(-100, 100),
    y=st.floats(-100, 100),
    eye=st.tuples(*(st.floats(-50, 50),) * 2),
)
def test_it_is_as_exact_far_from_the_origin(cell, x, y, eye):
    """No digit is lost between where it is put, of any size, and where it is from the eye."""
    place = GRID_M * cell[0] + x, GRID_M * cell[1] + y
    tree = Placed("tree", tree_prototypes(0, 1, tree_species("tree"))[0], *place, 10.0, Ground())
    view = view_from(*eye, cell=cell)
    found = origin_of(tree, view)
    corner = view.camera.corner
    for axis, cells in ((0, corner.x), (1, corner.y)):
        exact = Fraction(place[axis]) - Fraction(GRID_M) * cells
        assert abs(Fraction(float(found[axis])) - exact) < Fraction(1, 10**9)


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
    everywhere, kept = (instances_in_cells(each, HOME, *cells) for each, cells in
                        zip((stones(None), field), 2 * [tuple(cells)], strict=True))  # fmt: skip
    share = HABITAT.share(HOME, stones(None).cells.positions(HOME, everywhere.samples))
    assert len(kept.samples) == pytest.approx(
        share.sum(), abs=4 * np.sqrt(np.sum(share * (1 - share)))
    )
    assert HABITAT.share(HOME, field.cells.positions(HOME, kept.samples)).min() > 0
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
    grown, all_over = (np.multiply(*each.undisplayed(view(), points))[:, 0] for each in cover)
    assert grown == pytest.approx(all_over * HABITAT.share(HOME, points[:, :2]))
