"""Cuts that go on from the frame before against cuts from scratch: the same to the last bit."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from lod.camera import Corner, camera_from_heading
from lod.pruning.parts import Sticks
from lod.pruning.pruner import prune
from scenes.frame.frame_input import assemble_frame
from scenes.preset.load import load_preset
from scenes.reuse.field_reuse import FARTHEST_WALKING_M, cut_after
from scenes.rig.height_bound import height_bound, max_rise, max_speed
from scenes.world.view import view_at
from scenes.world.world import build_world

COLUMNS = ("object", "part", "level", "whole")
PARTS = ("position", "bound", "limit", "limit_offscreen", "share", "object", "part", "whole")
WORLDS = {}


def seen_in(name):
    if name not in WORLDS:
        preset = load_preset(name, ["render.size=96x54"])
        world = build_world(preset)
        WORLDS[name] = world, view_at(world, preset, 2)
    return WORLDS[name]


def same(field, view, before):
    """The hold of a cut that goes on, which is the cut from scratch."""
    read = prune(field, view)
    cut, hold = cut_after(field, view, before)
    assert (cut.examined_objects, cut.examined_parts) == (
        read.examined_objects,
        read.examined_parts,
    )
    for name in COLUMNS:
        a, b = getattr(cut, name), getattr(read, name)
        assert a.dtype == b.dtype and np.array_equal(a, b), name
    for name in PARTS:
        assert getattr(cut.parts, name).tobytes() == getattr(read.parts, name).tobytes(), name
    drawn, also = (each.parts.state for each in (cut, read))
    assert np.array_equal(drawn.draws.u, also.draws.u)
    for name in ("origin", "cos", "sin", "phase", "foot_contacts"):
        assert np.array_equal(getattr(drawn.instances, name), getattr(also.instances, name)), name
    return hold


steps = st.tuples(
    st.floats(-0.3, 0.3),
    st.floats(-0.3, 0.3),
    st.floats(-0.05, 0.05),
    st.sampled_from([0.0, 0.0, 0.1, -3.0, 40.0]),
    st.floats(0, 0.2),
)


@pytest.mark.parametrize(
    "name",
    [
        *("meadow", "crowd", "zoo"),
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("forest", "aerial", "mountain")),
    ],
)
@given(
    start=st.tuples(st.floats(3, 13), st.floats(3, 13), st.floats(0, 360)),
    steps=st.lists(steps, min_size=2, max_size=4),
)
@settings(max_examples=2, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_a_walk_is_cut_as_from_scratch(name, start, steps):
    """Steps, turns and time as they come: what holds is never more than what is so."""
    world, first = seen_in(name)
    for field in world.fields:
        x, y, heading = start
        time_s, hold = 5.0, None
        eye, old = np.array((x, y, first.camera.eye[2])), first.camera
        for east, north, up, turn, later in steps:
            eye = eye + np.array((east, north, up))
            heading, time_s = heading + turn, time_s + later
            size = old.width, old.height
            camera = camera_from_heading(
                old.corner, eye, heading, -2.0, np.degrees(old.fov_x), size
            )
            hold = same(field, replace(first, camera=camera, time_s=time_s), hold)


@given(x=st.floats(0, 16), far=st.sampled_from([0.01, 0.2, 1.0, 7.0, 300.0]))
@settings(max_examples=4, deadline=None, phases=[Phase.explicit, Phase.generate])
def test_a_hold_is_of_use_only_where_it_fits(x, far):
    """Another corner, other limits: all is examined again."""
    world, first = seen_in("meadow")
    field, hold = world.fields[0], None
    for number, corner in enumerate((first.camera.corner, Corner(5, 5), Corner(5, 5))):
        eye = np.array((x + far * number, 4.0, first.camera.eye[2]))
        camera = replace(first.camera, corner=corner, eye=eye)
        hold = same(field, replace(first, camera=camera, detail=1.0 + 0.2 * number), hold)


def test_slow_steps_examine_little():
    """Few of all objects, at walking pace."""
    world, first = seen_in("meadow")
    field = world.fields[1]
    _, hold = cut_after(field, first, None)
    eye = first.camera.eye + np.array((0.04, 0.04, 0.0))
    before = len(hold.pool[0])
    cut, hold = cut_after(field, replace(first, camera=replace(first.camera, eye=eye)), hold)
    assert len(hold.pool[-1]) < 0.04 * before
    assert hold.order.size == len(cut.parts.state)


@pytest.mark.parametrize("name", ["crowd", "zoo"])
def test_nobody_rises_further_than_is_said(name):
    """Origins of walkers between two times, against the bound; and speed against its own."""
    world, view = seen_in(name)
    for field in (each for each in world.fields if each.species.patrol_m):
        ranks = np.arange(-12, 12)
        x, y = (each.ravel() for each in np.meshgrid(ranks, ranks))
        corner, speed = view.camera.corner, max_speed(field.troupe.rigged)
        gone = FARTHEST_WALKING_M / speed
        most = height_bound(field.troupe.pose_tables, field.ground, FARTHEST_WALKING_M)
        first = field.objects(corner, x, y, 3.0).instances.origin
        for later in np.linspace(0.05, 1.0, 7) * gone:
            moved = field.objects(corner, x, y, 3.0 + later).instances.origin - first
            assert np.abs(moved[:, 2]).max() <= most
            assert np.hypot(moved[:, 0], moved[:, 1]).max() <= speed * later * (1 + 1e-9)


def test_ground_rises_no_further_than_is_said():
    world, view = seen_in("mountain")
    rng = np.random.default_rng(1)
    for far in (0.1, 1.0, 10.0, 500.0):
        at = rng.uniform(-3000, 3000, (500, 2))
        turn = rng.uniform(0, 2 * np.pi, 500)
        there = at + far * np.stack((np.cos(turn), np.sin(turn)), axis=1)
        a, b = (world.terrain.height(view.camera.corner, each) for each in (at, there))
        assert np.abs(a - b).max() <= max_rise(world.terrain, far)


def test_frames_in_a_row_are_the_frames_alone():
    """What is handed to the renderer, with what the frames before left and without."""
    preset = load_preset("meadow", ["render.size=96x54"])
    world, holds = build_world(preset), {}
    for frame in (1, 2, 3):
        row, alone = (assemble_frame(world, preset, frame, "scalar_rgb", h) for h in (holds, None))
        for one, other in zip(row.visible, alone.visible, strict=True):
            for name in COLUMNS:
                assert np.array_equal(getattr(one.cut, name), getattr(other.cut, name)), name
            names = ("start", "end", "start_radius", "end_radius", "tint", "owner")
            for name in names if isinstance(one.shape, Sticks) else ():
                a, b = getattr(one.shape, name), getattr(other.shape, name)
                assert a.tobytes() == b.tobytes(), name
    assert set(holds) == {"terrain"} | {each.name for each in world.fields if not each.moves}
