"""The cut against a brute force that knows no pruner, no cells to skip and no walk down a tree."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import GRID_M, Corner, camera_from_heading, split_position
from lod.errors import InputError
from lod.eye import CONTRAST_CLASSES, Display, Eye
from lod.hierarchy import Hierarchy
from lod.metric import METRICS
from lod.pruner import blend_weights, prune
from lod.shapes import StickTable
from lod.view import View
from lod.viewing import BlurWidths, ViewingConditions
from scenes.field.species_field import Species, SpeciesField
from scenes.sticks.prototype import Prototype
from tests.scenes.field.brute_force import Waves, instances_in_cells, objects_in, pruned


def prototype_from(chance):
    """A random tree of parts with no regard for what is plausible."""
    parts = int(chance.integers(1, 15))
    whole = np.array([-1] + [int(chance.integers(0, i)) for i in range(1, parts)])
    position = chance.normal(0, 1.5, (parts, 3))
    P, R = chance.lognormal(-0.5, 1, (2, parts)) + np.array([[0.0], [0.3]])
    separation = np.linalg.norm(position - position[whole], axis=1)
    separation[0] = 0.0
    B, level = P + R, np.zeros(parts, int)
    for i in range(parts - 1, 0, -1):
        B[whole[i]] = max(B[whole[i]], separation[i] + B[i])
    for i in range(1, parts):
        level[i] = level[whole[i]] + 1
    contrast = chance.integers(0, len(CONTRAST_CLASSES), parts)
    to_whole = chance.uniform(0.1, 1, parts)
    hierarchy = Hierarchy(whole, level, position, P, R, B, separation, contrast, to_whole)
    table = StickTable(
        first=np.arange(parts + 1),
        start=position,
        end=position + np.array((0.0, 0.0, 0.1)),
        start_radius=np.full(parts, 0.1),
        end_radius=np.full(parts, 0.1),
        tint=np.zeros(parts, int),
    )
    return Prototype("random", hierarchy, table, table, np.array([[0.2, 0.3, 0.1]]))


def world_from(seed, metric):
    """A small finite world and a view of it."""
    chance = np.random.default_rng(seed)
    prototypes = tuple(prototype_from(chance) for _ in range(chance.integers(1, 4)))
    extent = float(chance.uniform(10, 150))
    species = Species("thing", prototypes, float(chance.uniform(0.5, 60)) / extent**2)
    ground = Waves(float(chance.choice([0.0, 3.0])))
    field = SpeciesField(species, int(chance.integers(0, 2**63)), ground, extent)
    corner, x, y = split_position(*chance.uniform(-0.6 * extent, 0.6 * extent, 2))
    eye = np.array((x, y, chance.uniform(-5, 20)))
    angles = chance.uniform(0, 360), chance.uniform(-90, 30), chance.uniform(20, 150)
    camera = camera_from_heading(corner, eye, *angles, (int(chance.integers(5, 60)), 20))
    view = View(
        camera,
        METRICS[metric],
        detail=float(chance.lognormal(-0.7, 0.7)),
        offscreen_detail=float(chance.uniform(0.1, 1)),
        look_around=metric != "depth" and bool(chance.random() < 0.3),
        conditions=sight_from(chance, camera),
    )
    return field, view


def sight_from(chance, camera):
    """Thick air in which a good share of things is lost, an eye or none; or nothing at all."""
    if chance.random() < 0.4:
        return None
    widths = BlurWidths(camera.pixel_angle, *chance.uniform(0, 1, 3) * camera.pixel_angle)
    air = float(chance.choice([0.0, chance.lognormal(-2.5, 1)]))
    return ViewingConditions(widths, air, Display(), Eye(), acuity=bool(chance.random() < 0.6))


@cache
def alone(hierarchy, i, metric, m, sight):
    """Limit distance of a part by its own test, before any clamp."""
    P, R = hierarchy.P[i], hierarchy.R[i]
    clear = {
        "blake": (P + R) / m,
        "depth": (P + R) / m,
        "bounded": P / m + R,
        "solid_angle": P / m,
        "full": math.inf,
        "contrast_weighted": (P + R) / m * hierarchy.contrast_to_whole[i],
    }[metric]
    if metric == "contrast_weighted" and sight is not None and sight.extinction > 0:
        near, far = 0.0, clear
        for _ in range(100):
            middle = (near + far) / 2
            passes = middle < clear * math.exp(-sight.extinction * middle)
            near, far = (middle, far) if passes else (near, middle)
        clear = far
    if sight is None or metric == "full":
        return clear
    W = sight.weighted(CONTRAST_CLASSES[hierarchy.contrast[i]], m)
    near, far = 0.0, clear
    for _ in range(56):
        middle = (near + far) / 2
        near, far = (middle, far) if W.weight(np.array([middle]))[0] <= clear else (near, middle)
    return far


@cache
def clamped(hierarchy, i, metric, m, sight):
    limit, whole = alone(hierarchy, i, metric, m, sight), hierarchy.parent[i]
    if whole >= 0:
        limit = min(limit, clamped(hierarchy, whole, metric, m, sight) - hierarchy.separation[i])
    return max(0.0, limit)


def brute_force(field, view, limit_of):
    """Every part of every object whose own test passes, as (object, part)."""
    camera, name = view.camera, view.metric.name
    corner = GRID_M * np.array((camera.corner.x, camera.corner.y))
    tan_x = math.tan(camera.fov_x / 2)
    tan_y = tan_x * camera.height / camera.width
    shown = set()
    for key, place, u in objects_in(field):
        turn, variant = 2 * math.pi * u[2], int(u[3] * len(field.species.prototypes))
        h = field.species.prototypes[variant].hierarchy
        base = np.append(np.array(place) - corner, 0.0)
        base[2] = field.ground.height(camera.corner, base[None, :2])[0]
        for i, (px, py, pz) in enumerate(h.position):
            spun = (
                px * math.cos(turn) - py * math.sin(turn),
                px * math.sin(turn) + py * math.cos(turn),
                pz,
            )
            ray = base + spun - camera.eye
            ahead, right, up = (
                float(ray @ axis) for axis in (camera.forward, camera.right, camera.up)
            )
            margin = min(
                (ahead * tan_x - abs(right)) / math.sqrt(1 + tan_x**2),
                (ahead * tan_y - abs(up)) / math.sqrt(1 + tan_y**2),
                ahead,
            )
            seen = view.look_around or margin > -h.B[i]
            if name == "depth":
                passes = seen and max(ahead, 0.0) < limit_of(h, i, name, view.m, view.conditions)
            else:
                kept = [limit_of(h, i, name, view.m, view.conditions)]
                if not seen:
                    kept.append(
                        limit_of(h, i, name, view.m / view.offscreen_detail, view.conditions)
                    )
                passes = math.sqrt(ray @ ray) < min(kept)
            if passes:
                shown.add((key, variant, i))
    return shown


def whole_of(field, part):
    key, variant, i = part
    return key, variant, int(field.species.prototypes[variant].hierarchy.parent[i])


@given(seed=st.integers(0, 2**32), metric=st.sampled_from(sorted(METRICS)))
def test_the_cut_is_what_brute_force_finds(seed, metric):
    field, view = world_from(seed, metric)
    _, found = pruned(field, view)
    assert found == brute_force(field, view, clamped)


def test_without_the_clamp_many_cuts_would_fall_apart():
    """At least 20 % of these worlds hold a part that passes alone while its whole does not."""
    torn = seen = 0
    for seed in range(56):
        field, view = world_from(seed, sorted(METRICS)[seed % len(METRICS)])
        passed = brute_force(field, view, alone)
        seen += bool(passed)
        torn += any(p[2] > 0 and whole_of(field, p) not in passed for p in passed)
    assert torn >= 0.2 * 60
    assert seen >= 0.6 * 60


@given(seed=st.integers(0, 2**32), metric=st.sampled_from(sorted(METRICS)))
def test_a_cut_is_a_connected_top_and_leaves_are_marked(seed, metric):
    field, view = world_from(seed, metric)
    cut, found = pruned(field, view)
    assert all(p[2] == 0 or whole_of(field, p) in found for p in found)
    owners = set(cut.parts.parent[cut.parts.parent >= 0].tolist())
    assert set(np.flatnonzero(blend_weights(cut, view).inner > 0).tolist()) == owners
    assert (cut.parts.parent < np.arange(len(cut.parts))).all()


@given(seed=st.integers(0, 2**32), x=st.integers(-(2**36), 2**36), y=st.integers(-(2**36), 2**36))
def test_places_are_exact_far_from_home(seed, x, y):
    """A cell's objects stand where they stand, to 1 µm, 10^12 m from the origin."""
    field = SpeciesField(world_from(seed, "blake")[0].species, seed, Waves(0.0))
    ix, iy, rest_x, rest_y = Corner(x, y).lattice(field.cells.side_m)
    objects = instances_in_cells(field, Corner(x, y), np.array([ix]), np.array([iy]))
    samples = field.cells.sample(np.array([ix]), np.array([iy]))
    side = field.cells.side_m
    for axis, rest in ((0, rest_x), (1, rest_y)):
        assert objects.instances.origin[:, axis] + rest == pytest.approx(
            samples.u[:, axis] * side, abs=1e-6
        )


def test_an_endless_world_has_no_full_cut():
    field, view = world_from(1, "full")
    with pytest.raises(InputError, match=r"world\.extent"):
        prune(SpeciesField(field.species, 0, Waves(0.0)), view)
