"""Pruning that knows motion: nothing at rest, connected at speed, the same by every way."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from lod.camera import GRID_M
from lod.metric import METRICS, limit_distances
from lod.motion import motion_coarsening, motion_steps
from lod.pruner import prune, prune_by_level
from lod.shapes import Sticks, batches_of
from lod.view import distance
from scenes.presets.load import load_preset
from scenes.scene import Scene

SMALL = ("render.size=160x90", "camera.speed=0", "species.tree.prototypes=1", "terrain.amplitude=6")
EYE = "display.pixels_per_degree=67"
PAN = ("view.shutter=180", "camera.turn=90")


@cache
def scene_of(name):
    people = ("species.figure.prototypes=3",)
    wind = ("wind.speed=6",) if name == "crowd" else ()
    preset = load_preset(name, (*SMALL, *people, *wind))
    return Scene(preset)


def view_of(name, *settings, frame=7):
    scene = scene_of(name)
    chosen = load_preset(name, (*SMALL, *settings))
    return scene.world, scene.with_preset(chosen).view(frame)


def same(a, b):
    columns = ("object", "part", "level", "parent")
    return all(np.array_equal(getattr(a, k), getattr(b, k)) for k in columns)


def same_bits(a, b):
    return same(a, b) and all(
        getattr(a.parts, k).tobytes() == getattr(b.parts, k).tobytes()
        for k in ("position", "limit", "limit_offscreen")
    )


@pytest.mark.parametrize("name", ["meadow", "crowd"])
@pytest.mark.parametrize("settings", [("view.shutter=180",), ("camera.turn=90",)])
def test_at_rest_and_at_shutter_0_the_cut_is_the_spatial_one_bit_for_bit(name, settings):
    """A camera at rest; and one that turns, without a shutter: in any frame that looks that way."""
    made, view = view_of(name, *settings)
    _, spatial = view_of(name)
    spatial = replace(spatial, camera=view.camera)
    for each in made.representations:
        assert same_bits(prune(each, view), prune(each, spatial))


@pytest.mark.parametrize(
    "settings",
    [
        (),
        (EYE,),
    ],
)
def test_a_fast_pan_leaves_a_connected_part_of_the_spatial_cut(settings):
    made, view = view_of("meadow", *PAN, *settings)
    for field in made.fields:
        cut, spatial = prune(field, view), prune(field, replace(view, shutter=None))
        assert 0 < len(cut) < 0.95 * len(spatial)
        found, known = (set(zip(*_who(c), strict=True)) for c in (cut, spatial))
        assert found < known
        assert same(cut, prune_by_level(field, view)) or _same_parts(cut, field, view)


def _who(cut):
    samples, rows = cut.parts.state.samples, cut.object
    columns = (samples.cell_x[rows], samples.cell_y[rows], samples.index[rows], cut.part)
    return [column.tolist() for column in columns]


def _same_parts(cut, field, view):
    other = prune_by_level(field, view)
    return sorted(zip(*_who(cut), strict=True)) == sorted(zip(*_who(other), strict=True))


@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle"])
def test_every_part_is_tested_at_the_m_of_its_object(metric):
    """D by the metric's own formula at m·growth; between steps no more than 0.3 % above it."""
    made, view = view_of("meadow", *PAN, f"view.metric={metric}")
    (field,) = (f for f in made.fields if f.name == "figure")
    parts = prune(field, view).parts
    part_tables, motion_step = field.prototypes.part_tables, parts.state.motion_step[parts.object]
    variant = parts.state.instances.prototype[parts.object]
    assert motion_step.min() > 2
    for row in np.random.default_rng(1).integers(0, len(parts), 40):
        tree, m = (
            part_tables.hierarchies[variant[row]],
            view.m * motion_coarsening(float(motion_step[row])),
        )
        own = limit_distances(tree, METRICS[metric], m)
        own = own[parts.part[row] - part_tables.root[variant[row]]]
        assert own * (1 - 1e-12) <= parts.limit[row] <= own * 1.003 + 1e-12
    assert (distance(view, parts.position) < np.maximum(parts.limit, parts.limit_offscreen)).all()


def test_full_keeps_everything():
    made, view = view_of("meadow", *PAN, "view.metric=full", "world.extent=60")
    field = replace(made.fields[0], extent=60.0)
    assert same(prune(field, view), prune(field, replace(view, shutter=None)))


@pytest.mark.parametrize("name", ["crowd", "meadow"])
def test_nothing_swings_faster_than_is_said(name):
    """Sticks of walkers on hills and of trees in the wind, and blades in it, 1/96 s apart."""
    made, view = view_of(name)
    step = 1 / 96
    for field in made.fields:
        cut = prune(field, view)
        seen = cut.parts.take(np.unique(cut.object, return_index=True)[1][:12])
        everything = _all_parts_of(field, seen, view)
        weights = _everything(len(everything))
        times = [field.later(everything, view, 3.0 + k * step) for k in range(6)]
        shapes = [field.appearance(each, weights) for each in times]
        instances = [each.state.instances for each in times]
        for k in range(5):
            most = field.prototypes.max_speed[instances[k].prototype] * step + _turned(
                field, instances, k
            )
            for before, after in zip(batches_of(shapes[k]), batches_of(shapes[k + 1]), strict=True):
                rows = everything.object[before.owner]
                carried = (instances[k + 1].origin - instances[k].origin)[rows]
                own = np.linalg.norm(_ends(after) - _ends(before) - carried, axis=1)
                assert (own <= most[rows] + 1e-9).all()


