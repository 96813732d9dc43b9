"""What is made of an imported model: areas, limits, stand-ins, joints, and meshes in frames."""

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from bench.conformance import RULES, Subject
from lod.camera import Corner, camera_from_heading
from lod.pruner import blend_weights, prune
from lod.shapes import Mesh, MeshTable, SticksAndTriangles, triangle_areas
from scenes.appearance.tone import displayed_to
from scenes.appearance.visible_area import visible_areas
from scenes.field.species_field import Placed, Species, SpeciesField
from scenes.ground.mesh import Terrain
from scenes.imported.imported_prototype import (
    imported_prototype,
    projected_areas,
    surface_balls,
)
from scenes.imported.library import read_model
from scenes.imported.part_tree import PartTree
from scenes.rig.rigged_prototype import RiggedPrototype
from scenes.sticks.areas import ELEVATIONS_DEG, areas_of_parts, directions
from tests.scenes.imported.sample_models import box, lamp_tree, mill

GROUND = Terrain(seed=4, amplitude=0.4, wavelength=16.0, hurst=0.8, reach=100.0, finest=1.0)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("models")


@pytest.fixture(scope="module")
def mill_tree(folder: Path) -> PartTree:
    return read_model(mill(folder / "mill.usda"))


@pytest.fixture(scope="module")
def lamp_model(folder: Path) -> PartTree:
    return read_model(lamp_tree(folder / "lamps.glb"))


def boxes(*places: tuple[float, float, float], size: float = 1.0) -> MeshTable:
    """A whole without a mesh, and a part with a box at each of these places."""
    corners, quads = box((size, size, size))
    faces = np.array([t for q in quads for t in (q[:3], [q[0], q[2], q[3]])])
    none = np.zeros_like(corners)
    meshes = [Mesh(corners + place, none, none, faces) for place in places]
    return MeshTable.of([None, *meshes])


def test_a_box_covers_what_it_does() -> None:
    views = directions(24)
    areas = projected_areas(np.array([-1, 0]), boxes((0, 0, 0), size=2.0), views)
    np.testing.assert_allclose(areas[1], 4 * np.abs(views).sum(axis=1), rtol=0.02)
    np.testing.assert_array_equal(areas[0], areas[1])


def test_what_hides_behind_another_counts_once() -> None:
    meshes = boxes((0, 0, 0), (5, 0, 0), (0, 0, 9))
    areas = projected_areas(np.array([-1, 0, 0, 0]), meshes, np.eye(3))
    np.testing.assert_allclose(areas[1:], 1, rtol=0.02)
    np.testing.assert_allclose(areas[0], (2, 3, 2), rtol=0.08)


def test_thin_things_are_measured_without_bias() -> None:
    rng = np.random.default_rng(3)
    meshes = boxes(*(tuple(place) for place in rng.uniform(0, 100, (400, 3))), size=0.2)
    parent = np.array([-1] + [0] * 400)
    area = projected_areas(parent, meshes, directions(16)).mean(axis=1)
    assert area[0] == pytest.approx(area[1:].sum(), rel=0.08)


def test_pieces_share_the_surface(mill_tree: PartTree) -> None:
    balls = surface_balls(mill_tree.meshes)[0]
    own = triangle_areas(mill_tree.meshes.vertices, mill_tree.meshes.faces)
    found = np.bincount(balls.owner, 2 * math.pi * balls.start_radius**2, len(mill_tree))
    expected = np.bincount(mill_tree.meshes.owner, own, len(mill_tree))
    np.testing.assert_allclose(found, expected, rtol=1e-12)
    centre = np.bincount(balls.owner, balls.start_radius**2 * balls.start[:, 2], len(mill_tree))
    middles = mill_tree.meshes.vertices[mill_tree.meshes.faces].mean(axis=1)[:, 2]
    by_area = np.bincount(mill_tree.meshes.owner, own * middles, len(mill_tree))
    np.testing.assert_allclose(2 * math.pi * centre, by_area, atol=1e-9)


@pytest.mark.parametrize("which", ["mill_tree", "lamp_model"])
def test_sticks_of_ends_cover_what_the_meshes_do(
    which: str, request: pytest.FixtureRequest
) -> None:
    tree = request.getfixturevalue(which)
    one = imported_prototype(which, tree).posed()
    meshes = projected_areas(tree.parent, tree.meshes, directions()).mean(axis=1)
    sticks = areas_of_parts(one.leaf, directions()).mean(axis=1)
    ends = one.hierarchy.part_count == 0
    np.testing.assert_allclose(sticks[ends], meshes[ends], rtol=0.05)


