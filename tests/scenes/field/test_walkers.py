"""Walkers against a brute force that poses one object at a time, by the readable rules."""

import math
from functools import lru_cache, partial

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from lod import law
from lod.camera import GRID_M, Corner, camera_from_heading, split_position
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View
from scenes.field.species_field import (
    MIN_STRIDE_FACTOR,
    Species,
    SpeciesField,
    ground_contact_detail,
)
from scenes.figures.animal_file import animal
from scenes.models.catalogue import at_rest, people
from scenes.presets.load import load_preset
from scenes.rig.foot_placement import BODY, FOOTPRINT, Placements, place_on_ground
from scenes.rig.pose import PoseTables, pose_points
from scenes.scene import Scene
from tests.scenes.field.brute_force import Waves, drawn, objects_in, pruned
from tests.scenes.figures.motion_phase import motion_at

FLAT = 0.0
HILLY = 1.5


@lru_cache(maxsize=1)
def companies():
    """Species with prototypes of several kinds and sizes, walking, turning and standing."""
    person, other = people(0, 2)
    rabbit, giraffe, insect = (animal(k) for k in ("rabbit", "giraffe", "insect"))
    return (
        (person, other),
        (person, rabbit.scaled(1.5), giraffe),
        (animal("ostrich"), insect.scaled(12.0), at_rest(other)),
        (animal("windmill").scaled(0.2), other),
    )


def contact_levels(field, view, instances, who):
    """Level of ground contact of some of the instances."""
    xy, prototype = instances.origin[who, :2], instances.prototype[who]
    return ground_contact_detail(field.prototypes, view, xy, prototype)


def world_from(seed, metric, amplitude):
    """A small finite world of walkers and a view of it, at some time."""
    chance = np.random.default_rng(seed)
    prototypes = companies()[chance.integers(len(companies()))]
    extent = float(chance.uniform(10, 120))
    density = float(chance.uniform(0.5, 40)) / extent**2
    species = Species("walker", prototypes, density, float(chance.uniform(0.5, 30)))
    field = SpeciesField(species, int(chance.integers(0, 2**63)), Waves(amplitude), extent)
    corner, x, y = split_position(*chance.uniform(-0.6 * extent, 0.6 * extent, 2))
    eye = np.array((x, y, chance.uniform(-2, 12)))
    angles = chance.uniform(0, 360), chance.uniform(-60, 30), chance.uniform(20, 150)
    view = View(
        camera_from_heading(corner, eye, *angles, (int(chance.integers(5, 60)), 20)),
        METRICS[metric],
        detail=float(chance.lognormal(-1.8, 0.8)),
        offscreen_detail=float(chance.uniform(0.1, 1)),
        look_around=metric != "depth" and bool(chance.random() < 0.3),
        time_s=float(chance.uniform(0, 5000)),
    )
    return field, view


def patrols(field, home, u, time):
    """Where one object is, which way it faces, which it is, and its phase: in closed form."""
    variant = int(u[3] * len(field.species.prototypes))
    motion = field.species.prototypes[variant].motion
    facing, radius = 2 * math.pi * u[2], field.species.patrol_m
    if motion.stride == 0:
        return home, facing, variant, u[4] + time / motion.period, 1.0
    pace = MIN_STRIDE_FACTOR + (1 - MIN_STRIDE_FACTOR) * u[6]
    period = motion.period * pace ** (-2 / 3)
    way = -1 if u[5] < 0.5 else 1
    facing += way * time * pace * motion.stride / period / radius
    spoke = facing - way * math.pi / 2
    at = home[0] + radius * math.cos(spoke), home[1] + radius * math.sin(spoke)
    return at, facing, variant, u[4] + time / period, pace


def origins(field, view, at, facing, variant, phase, pace):
    """Origins of all parts, relative to the frame's corner: of what has no legs by the rig."""
    it, corner = field.species.prototypes[variant], view.camera.corner
    base = np.array([at]) - GRID_M * np.array((corner.x, corner.y))
    if len(it.motion.feet):
        cast, heights = PoseTables.of((it,)), partial(field.ground.height, corner)
        ways = np.array([math.cos(facing)]), np.array([math.sin(facing)])
        first = np.zeros(1, np.int64)
        drawn = first, np.array([phase]), np.array([pace])
        detail = ground_contact_detail(field.prototypes, view, base, np.array([variant]))
        instances = place_on_ground(cast, heights, Placements(base, *ways, *drawn, detail))
        rows, parts = np.zeros(len(it.joint), np.int64), np.arange(len(it.joint))
        return pose_points(cast, instances, rows, parts, np.zeros((len(parts), 3)), it.joint)
    height = field.ground.height(corner, base)[0]
    place = it.rig.frames(*motion_at(it.motion, phase))[0][it.joint]
    cos, sin = math.cos(facing), math.sin(facing)
    spin = np.array(((cos, -sin, 0), (sin, cos, 0), (0, 0, 1)))
    return place @ spin.T + (*base[0], height)


