"""Batches and chains of sticks, ids of a frame, no wrong number, and the medium as reference."""

import dataclasses
from dataclasses import replace

import numpy as np
import pytest

from lod.air import CLEAR, Air
from lod.errors import InputError
from lod.shapes import Sticks
from scenes.frame.frame_input import FrameInput, Quality, sampler_seed
from scenes.frame.layers import SKY_Z
from scenes.render import variants
from scenes.render.description import PlacedSticks, batches, chains, describe_frame
from scenes.render.render import render_frame
from scenes.render.samples import sample_groups, square_sides


def described(make, *visible):
    return describe_frame(make.frame(*visible))


def sticks(points, radii, tint=None, tints=((0.5, 0.5, 0.5),)):
    points, radii = np.asarray(points, float), np.asarray(radii, float)
    n = len(points) - 1
    tint = np.zeros(n, int) if tint is None else np.asarray(tint)
    return Sticks(
        points[:-1], points[1:], radii[:-1], radii[1:], tint, np.asarray(tints), np.arange(n)
    )


def test_joined_sticks_of_one_colour_are_one_chain():
    """Segments 0-1, 1-2 and 2-3, of which the last has another colour, and 5-6 apart."""
    ends = np.arange(28.0).reshape(7, 4)
    curve = {
        "segment_indices": np.array([0, 1, 2, 5], np.uint32),
        "control_points": ends.ravel(),
        "tint": np.array([0, 0, 1, 1], np.uint32),
        "tints": np.array([[0.1, 0.2, 0.3], [0.4, 0.5, 0.6]]),
    }
    points, counts, tints = chains(curve)
    assert counts.tolist() == [3, 2, 2]
    assert points[:, 0].tolist() == [0.0, 4.0, 8.0, 8.0, 12.0, 20.0, 24.0]
    assert tints[:, 0].tolist() == [0.1, 0.4, 0.4]


def loose(ends, tint=None, tints=((0.5, 0.5, 0.5),)):
    """Sticks of ends (n, 2, 4), each owned by the part of its own row."""
    n = len(ends)
    tint = np.zeros(n, int) if tint is None else tint
    columns = ends[:, 0, :3], ends[:, 1, :3], ends[:, 0, 3], ends[:, 1, 3]
    return Sticks(*columns, tint, np.asarray(tints), np.arange(n))


def palettes_of_limbs(seed):
    """Two representations that share a tint, and every stick as (tint, ends, owner)."""
    chance = np.random.default_rng(seed)
    palettes = [[(0.1,) * 3, (0.2,) * 3], [(0.2,) * 3, (0.05,) * 3]]
    placed, every = [], []
    for palette in palettes:
        ends = chance.integers(0, 2, (40, 2, 4)) + np.array((0, 0, 0, 1.0))
        ends[:, 1, 0] += 5
        ends[1::2, 1, 0] += 5
        ends[1::2, 0] = ends[::2, 1]
        tint = np.repeat(chance.integers(0, 2, 20), 2)
        part = 1 + 50 * len(placed)
        later = loose(ends + 1.0, tint, palette)
        placed.append(PlacedSticks(loose(ends, tint, palette), part, later))
        every += [(palette[t][0], ends[i], part + i) for i, t in enumerate(tint)]
    return placed, every


@pytest.mark.parametrize("by_tint", [True, False])
@pytest.mark.parametrize("most", [3, 7, 50, 10**6])
def test_sticks_are_laid_tint_by_tint_in_their_order(most, by_tint):
    """Against a selection by hand; batches that are full begin anew, even within a chain."""
    placed, every = palettes_of_limbs(most)
    made = list(batches(placed, by_tint, most))
    assert max(len(batch.segments) for batch in made) <= most
    assert all(len(b.tints) == len(b.counts) for b in made)
    assert all(b.counts.sum() == len(b.segments) == len(b.owners) for b in made)
    if by_tint:
        assert all(len(b.tints) == 1 for b in made)
    elif most > len(every):
        assert len(made) == 1
    tint = np.concatenate([np.repeat(b.tints[:, 0], b.counts) for b in made])
    ends = np.concatenate([b.points[b.segments[:, None] + np.arange(2)] for b in made])
    owners = np.concatenate([b.owners for b in made])
    assert np.array_equal(tint, np.sort(tint))
    for colour in (0.05, 0.1, 0.2):
        mine = tint == colour
        assert np.array_equal(ends[mine], [e for c, e, _ in every if c == colour])
        assert np.array_equal(owners[mine], [i for c, _, i in every if c == colour])
    assert all(len(b.points) < 2 * len(b.segments) for b in made if len(b.segments) > 4)
    assert all((b.moves == 1.0).all() and len(b.moves) == len(b.owners) for b in made)


def test_points_become_short_sticks_wherever_they_are():
    far = np.array([[4e4, 3e4, 200.0]])
    ball = Sticks(far, far, np.ones(1), np.ones(1), np.zeros(1), np.full((1, 3), 0.5), np.zeros(1))
    (batch,) = batches([PlacedSticks(ball, 1, None)], True)
    assert len(batch.points) == 2 and batch.points[0, 2] != batch.points[1, 2]