def test_down_to_every_level_it_covers_what_its_meshes_do(mill_tree: PartTree) -> None:
    """From level 2 on, from elevations at which it was fitted and azimuths at which it was not."""
    one = imported_prototype("mill", mill_tree).posed()
    finest = int(one.hierarchy.level.max())
    sides = directions(24)
    for level in range(2, finest):
        ratios = []
        for row, elevation in enumerate(ELEVATIONS_DEG):
            at = np.abs(np.degrees(np.arcsin(sides[:, 2])) - elevation) < 7.5
            shown, whole = (displayed_to(one, k, row)[0] for k in (level, None))
            areas = [visible_areas(each, sides[at], 0.05).sum(axis=1) for each in (shown, whole)]
            ratios += (areas[0] / areas[1]).tolist()
        assert np.mean(ratios) == pytest.approx(1, abs=0.02)
        assert np.abs(np.array(ratios) - 1).max() < 0.1


def placed(name: str, tree: PartTree) -> Subject:
    prototype = imported_prototype(name, tree)
    reach = float(prototype.hierarchy.B[0])
    eye = np.array((0.0, -4 * reach, reach))
    camera = camera_from_heading(Corner(0, 0), eye, -8.0, -4.0, 65.0, (90, 50))
    make = partial(Placed, name, prototype, 0.0, 0.0, 70.0, GROUND)
    return Subject(make, camera, 1.0)


def in_field(name: str, tree: PartTree) -> Subject:
    prototype = imported_prototype(name, tree)
    extent = 12 * float(prototype.hierarchy.B[0])
    kind = Species(name, (prototype, prototype.scaled(0.7)), 4 / extent**2)
    make = partial(SpeciesField, kind, 3, GROUND, extent)
    eye = np.array((0.0, -0.8 * extent, 3.0))
    camera = camera_from_heading(Corner(0, 0), eye, -8.0, 0.0, 65.0, (90, 50))
    return Subject(make, camera, 2.0, ("blake", "solid_angle"))


@pytest.mark.parametrize(
    ("place", "which"),
    [
        (placed, "mill_tree"),
        (in_field, "lamp_model"),
        pytest.param(in_field, "mill_tree", marks=pytest.mark.slow),
        pytest.param(placed, "lamp_model", marks=pytest.mark.slow),
    ],
)
def test_it_keeps_every_rule(place, which: str, request: pytest.FixtureRequest) -> None:
    subject = place("it", request.getfixturevalue(which))
    assert [found for rule in RULES.values() for found in rule(subject)] == []


def vertices_at(prototype: RiggedPrototype, time_s: float) -> np.ndarray:
    """All corners of the model's meshes in full detail, turned to face north."""
    it = Placed(
        "it",
        prototype,
        0.0,
        0.0,
        90.0,
        Terrain(seed=0, amplitude=0.0, wavelength=8.0, hurst=0.9, reach=64.0, finest=1.0),
    )
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, -60.0, 6.0)), 0, 0, 60, (90, 50))
    view = Subject(lambda: it, camera).view("full", time_s)
    cut = prune(it, view)
    shape = it.appearance(cut.parts, blend_weights(cut, view))
    assert isinstance(shape, SticksAndTriangles)
    assert len(shape.sticks) == 0  # every inner part has all of its parts
    return shape.triangles.vertices


def test_full_detail_is_the_model_itself(mill_tree: PartTree, lamp_model: PartTree) -> None:
    for tree in (mill_tree, lamp_model):
        found = vertices_at(imported_prototype("it", tree), 0.0)
        order = np.lexsort(np.round(found, 6).T)
        expected = tree.meshes.vertices
        np.testing.assert_allclose(
            found[order], expected[np.lexsort(np.round(expected, 6).T)], atol=1e-5
        )


def test_what_turns_is_half_way_round_in_half_a_period(mill_tree: PartTree) -> None:
    prototype = imported_prototype("mill", mill_tree)
    now, then, round_ = (vertices_at(prototype, t) for t in (0.0, 2.0, 4.0))
    np.testing.assert_allclose(round_, now, atol=1e-9)
    moved = np.abs(then - now).max(axis=1) > 1e-9
    assert 0 < moved.sum() < len(now)
    # About the rotor's axis, which looks ahead (x) and is 8.4 m up.
    np.testing.assert_allclose(
        then[moved] - (0, 0, 8.4), (now[moved] - (0, 0, 8.4)) * (1, -1, -1), atol=1e-9
    )
    quarter = vertices_at(prototype, 1.0)[moved] - (0, 0, 8.4)
    turned = (now[moved] - (0, 0, 8.4)) @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    np.testing.assert_allclose(quarter, turned, atol=1e-9)
    soon = vertices_at(prototype, 3.9)
    assert np.linalg.norm(soon - now, axis=1).max() == pytest.approx(
        2 * 6.7 * math.sin(math.pi * 0.1 / 4), rel=0.1
    )
