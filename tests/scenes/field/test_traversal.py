"""The compiled walks against the level-by-level pruner: the same cut, to the last bit."""

from functools import lru_cache

import numba
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from lod.pruner import blend_weights, prune, prune_by_level
from scenes.presets.load import load_preset
from scenes.scene import Scene

COLUMNS = ("part", "parent", "level", "position", "bound", "limit", "limit_offscreen", "share")


@lru_cache(maxsize=8)
def built(name, extent=None):
    return Scene(load_preset(name, [f"world.extent={extent}"] if extent else []))


def seen_in(name, *settings, frame=1, extent=None):
    """The world of a preset, and a view of it."""
    scene = built(name, extent)
    more = [f"world.extent={extent}"] if extent else []
    scene = scene.with_preset(load_preset(name, [*settings, *more]))
    return scene.world, scene.view(frame)


def same_cut(representation, view):
    """Both cuts, after holding one against the other."""
    read, compiled = prune_by_level(representation, view), prune(representation, view)
    assert (read.examined_objects, read.examined_parts) == (
        compiled.examined_objects,
        compiled.examined_parts,
    )
    for name in COLUMNS:
        a, b = getattr(read.parts, name), getattr(compiled.parts, name)
        assert a.dtype == b.dtype and a.tobytes() == b.tobytes(), name
    for name in ("part", "parent", "level"):
        assert np.array_equal(getattr(compiled, name), getattr(read.parts, name)), name
    if read.parts.state.samples is not None:
        for name in ("cell_x", "cell_y", "index", "u"):
            a, b = (getattr(c.parts.state.samples, name)[c.parts.object] for c in (read, compiled))
            assert np.array_equal(a, b), name
    return read, compiled


views = st.fixed_dictionaries(
    {
        "view.metric": st.sampled_from(["blake", "bounded", "solid_angle", "depth", "full"]),
        "view.detail": st.sampled_from([1.0, 3.0, 12.0]),
        "view.offscreen_detail": st.sampled_from([0.1, 0.25, 1.0]),
        "camera.heading": st.floats(0, 360),
        "camera.pitch": st.floats(-90, 60),
        "camera.fov": st.floats(5, 150),
        "camera.height": st.floats(0.3, 30),
        "camera.cell": st.sampled_from([(0, 0), (-70, 3), (6 * 10**10, -(10**10))]),
    }
)


@given(name=st.sampled_from(["crowd", "zoo"]), keys=views, frame=st.integers(1, 200))
@settings(max_examples=6)
def test_walks_agree_with_the_readable_pruner(name, keys, frame):
    keys = [f"{key}={list(v) if isinstance(v, tuple) else v}" for key, v in keys.items()]
    extent = 30 if "view.metric=full" in keys else None
    world, view = seen_in(name, *keys, "render.size=50x40", frame=frame, extent=extent)
    for each in (*world.fields, *world.placed):
        same_cut(each, view)


def test_the_number_of_threads_changes_nothing(monkeypatch):
    for name in ("lod.pruner", "scenes.rig.pose", "scenes.field.part_tables"):
        monkeypatch.setattr(f"{name}._SHORTEST_RUN", 97)
    world, view = seen_in("crowd", "render.size=200x100", frame=5)
    field = world.fields[0]
    one = []
    before = numba.get_num_threads()
    try:
        for threads in (1, 2):
            numba.set_num_threads(min(threads, before))
            cut = prune(field, view)
            weights = blend_weights(cut, view)
            sticks = field.appearance(cut.parts, weights)
            found = (
                cut.object,
                cut.part,
                cut.parent,
                cut.parts.position,
                weights.inner,
                weights.leaf,
            )
            one.append([c.tobytes() for c in (*found, sticks.start, sticks.end)])
    finally:
        numba.set_num_threads(before)
    assert one[0] == one[1]


def test_small_buffers_are_joined_in_order(monkeypatch):
    world, view = seen_in("meadow", "render.size=200x100")
    field = world.fields[-1]
    whole = prune(field, view)
    monkeypatch.setattr("scenes.field.traversal._ROOM", 1)
    parted = prune(field, view)
    for name in ("object", "part", "parent", "level"):
        assert np.array_equal(getattr(whole, name), getattr(parted, name))