def limits(h, metric, m):
    """Limit distance of every part: its own test, clamped by that of its whole."""
    own = {
        "blake": (h.P + h.R) / m,
        "depth": (h.P + h.R) / m,
        "bounded": h.P / m + h.R,
        "solid_angle": h.P / m,
        "full": np.full(len(h), np.inf),
        "contrast_weighted": h.contrast_to_whole * (h.P + h.R) / m,
    }[metric]
    D = own.copy()
    for i in range(1, len(h)):
        D[i] = max(0.0, min(own[i], D[h.parent[i]] - h.separation[i]))
    return D


def brute_force(field, view, objects):
    """Every part that passes its own test, as (object, prototype, part)."""
    camera, name = view.camera, view.metric.name
    tan_x, tan_y = camera.tan_half
    shown = set()
    for key, home, u in objects:
        at, facing, variant, phase, pace = patrols(field, home, u, view.time_s)
        h = field.species.prototypes[variant].hierarchy
        ray = origins(field, view, at, facing, variant, phase, pace) - camera.eye
        ahead, right, up = ray @ camera.forward, ray @ camera.right, ray @ camera.up
        margin = np.minimum(
            np.minimum(
                (ahead * tan_x - abs(right)) / math.hypot(1, tan_x),
                (ahead * tan_y - abs(up)) / math.hypot(1, tan_y),
            ),
            ahead,
        )
        seen = view.look_around | (margin > -h.B)
        near, m = limits(h, name, view.m), view.m / view.offscreen_detail
        far = np.zeros(len(h)) if name == "depth" else limits(h, name, m)
        d = np.maximum(ahead, 0) if name == "depth" else np.linalg.norm(ray, axis=1)
        shown |= {(key, variant, int(i)) for i in np.flatnonzero(d < np.where(seen, near, far))}
    return shown


@settings(max_examples=20)
@given(
    seed=st.integers(0, 2**32),
    metric=st.sampled_from(sorted(METRICS)),
    amplitude=st.sampled_from((FLAT, HILLY)),
)
def test_the_cut_is_what_brute_force_finds(seed, metric, amplitude):
    field, view = world_from(seed, metric, amplitude)
    assert pruned(field, view)[1] == brute_force(field, view, objects_in(field))


def test_these_worlds_hold_something_to_disagree_about():
    """Most show some parts and hide others: of what is displayed, and by all of five metrics."""
    some = 0
    for seed in range(30):
        field, view = world_from(seed, sorted(METRICS)[seed % len(METRICS)], FLAT)
        _, found = pruned(field, view)
        whole = {(key, v) for key, v, i in found if i == 0}
        parts = sum(len(field.species.prototypes[v].hierarchy) for _, v in whole)
        some += bool(whole) and (len(found) < parts or view.metric.name == "full")
    assert some >= 15


def far_walkers(patrol_m=40.0):
    """An endless field of walkers, seen all round by an eye that resolves the near only."""
    species = Species("walker", people(0, 2), 0.012, patrol_m)
    field = SpeciesField(species, 11, Waves(FLAT))
    camera = camera_from_heading(Corner(3, -2), np.array((5.0, 7.0, 1.6)), 0.0, 0.0, 60.0, (64, 36))
    return field, View(camera, METRICS["blake"], detail=6.0, look_around=True, time_s=321.0)


def test_walkers_far_from_home_are_found():
    """Homes beyond every limit distance are searched, as far as a patrol leads, and no part's R
    is any larger for it.
    """
    field, view = far_walkers()
    still, _ = far_walkers(0.0)
    for own, theirs in zip(
        *(f.prototypes.part_tables.limits(view) for f in (field, still)), strict=True
    ):
        assert np.array_equal(own, theirs)
    limit = max(float(limits(p.hierarchy, "blake", view.m)[0]) for p in field.species.prototypes)
    near, corner = limit + 60, view.camera.corner
    eye = view.camera.eye[:2] + GRID_M * np.array((corner.x, corner.y))
    side = field.cells.side_m
    lows, highs = (np.floor((eye + s * near) / side).astype(int).tolist() for s in (-1, 1))
    objects = list(drawn(field, lows, highs))
    _, found = pruned(field, view)
    assert found == brute_force(field, view, objects)
    homes = {key: math.dist(home, eye) for key, home, _ in objects}
    away = {key for key, *_ in found if homes[key] > limit + 2}
    assert len(away) >= 3
    assert max(homes[key] for key in away) > limit + 20