def test_a_tint_without_sticks_keeps_its_shape(make):
    two = sticks([(0, 0, 0), (0, 0, 1)], [1, 1], [1], [(0.1, 0.1, 0.1), (0.2, 0.2, 0.2)])
    made = list(batches([PlacedSticks(two, 1, None)], True))
    assert [len(batch.segments) for batch in made] == [0, 1]


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("start", np.nan),
        ("start_radius", -0.1),
        ("tints", 1.5),
        ("tint", 1),
        ("owner", 9),
    ],
)
def test_sticks_that_the_renderer_would_accept_silently_are_refused(make, field, value):
    good = make.balls([(0, 5, 0), (1, 5, 0)])
    values = np.array(getattr(good.shape, field))
    values.reshape(-1)[-1] = value
    bad = dataclasses.replace(good.shape, **{field: values})
    with pytest.raises(InputError, match="balls"):
        described(make, dataclasses.replace(good, shape=bad))


@pytest.mark.parametrize(
    ("field", "value"),
    [("vertices", np.nan), ("normals", np.inf), ("colours", -0.1), ("faces", 4), ("owner", 1)],
)
def test_triangles_that_the_renderer_would_accept_silently_are_refused(make, field, value):
    good = make.ground()
    values = np.array(getattr(good.shape, field))
    values.reshape(-1)[-1] = value
    bad = dataclasses.replace(good.shape, **{field: values})
    with pytest.raises(InputError, match="ground"):
        described(make, dataclasses.replace(good, shape=bad))


def test_seeds_differ_by_everything_and_fit_the_sampler():
    seeds = [sampler_seed(s, f, w) for s in (0, 1, 2**63 - 1) for f in (0, 1) for w in (0, 1)]
    assert len(set(seeds)) == 12 and all(0 <= seed < 2**32 for seed in seeds)
    assert sampler_seed(7, 1, 0) == sampler_seed(7, 1, 0) != sampler_seed(7, 1)


@pytest.mark.parametrize("spp", [*range(1, 70), 256, 1000, 4096, 65536])
def test_samples_are_shared_out_exactly(spp):
    assert sum(sample_groups(spp)) == spp
    assert sum(side**2 for side in square_sides(spp)) == spp
    assert len(square_sides(spp)) <= 5


def test_what_moves_is_told_stick_by_stick(make):
    """By the shape that they ended up in; shapes of which no stick moves have no table."""
    still, moving = make.balls([(0, 9, 0)], albedo=0.2), make.balls([(1, 9, 0), (2, 9, 0)])
    shape = moving.shape
    shift = np.array([[0.5, 0, 0], [0, 0.25, 0]])
    later = replace(shape, start=shape.start + shift, end=shape.end + 2 * shift)
    visible = [still, replace(moving, later=later)]
    found = describe_frame(make.frame(*visible, after=make.camera()))
    (moves,) = found["moves"].values()
    assert np.array_equal(moves[:, 0], shift) and np.array_equal(moves[:, 1], 2 * shift)
    assert described(make, still)["moves"] == {}


def test_what_glows_is_a_mesh_of_each_radiance(make):
    ground = make.ground()
    glows = np.array([[2.0, 1.0, 0.0], [9.0, 9.0, 9.0], [1.0, 0.0, 0.0]])
    fire = replace(
        ground, name="fire", shape=replace(ground.shape, glow=np.array([2, 0]), glows=glows)
    )
    shapes = described(make, ground, fire)["shapes"]
    assert [shape.get("glow", np.zeros(0)).tolist() for shape in shapes.values()] == [
        [],
        [2.0, 1.0, 0.0],
        [1.0, 0.0, 0.0],
    ]
    assert [len(shape["faces"]) for shape in shapes.values()] == [2, 1, 1]
    with pytest.raises(InputError, match="fire glow"):
        described(make, replace(fire, shape=replace(fire.shape, glows=-glows)))


AIR = Air(2000.0)


def test_the_medium_changes_colour_alone(make, variant):
    """Ids, depth and sky stay those of what is displayed: the box is no object."""
    scene = [make.balls([(x, 12.0, 1.5) for x in range(-8, 9, 4)], 1.5), make.ground(300.0)]
    camera = make.camera((32, 18))
    frames = [
        render_frame(
            FrameInput(camera, tuple(scene), AIR, make.light, Quality(variant, 4, 1, 4, haze))
        )
        for haze in ("analytic", "medium")
    ]
    plain, hazy = frames
    assert set(np.unique(hazy.object)) == set(np.unique(plain.object))
    for name in ("Z", "N", "albedo", "object", "part", "level"):
        np.testing.assert_array_equal(getattr(hazy, name), getattr(plain, name), err_msg=name)
    assert (hazy.Z[hazy.object == 0] == SKY_Z).all()
    assert hazy.statistics["medium_top_m"] == 13 and hazy.statistics["medium_bottom_m"] == -1
    assert not np.array_equal(plain.rgb, hazy.rgb)
    assert plain.rgb.mean() == pytest.approx(hazy.rgb.mean(), rel=0.2)


def test_a_medium_in_clear_air_is_refused(make):
    quality = Quality(variants.SCALAR_VARIANT, haze="medium")
    with pytest.raises(InputError, match="--haze"):
        render_frame(FrameInput(make.camera(), (), CLEAR, make.light, quality))
