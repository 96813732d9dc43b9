"""The study of acting, small: who may wait, how far off that is, and that nobody meets."""

import numpy as np

from bench.studies.acting import nearest_m, saving, sticks_off_px, walkers
from lod.pruning.pruner import prune
from scenes.world.cast import make_cast
from scenes.world.view import view_at
from scenes.world.world import build_world, make_terrain


def test_those_who_wait_are_off_by_less_than_the_threshold():
    found = saving(24, 12, 8.0, 0)
    assert 0.1 < found.updated < 0.9
    assert len(found.off_px) > 100
    assert 0 < found.off_px.max() < 8.0
    assert 0.99 < found.parts_ratio < 1.01


def test_sticks_are_held_against_the_same_sticks():
    """Of the same cast nothing is off; of one in which a head has turned, its parts alone."""
    plain = walkers(4, 20.0, 4, 0.0, 0)
    said = {"to": "walker_1 head", "do": "turn z 20deg"}
    turned = plain.model_validate(plain.model_dump() | {"script": (said,)})
    shown, other = (make_cast(each, make_terrain(each)) for each in (plain, turned))
    view = view_at(build_world(plain), plain, 2)
    assert sticks_off_px(shown, shown, view).max() == 0.0
    off = sticks_off_px(shown, other, view)
    parts = prune(shown, view).parts
    assert set(parts.object[off > 1e-6].tolist()) == {0}
    assert 0 < np.count_nonzero(off) < 20


def test_people_keep_clear_of_each_other():
    assert min(nearest_m(12, 12.0, 36, 0)) > 0.4