def _ends(shape):
    """One end of each stick, or one corner of each triangle, (n, 3) [m]."""
    return shape.end if isinstance(shape, Sticks) else shape.vertices[shape.faces[:, 0]]


def _turned(field, instances, k):
    a, b = instances[k], instances[k + 1]
    bound = field.prototypes.part_tables.bound[field.prototypes.part_tables.root][a.prototype]
    return np.hypot(b.cos - a.cos, b.sin - a.sin) * bound


def _all_parts_of(field, wholes, view):
    fine = replace(view, detail=1e-3)
    rows = np.isin(np.arange(len(wholes.state)), wholes.object)
    assert rows.any()
    batch = wholes
    out = [batch]
    while len(batch):
        batch = field.parts_of(batch, fine)
        out.append(batch)
    parts = np.concatenate([b.part for b in out])
    owner = np.concatenate([b.object for b in out])
    order = np.argsort(owner, kind="stable")
    return field.prototypes.parts(wholes.state, owner[order], parts[order], owner[order], fine)


def _everything(n):
    from lod.pruner import BlendWeights

    return BlendWeights(np.ones(n), np.ones(n))


def length_of(exposed, view, start, end):
    """L/θ of a point, from where it is on the scale of smears."""
    rows, none = [np.array([each], float) for each in (start, end)], np.zeros(1)
    motion_step = motion_steps(exposed, view.camera.corner, view.theta, *rows, none, none)
    x = motion_coarsening(float(motion_step[0])) ** 2
    return np.sqrt(max(4 * x**4 / (x + 1) - (x + 1), 0))


def test_a_tracked_subject_stays_sharp_and_what_is_behind_it_smears():
    """The camera turns after somebody who runs by at 6 m/s, 20 m away (pursuit)."""
    look_at = "{{frame={}, position=[0, 0], height=1.7, target=[{}, 20, 1.7]}}"
    keys = ", ".join(look_at.format(frame, x) for frame, x in ((1, -6), (49, 6)))
    flat = ("terrain.amplitude=0", "view.shutter=180", f"camera.keys=[{keys}]")
    preset = load_preset("meadow", (*SMALL[:1], *flat))
    view = Scene(preset).view(25)
    off = GRID_M * np.array((view.camera.corner.x, view.camera.corner.y, 0))
    runs = [np.array(((at - 25) * 0.25, 20.0, 1.7)) - off for at in (24.75, 25.25)]
    behind = np.array((0.0, 60.0, 1.7)) - off
    assert length_of(view.shutter, view, *runs) < 0.02
    turned = 2 * np.arctan(0.0625 / 20) / view.theta
    assert length_of(view.shutter, view, behind, behind) == pytest.approx(turned, rel=1e-3)


def test_the_eyes_window_hides_as_a_shutter_of_a_sixtieth_of_a_second_does():
    """ω_l = 30 Hz; together with a shutter the two add as variances do, and at rest to nothing."""
    ways = {
        "window": ("view.smear=window", "view.shutter=0"),
        "both": ("view.smear=window", "view.shutter=180"),
        "shutter": ("view.shutter=180",),
    }
    seconds = {
        name: view_of("meadow", *way, "camera.turn=90")[1].shutter.duration_s
        for name, way in ways.items()
    }
    assert seconds["window"] == pytest.approx(1 / 60)
    assert seconds["shutter"] == pytest.approx(1 / 48)
    assert seconds["both"] == pytest.approx(np.hypot(1 / 48, 1 / 60))
    made, still = view_of("meadow", *ways["both"])
    for field in made.fields:
        assert same_bits(prune(field, still), prune(field, replace(still, shutter=None)))


def test_a_steady_pan_hides_in_every_frame_what_it_hides_by_itself():
    made, view = view_of("meadow", *PAN)
    alone = replace(view, shutter=replace(view.shutter, neighbour=None))
    for each in made.representations:
        assert same_bits(prune(each, view), prune(each, alone))


def test_what_motion_hides_leaves_its_cover_on_the_ground():
    """At ¾ of its limit a whole is there at rest; in a pan it is gone, and the ground knows."""
    made, view = view_of("meadow", *PAN)
    cover = made.terrain.aggregate_cover
    kind = next(k for k, each in enumerate(cover.species) if each.name == "figure")
    limits = [view.limits(p.hierarchy)[0][0] for p in cover.species[kind].prototypes]
    ahead = view.camera.forward * (1, 1, 0)
    place = view.camera.eye + 0.75 * min(limits) * ahead / np.linalg.norm(ahead)
    gone, still = (
        np.multiply(*cover.undisplayed(each, place[None]))[0, kind]
        for each in (view, replace(view, shutter=None))
    )
    assert (gone, still) == (1, 0)
