"""What nobody sees is counted and left out; what is seen, or out of view, stays."""

from functools import lru_cache

import numpy as np

from bench.studies.occlusion import seen_of, without
from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import prune
from lod.pruning.view import in_view
from scenes.frame.types import Visible
from scenes.preset.load import preset_from
from scenes.world.world import build_world, view_at


@lru_cache(maxsize=1)
def hares():
    """Rabbits on rough hills, and a view of some of them."""
    preset = preset_from(
        {
            "species": {"hare": {"model": "rabbit", "density": 0.01}},
            "terrain": {"amplitude": 20.0, "wavelength": 128.0},
            "camera": {"height": 2.0},
        }
    )
    world = build_world(preset)
    view, field = view_at(world, preset, 1), world.fields[0]
    cut = prune(field, view)
    return world, view, Visible("hare", cut, field.appearance(cut.parts, blend_weights(cut, view)))


def test_who_is_met_by_no_ray_is_hidden_and_who_is_out_of_view_is_not():
    world, view, one = hares()
    parts = one.cut.parts
    some = np.unique(parts.object)[::3]
    seen = seen_of(world, view, one, 7, some + 7)
    roots = parts.take(parts.whole < 0)
    inside = in_view(view, roots.centre, roots.bound)
    unseen = inside & ~np.isin(roots.object, some)
    assert 0 < unseen.sum() < inside.sum() < len(roots)
    assert np.array_equal(np.unique(parts.object[seen.hidden]), roots.object[unseen])
    assert seen.counts[:2].tolist() == [inside.sum(), unseen.sum()]
    assert 0 < seen.counts[2] < seen.counts[1]  # hills hide some of them
    assert seen.counts[4] == seen.hidden.sum() < seen.counts[3] < len(parts)


def test_all_sticks_of_the_hidden_are_left_out_and_no_others():
    _, _, one = hares()
    hidden = one.cut.parts.object % 2 == 0
    left = without(one, hidden).shape
    assert len(left) == np.count_nonzero(~hidden[one.shape.owner])
    assert not hidden[left.owner].any()
    assert np.array_equal(left.start, one.shape.start[~hidden[one.shape.owner]])