@pytest.mark.parametrize("kind", ["people", "herd"])
def test_walkers_keep_the_law(kind):
    """All round on flat ground: the mean over seeds, of objects and of parts."""
    prototypes = people(0, 2) if kind == "people" else (animal("ostrich"), animal("giraffe"))
    K, eye, seeds = 0.01, 1.4, 40
    camera = camera_from_heading(Corner(0, 0), np.array((1.0, 2.0, eye)), 0.0, 0.0, 60.0, (160, 90))
    view = View(camera, METRICS["blake"], 5.0, look_around=True, time_s=77.0)
    areas = [_areas(p, view, eye) for p in prototypes]
    for which in (slice(0, 1), slice(None)):
        mean = np.mean([law.expected_count(K, a[which]) for a in areas])
        spread = math.sqrt(np.mean([law.count_variance(K, a[which]) for a in areas]) / seeds)
        counts = []
        for seed in range(seeds):
            cut = prune(SpeciesField(Species("w", prototypes, K, 9.0), seed, Waves(FLAT)), view)
            counts.append(cut.displayed_objects if which.stop == 1 else cut.displayed_parts)
        assert abs(np.mean(counts) - mean) < 3.5 * spread
        assert spread < 0.1 * mean


def _areas(prototype, view, eye):
    """Mean over phases of the ground from which each part is displayed; the whole first."""
    D = law.chained_limits(prototype.hierarchy, METRICS["blake"], view.m)
    poses = [motion_at(prototype.motion, k / 16) for k in range(16)]
    heights = [prototype.rig.frames(*pose)[0][prototype.joint, 2] for pose in poses]
    return np.mean([law.disc_areas(D, eye - h) for h in heights], axis=0)


@lru_cache(maxsize=4)
def preset_field(name):
    """The people of a preset, fewer kinds of them, and the preset."""
    preset = load_preset(name, ["species.figure.prototypes=4", "species.tree.density=0"])
    scene = Scene(preset)
    world = scene.world
    return scene, world.fields[0]


@lru_cache(maxsize=4)
def prune_of(name, frame):
    """The cut of the people of a preset in one frame."""
    scene, field = preset_field(name)
    return prune(field, scene.view(frame))


def foot_spheres(prototype, ankle):
    """Joint, centre and radius of every sphere of a foot and its toes."""
    rig, below = prototype.rig, {ankle}
    for joint, parent in enumerate(rig.parent.tolist()):
        if parent in below:
            below.add(joint)
    rows = [
        (joint, point, radius)
        for t in prototype.full_detail_sticks()
        for joints, points, radii in (
            (t.start_joint, t.start, t.start_radius),
            (t.end_joint, t.end, t.end_radius),
        )
        for joint, point, radius in zip(joints.tolist(), points, radii, strict=True)
        if joint in below
    ]
    return [np.array(column) for column in zip(*rows, strict=True)]


def clearances(field, instances, who, corner):
    """How far the lowest point of each one's feet is above the ground [m], and which stand,
    (n, legs) each.
    """
    clear = np.empty((len(who), instances.foot_contacts.shape[1]))
    stands = np.empty(clear.shape, bool)
    for variant, prototype in enumerate(field.prototypes.rigged):
        of_it, feet = np.flatnonzero(instances.prototype[who] == variant), prototype.motion.feet
        for foot, ankle in enumerate(feet.legs[:, 2].tolist()):
            own = (instances.phase[who[of_it]] - feet.strike[foot]) % 1.0
            stands[of_it, foot] = own <= feet.duty[foot]
            joint, centre, radius = foot_spheres(prototype, ankle)
            rows = np.repeat(who[of_it], len(joint))
            points = np.tile(np.arange(len(joint)), len(of_it))
            at = pose_points(field.prototypes.pose_tables, instances, rows, points, centre, joint)
            ground = field.ground.height(corner, at[:, :2])
            above = at[:, 2] - radius[points] - ground
            clear[of_it, foot] = above.reshape(len(of_it), -1).min(axis=1)
    return clear, stands


@pytest.mark.parametrize("name", ["crowd", "meadow"])
def test_who_is_too_far_to_show_feet_stands_as_well_as_can_be_seen(name):
    """On any slope, by less than a quarter of the detail that is displayed there; and there are
    many of whom only the whole could be, and many of whom more could.
    """
    scene, field = preset_field(name)
    view, parts = scene.view(1), prune_of(name, 1).parts
    instances, who = parts.state.instances, parts.object[parts.parent < 0]
    heed = contact_levels(field, view, instances, who)
    for closely in (FOOTPRINT, BODY):
        some = who[heed == closely][:300]
        assert len(some) == 300
        clear, stands = clearances(field, instances, some, view.camera.corner)
        away = np.linalg.norm(instances.origin[some] - view.camera.eye, axis=1)
        off = np.abs(np.where(stands, clear, 0.0)).max(axis=1)
        assert (off < view.m * away / 4).all()
        feet = parts.part[np.isin(parts.object, some)]
        assert not field.prototypes.foot_parts[feet].any()  # none is displayed
        assert (
            closely == FOOTPRINT
            or (feet == field.prototypes.part_tables.root[instances.prototype[some]]).all()
        )
