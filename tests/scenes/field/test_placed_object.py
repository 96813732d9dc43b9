"""What a preset places stands where it is put."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import GRID_M, camera_from_heading, split_position
from lod.metric.family import METRICS
from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import prune
from lod.pruning.view import View
from scenes.field.placed_object import Placed
from scenes.models.animals.catalogue import animal
from scenes.models.catalogue import at_rest, people
from scenes.models.trees.species_files import tree_species
from scenes.models.trees.tree import tree_prototypes


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


def test_the_camera_s_cell_changes_nothing():
    """The same picture from the same eye, whichever corner its place is told from."""
    hare = Placed("hare", animal("rabbit"), 5.0, 6.0, 30.0, Ground())
    one, other = view_from(3.0, 4.0, 0.3), view_from(3.0 + 5 * 16, 4.0 - 2 * 16, 0.3, cell=(-5, 2))
    (_, a), (_, b) = displayed(hare, one), displayed(hare, other)
    assert len(a) > 10
    assert np.array_equal(a.start, b.start)


def test_it_moves_on_the_spot_in_time_with_its_motion():
    it = animal("rabbit")
    hare = Placed("hare", it, 1.0, 2.0, 0.0, Ground())
    times = (0.0, 0.3 * it.motion.period, it.motion.period)
    (_, a), (_, b), (_, c) = (displayed(hare, view_from(0.0, 2.0, 0.5, t)) for t in times)
    assert not np.allclose(a.start, b.start, atol=1e-3)
    assert np.allclose(a.start, c.start, atol=1e-12)
    assert np.array_equal(*(origin_of(hare, view_from(0, 2, 0.5, t)) for t in times[:2]))


def test_feet_stand_on_a_slope():
    it, slope = at_rest(people(0, 1)[0]), 0.08
    man = Placed("man", it, 4.0, 3.0, 20.0, Ground(slope=slope))
    view = view_from(3.0, 2.0, 1.5)
    _, sticks = displayed(man, view)
    above = [
        end[:, 2] - radius - slope * (end[:, 0] + GRID_M * view.camera.corner.x)
        for end, radius in (
            (sticks.start, sticks.start_radius),
            (sticks.end, sticks.end_radius),
        )
    ]
    assert min(a.min() for a in above) == pytest.approx(0.0, abs=2e-3)


def test_a_far_thing_is_a_blob_and_a_very_far_one_nothing():
    man = Placed("man", at_rest(people(0, 1)[0]), 0.0, 0.0, 0.0, Ground())
    D = float(view_from(0, 0).limits(man.prototype.hierarchy)[0][0])
    blob, _ = displayed(man, view_from(0.95 * D, 0.0))
    nothing, _ = displayed(man, view_from(1.05 * D, 0.0))
    assert (len(blob), len(nothing)) == (1, 0)
    assert blob.object.tolist() == [0]
