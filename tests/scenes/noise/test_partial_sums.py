"""Sums of octaves that go on from what is known: the same bits as from the first octave on."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lod.camera import Corner
from scenes.noise.partial_sums import SoFar
from scenes.terrain.colour import COVERS, ground_colours
from scenes.terrain.point_cache import rows_among
from scenes.terrain.relief import Relief

HOME = Corner(3, -2)
SHORTEST = st.sampled_from([0.0, 0.2, 0.25, 0.3, 3.0, 4.0, 5.0, 7.9, 8.0, 300.0, 5000.0])


def plane(count):
    return np.random.default_rng(count).uniform(-400, 400, (count, 2))


@pytest.mark.parametrize(("ridged", "lacunarity"), [(False, 2.0), (True, 2.0), (False, 1.5)])
@given(frames=st.lists(st.tuples(SHORTEST, SHORTEST, st.floats(0.5, 2.0)), min_size=2, max_size=5))
@settings(max_examples=20, deadline=None)
def test_slopes_go_on_to_the_last_bit(ridged, lacunarity, frames):
    """Nearer and farther as they come, two shortest wavelengths at each point."""
    relief, xy = Relief(5, 20.0, 256.0, 0.8, ridged, lacunarity), plane(40)
    so_far, spread = SoFar.none(len(xy), 2), np.linspace(1.0, 2.0, len(xy))
    for first, second, factor in frames:
        shortest = np.outer(spread, (first, second * factor))
        anew = relief.slopes(HOME, xy, shortest)
        assert relief.slopes(HOME, xy, shortest, so_far).tobytes() == anew.tobytes()


@given(frames=st.lists(SHORTEST, min_size=2, max_size=5))
@settings(max_examples=20, deadline=None)
def test_patches_of_colour_go_on_to_the_last_bit(frames):
    xy = plane(50)
    rise = slope = np.full(len(xy), 0.1)
    so_far, spread = SoFar.none(len(xy), 1), np.linspace(1.0, 2.0, len(xy))
    for shortest in frames:
        where = 7, HOME, xy, rise, slope, shortest * spread, COVERS["grassy"]
        assert ground_colours(*where, so_far).tobytes() == ground_colours(*where).tobytes()


def test_what_counts_whole_is_summed_once():
    """Octaves of 256 m to 8 m stay; of nearer points the shorter ones are added."""
    relief, xy, so_far = Relief(5, 20.0, 256.0, 0.8), plane(9), SoFar.none(9, 1)
    relief.slopes(HOME, xy, np.full(9, 8.0), so_far)
    assert (so_far.whole == 6).all()
    so_far.sums[:] += 1.0
    nearer = relief.slopes(HOME, xy, np.full(9, 1.0), so_far)
    assert np.allclose(nearer, relief.slopes(HOME, xy, np.full(9, 1.0)) + 1.0)
    assert (so_far.whole == 9).all()


NAMES = st.lists(st.integers(0, 30), unique=True).map(sorted)


@given(known=NAMES, names=NAMES)
def test_points_take_along_what_is_known_of_them(known, names):
    row = rows_among(np.array(known, np.int64), np.array(names, np.int64))
    assert row.tolist() == [known.index(each) if each in known else -1 for each in names]
    before = SoFar.none(len(known), 2)
    before.whole[:], before.sums[:] = np.array(known)[:, None], np.array(known)[:, None] / 2
    after = before.carried(row, len(names) + 2)
    kept = [each if each in known else 0 for each in names] + [0, 0]
    assert (after.whole == np.array(kept)[:, None]).all()
    assert (after.sums == np.array(kept)[:, None] / 2).all()
