"""Copies of models against the same objects flat: one picture, whatever shares its shapes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from bench.methods import known_methods
from lod.metric import METRICS
from lod.pruner import cut_from_parts, prune
from lod.shapes import Instanced, SticksAndTriangles
from lod.view import View
from scenes.field.species_field import Species, SpeciesField
from scenes.frame.frame_input import (
    DisplayedRepresentation,
    FrameInput,
    Quality,
    display,
    display_whole,
)
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.memory import forecast
from scenes.render.render import render_frame
from scenes.scene import Scene
from tests.scenes.field.brute_force import Waves
from tests.scenes.field.test_species_field import prototype_from

pytestmark = pytest.mark.skipif(
    variants.works(variants.JIT_VARIANT) is not True, reason="copies need a JIT variant"
)


def scene(name, objects, *more):
    more = "species.sward.density=0", *more
    density = sum(each.density for each in load_preset(name, more).species.values())
    side = math.sqrt(objects / density)
    keys = [f"world.extent={side!r}", f"terrain.reach={side!r}", "view.metric=full", *more]
    return Scene(load_preset(name, ["render.size=96x54", "render.spp=4", *keys]))


def copies_of(made):
    return [each.shape for each in made.displayed if isinstance(each.shape, Instanced)]


def assert_same_picture(copied, flat, differ=0.003):
    """Thin twigs round otherwise far from the origin: some few samples meet what is beside."""
    same = np.abs(copied.Z - flat.Z) < 1e-4 * flat.Z
    assert np.mean(~same) < differ
    for ids in ("object", "part", "level"):
        np.testing.assert_array_equal(getattr(copied, ids)[same], getattr(flat, ids)[same])
    off = np.linalg.norm(copied.N - flat.N, axis=-1)[same]
    assert np.mean(off > 5e-3) < differ
    np.testing.assert_allclose(copied.albedo[same], flat.albedo[same], atol=0.3)
    assert copied.rgb.mean() == pytest.approx(flat.rgb.mean(), rel=1e-3)


def test_a_whole_field_looks_the_same_as_copies_and_flat(make):
    """Three models on waves: hits, normals, guides, ids and shares of pixels by object."""
    models = tuple(prototype_from(np.random.default_rng(seed)) for seed in (1, 2, 3))
    field = SpeciesField(Species("thing", models, 0.1), 5, Waves(1.5), 40.0)
    camera = make.camera((96, 54), eye=(0.0, -12.0, 4.0))
    view = View(camera, METRICS["full"])
    pictures = []
    for one in (display_whole(field, view), display(field, prune(field, view), view)):
        quality = replace(make.quality(variants.JIT_VARIANT, 16), coverage=True)
        made = FrameInput(camera, (one, make.ground()), make.clear, make.light, quality)
        pictures.append(render_frame(made, 1))
    copied, flat = pictures
    assert copied.statistics["copies"] > 100
    assert len(np.unique(flat.object)) > 30
    assert_same_picture(copied, flat)
    shares = [np.bincount(p.coverage.object, p.coverage.share) for p in pictures]
    np.testing.assert_allclose(*shares, atol=1e-3 * shares[1].sum())


@pytest.mark.slow
@pytest.mark.parametrize("method", ["full", "in_view"])
def test_methods_that_prune_nothing_draw_copies_of_what_stands_still(method, monkeypatch):
    """Trees and people on hills, as the presets have them."""
    here, pictures = scene("meadow", 100), []
    for shared in (True, False):
        monkeypatch.setattr(Quality, "draws_copies", property(lambda quality, _s=shared: _s))
        made = known_methods.METHODS[method].prepare(here, 0.0)(1, variants.JIT_VARIANT)
        assert bool(copies_of(made)) == shared
        pictures.append(render_frame(made, 1))
    assert pictures[0].statistics["copies"] > 10
    assert_same_picture(*pictures)


def turned(vectors, turn):
    (c, s), (x, y, z) = turn, vectors.T
    return np.stack((c * x - s * y, s * x + c * y, z), axis=1)


def test_sticks_and_meshes_of_one_model_are_told_apart(make):
    """Two models of both kinds, placed by hand and turned, against the same shapes flat."""
    balls = make.balls([(0, 0, 0.5), (0.9, 0, 1.0), (0, 0.4, 2.0)], radius=0.4, albedo=0.7)
    wall = make.quad([(-1.5, 1, 0), (1.5, 1, 0), (1.5, 1, 2), (-1.5, 1, 2)], albedo=0.3)
    other = np.array([0, 0, 1])
    model = np.append(other, [0, 1])  # of three balls and two walls, which are parts 3 and 4
    corners = np.concatenate((wall.shape.vertices, wall.shape.vertices * 0.8))
    walls = replace(
        wall.shape,
        vertices=corners,
        normals=np.tile(wall.shape.normals, (2, 1)),
        colours=np.repeat([[0.3] * 3, [0.6] * 3], 4, axis=0),
        faces=np.concatenate((wall.shape.faces, wall.shape.faces + 4)),
        owner=np.repeat([3, 4], 2),
    )
    which, angle = np.array([0, 1, 1, 0]), np.radians([0, 30, -50, 20])
    place = np.array([(-3, 9, 0), (0, 8, 0.3), (2, 11, -0.2), (5, 14, 0)], float)
    turn = np.stack((np.cos(angle), np.sin(angle)), axis=1)
    part, level = 10 + np.arange(5), np.arange(5)
    shape = SticksAndTriangles(balls.shape, walls)
    wholes = cut_from_parts(balls.cut.parts.take(np.zeros(4, int)), 4, 4)
    wholes = replace(wholes, object=np.arange(4))
    copied = Instanced(shape, model, part, level, which, place, turn)
    rows = []  # of the flat picture: every part of every copy
    sticks, triangles = [], []
    for copy, at in enumerate(place):
        own = np.flatnonzero(model == which[copy])
        first, number = len(rows), {part: k for k, part in enumerate(own)}
        rows += [(copy, part[k], level[k]) for k in own]
        mine = np.isin(balls.shape.owner, own)
        sticks.append(
            [
                *(
                    turned(getattr(balls.shape, end)[mine], turn[copy]) + at
                    for end in ("start", "end")
                ),
                [first + number[k] for k in balls.shape.owner[mine]],
            ]
        )
        face = np.isin(walls.owner, own)
        corner = np.unique(walls.faces[face])
        triangles.append(
            (
                turned(walls.vertices[corner], turn[copy]) + at,
                corner,
                first + number[int(walls.owner[face][0])],
                copy,
            )
        )
    start, end, owner = (np.concatenate(column) for column in zip(*sticks, strict=True))
    flat_sticks = replace(
        balls.shape,
        start=start,
        end=end,
        owner=owner,
        tint=np.zeros(len(owner)),
        start_radius=np.full(len(owner), 0.4),
        end_radius=np.full(len(owner), 0.4),
    )
    corners = np.concatenate([each[1] for each in triangles])
    flat_walls = replace(
        walls,
        vertices=np.concatenate([each[0] for each in triangles]),
        normals=np.concatenate([turned(walls.normals[c], turn[k]) for _, c, _, k in triangles]),
        colours=walls.colours[corners],
        faces=np.concatenate([wall.shape.faces + 4 * k for k in range(4)]),
        owner=np.repeat([each[2] for each in triangles], 2),
    )
    columns = np.array(rows).T
    parts = balls.cut.parts.take(np.zeros(len(rows), int))
    parts = replace(parts, object=columns[0], part=columns[1], level=columns[2])
    flat = SticksAndTriangles(flat_sticks, flat_walls)
    pictures = []
    for cut, seen in ((wholes, copied), (cut_from_parts(parts, 4, 4), flat)):
        shown = (make.ground(), DisplayedRepresentation("both", cut, seen))
        quality = make.quality(variants.JIT_VARIANT, 16)
        made = FrameInput(make.camera((96, 54)), shown, make.clear, make.light, quality)
        pictures.append(render_frame(made, 1))
    assert len(np.unique(pictures[1].part)) > 5
    assert_same_picture(*pictures)


@pytest.mark.slow
def test_forecasts_count_the_sticks_of_prototypes_once():
    here = scene("meadow", 100_000)
    view = here.view(1)
    flat, shared = (forecast(here.world, view, copies=copies) for copies in (False, True))
    assert shared.copies == pytest.approx(100_000, rel=0.15)
    assert shared.sticks < flat.sticks / 100
