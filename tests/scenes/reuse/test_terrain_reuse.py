"""The ground's cut that goes on from the frame before: the same to the last bit as from scratch."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.metric.family import METRICS
from lod.pruning.crossfade import blend_weights
from lod.pruning.pruner import prune
from lod.pruning.view import View
from scenes.preset.load import load_preset
from scenes.reuse.terrain_reuse import ground_after
from scenes.terrain.relief import Relief
from scenes.terrain.terrain import Terrain

PARTS = ("position", "centre", "bound", "limit", "level", "object", "part", "whole", "share")


LOOKS = ("vertices", "normals", "colours", "faces", "owner")


def seen_in(name):
    preset = load_preset(name, ["render.size=96x54"])
    terrain = Terrain(seed=preset.seed, **preset.terrain.model_dump())
    eye = np.array((4.0, 5.0, float(terrain.height(Corner(0, 0), np.array(((4.0, 5.0),)))[0]) + 2))
    return terrain, View(
        camera_from_heading(Corner(0, 0), eye, 0.0, -2.0, 60.0, (96, 54)), METRICS["blake"], 1.0
    )


def same(terrain, view, before):
    """Boxes after a cut that goes on, which is the cut from scratch, and looks like it."""
    read, (cut, boxes) = prune(terrain, view), ground_after(terrain, view, before)
    assert (cut.examined_objects, cut.examined_parts) == (
        read.examined_objects,
        read.examined_parts,
    )
    for name in PARTS:
        assert getattr(cut.parts, name).tobytes() == getattr(read.parts, name).tobytes(), name
    assert len(boxes.names) == read.examined_parts
    ours, anew = (terrain.appearance(each.parts, blend_weights(each, view)) for each in (cut, read))
    for name in LOOKS:
        assert getattr(ours, name).tobytes() == getattr(anew, name).tobytes(), name
    return boxes


@pytest.mark.parametrize("name", ["meadow", "mountain"])
@given(
    steps=st.lists(
        st.tuples(
            st.sampled_from([0.05, 0.3, 40.0]),
            st.floats(-0.1, 0.1),
            st.sampled_from([0.0, 2.0, 90.0]),
        ),
        min_size=2,
        max_size=3,
    ),
)
@settings(max_examples=2, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_ground_is_cut_as_from_scratch(name, steps):
    """Steps, rises and turns as they come, and from another corner at the end."""
    terrain, view = seen_in(name)
    old, eye, heading, boxes = view.camera, view.camera.eye, 0.0, None
    for east, up, turn in steps:
        eye, heading = eye + np.array((east, 0.0, up)), heading + turn
        size = old.width, old.height
        camera = camera_from_heading(old.corner, eye, heading, -2.0, np.degrees(old.fov_x), size)
        boxes = same(terrain, replace(view, camera=camera), boxes)
    same(terrain, replace(view, camera=replace(camera, corner=Corner(3, 5))), boxes)


def test_slow_steps_bound_few_tiles(monkeypatch):
    """A fiftieth of all tiles and less, at walking pace."""
    terrain, view = seen_in("meadow")
    _, boxes = ground_after(terrain, view, None)
    bounded = []
    whole = Terrain.boxes
    monkeypatch.setattr(
        Terrain, "boxes", lambda self, *a: bounded.append(len(a[2])) or whole(self, *a)
    )
    eye = view.camera.eye + np.array((0.04, 0.04, 0.0))
    same_place = replace(view, camera=replace(view.camera, eye=eye))
    _, after = ground_after(terrain, same_place, boxes)
    assert sum(bounded) < 0.02 * len(after.names)


def test_slow_steps_look_up_few_heights(monkeypatch):
    """Of points that stay, heights and whole octaves are kept."""
    terrain, view = seen_in("meadow")
    cut, boxes = ground_after(terrain, view, None)
    whole = terrain.appearance(cut.parts, blend_weights(cut, view))
    looked_up = []
    height = Relief.height
    monkeypatch.setattr(
        Relief,
        "height",
        lambda self, corner, xy: looked_up.append(len(xy)) or height(self, corner, xy),
    )
    eye = view.camera.eye + np.array((0.04, 0.04, 0.0))
    near = replace(view, camera=replace(view.camera, eye=eye))
    cut, _ = ground_after(terrain, near, boxes)
    terrain.appearance(cut.parts, blend_weights(cut, near))
    assert 0 < sum(looked_up) < 0.05 * len(whole.vertices)
