"""Ground that morphs: the same sheet, no jump when tiles come and go, watertight all the while."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings

from lod.pruner import blend_weights, prune
from lod.view import distance
from scenes.ground.mesh import (
    MOST_COARSER,
    coarser_edge_ends,
    geomorph_parents,
    lattice_mesh,
    morph,
    vertex_levels,
)
from scenes.ground.quadtree import balance
from tests.scenes.ground.grounds import (
    ROUGH,
    assert_watertight,
    cut_and_mesh,
    grounds,
    probe_count,
    random_patches,
    view_of,
    views,
)


def probes_about(view, most, count=1500):
    rng = np.random.default_rng(3)
    turn, away = 2 * np.pi * rng.random(count), 10 ** rng.uniform(0, np.log10(most), count)
    probes = view.camera.eye[:2] + away[:, None] * np.stack((np.cos(turn), np.sin(turn)), axis=1)
    return probes[np.argsort(probes[:, 0])]


@settings(max_examples=15)
@given(terrain=grounds, view=views)
def test_a_morphing_mesh_is_watertight(terrain, view):
    view = replace(view_of(terrain, **view), fade=0.3)
    assert_watertight(terrain, view, *cut_and_mesh(terrain, view))


def from_east(x, fade=0.0):
    """A view from 1 m up at (x, 14) over rough ground."""
    view = replace(view_of(ROUGH, look_around=True, size=(40, 22)), fade=fade)
    return replace(view, camera=replace(view.camera, eye=np.array((x, 14.0, 1.0))))


def tiles_from(x):
    parts = prune(ROUGH, from_east(x)).parts
    return {*zip(parts.level.tolist(), parts.part.tolist(), parts.object.tolist(), strict=True)}


def events(count):
    """Places before and after which, a micrometre on, other tiles are displayed."""
    at, tiles = 3.0, tiles_from(3.0)
    while count:
        step, after = 0.5, tiles_from(at + 0.5)
        if after != tiles:
            count -= 1
            near, far = at, at + step
            while far - near > 1e-6:
                middle = (near + far) / 2
                near, far = (near, middle) if tiles_from(middle) != tiles else (middle, far)
            yield near, far
        at, tiles = at + step, after


def jumps(near, far, fade):
    """Largest differences between two frames: of height [px], of colour, of normals."""
    meshes = []
    for x in (near, far):
        cut = prune(ROUGH, view := from_east(x, fade))
        meshes.append(ROUGH.appearance(cut.parts, blend_weights(cut, view)))
    probes = probes_about(view, 100.0)
    z = [probe_count(mesh.vertices, mesh.faces, probes)[1] for mesh in meshes]
    pixel = distance(view, np.column_stack((probes, z[0]))) * view.camera.pixel_angle
    places = [mesh.vertices[:, 0] + 1j * mesh.vertices[:, 1] for mesh in meshes]
    _, old, new = np.intersect1d(*places, return_indices=True)
    colour, turned = (
        np.abs(getattr(meshes[1], name)[new] - getattr(meshes[0], name)[old]).max()
        for name in ("colours", "normals")
    )
    return (np.abs(z[1] - z[0]) / pixel).max(), colour, turned


def test_tiles_come_and_go_and_nothing_jumps():
    """Two eyes a micrometre apart see other tiles; without a band, also another ground."""
    some = list(events(2))
    clipped, morphed = (np.array([jumps(*at, fade) for at in some]) for fade in (0.0, 0.3))
    assert np.all(morphed < 1e-5)
    assert clipped[:, 0].max() > 0.05


@pytest.mark.parametrize("seed", range(3))
def test_vertices_arrive_on_the_coarser_mesh(seed):
    """At morph fraction 0 the vertices of the finest level lie on the edges of the next."""
    patches, coarser = balance(random_patches(seed), MOST_COARSER)
    where, _, _ = lattice_mesh(patches, coarser)
    level = vertex_levels(where, patches.deepest)
    finest = level.max()
    seen = []

    def placed(at):
        seen.append(at)
        return np.column_stack((at, np.zeros(len(at))))

    lines = geomorph_parents(
        where, patches.deepest, placed, lambda _, of: (of < finest).astype(float)
    )
    everywhere = np.concatenate(seen)
    height = np.random.default_rng(seed).random((len(everywhere), 1))
    found = morph(lines, height)
    rows = np.flatnonzero(level == finest)
    index = {tuple(at): k for k, at in enumerate(everywhere.tolist())}
    for row, (a, b) in zip(rows, coarser_edge_ends(where[rows], patches.deepest), strict=True):
        assert np.array_equal(a + b, 2 * where[row])
        ends = [index[tuple(end.tolist())] for end in (a, b)]
        assert np.all(vertex_levels(everywhere[ends], patches.deepest) < finest)
        assert found[row, 0] == pytest.approx(height[ends, 0].mean(), abs=1e-12)
    assert np.array_equal(found[level < finest], height[: len(where)][level < finest])
