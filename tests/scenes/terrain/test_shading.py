"""How the ground is shaded: as rough as its relief, by waves that its mesh can show, and never by a
side that the eye does not see."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from lod.arrays import Points, Reals
from scenes.terrain.colour import GROUND_MATERIALS
from scenes.terrain.relief import unit_normals
from scenes.terrain.shading import (
    GroundInView,
    bare_shading,
    spacing_at,
)
from scenes.terrain.terrain import Terrain
from tests.scenes.terrain.grounds import HILLS, cut_and_mesh, view_of

RIDGES = Terrain(9, 190.0, 4096.0, 0.95, reach=6000.0, ridged=True)


def unit(v):
    return np.asarray(v) / np.linalg.norm(v, axis=-1, keepdims=True)


def facing_on_seen_ground(mesh, view):
    """Cosines of blended normals to the way to the eye, at places on faces that the eye sees."""
    corners = mesh.vertices[mesh.faces]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    seen = (across * (view.camera.eye - corners[:, 0])).sum(axis=1) > 0
    share = np.random.default_rng(1).dirichlet((1, 1, 1), seen.sum())[..., None]
    normals = unit((mesh.normals[mesh.faces[seen]] * share).sum(axis=1))
    places = (corners[seen] * share).sum(axis=1)
    return (normals * unit(view.camera.eye - places)).sum(axis=1)


@pytest.mark.parametrize("above", [2.0, 400.0])
@pytest.mark.parametrize("detail", [2.0, 12.0])
def test_no_seen_ground_is_shaded_by_a_side_that_turns_away(above, detail):
    """Whatever the sun, and where something covers the ground, too."""
    view = view_of(RIDGES, above=above, detail=detail, size=(160, 90), look_around=True)
    for sun, cover in ((None, None), ((0.0, 0.94, 0.34), None), ((0.57, 0.0, 0.82), Cloth(0.7))):
        terrain = replace(RIDGES, to_sun=sun, aggregate_cover=cover)
        facing = facing_on_seen_ground(cut_and_mesh(terrain, view)[1], view)
        assert (facing < 0).mean() < 1e-3, (sun, cover)


def shaded(terrain, **settings):
    """Shading of ground about 400 m from an eye 300 m up, its mesh and what it depends on."""
    view = view_of(terrain, above=300.0, size=(320, 180), look_around=True, **settings)
    cut, mesh = cut_and_mesh(terrain, view)
    d = np.linalg.norm(mesh.vertices - view.camera.eye, axis=1)
    near = (d > 320) & (d < 450)
    limits = cut.parts.state.limits[0]
    materials = GROUND_MATERIALS[terrain.cover]
    ground = GroundInView(view, terrain.relief, terrain.spacings, limits, materials, None, None)
    return ground, mesh.vertices[near], bare_shading(ground, mesh.vertices[near]), near, mesh


@pytest.mark.parametrize("terrain", [HILLS, RIDGES])
def test_slopes_that_a_coarse_mesh_leaves_out_stay_as_variance(terrain):
    """Analytic variance of octaves: what is drawn and what is hidden add up to the relief's."""
    for detail in (0.5, 12.0):
        _, _, shading, _, _ = shaded(terrain, detail=detail)
        drawn, hidden = shading[:, 2:4].var(axis=0).mean(), shading[:, 4].mean()
        assert hidden > 0.02 * drawn
        assert drawn + hidden == pytest.approx(terrain.relief.slope_variances.sum(), rel=0.25)


def test_slopes_are_the_reliefs_down_to_what_the_mesh_shows():
    ground, points, shading, _, _ = shaded(HILLS, detail=1.0)
    xy, corner = points[:, :2], ground.view.camera.corner
    spacing = spacing_at(ground, np.linalg.norm(points - ground.view.camera.eye, axis=1))
    assert np.allclose(shading[:, 2:4], HILLS.relief.slopes(corner, xy, 2 * spacing), atol=1e-12)
    assert np.abs(shading[:, 2:4] - HILLS.relief.slopes(corner, xy, 0 * spacing)).max() > 0.1


def test_the_same_place_at_the_same_distance_has_the_same_shading():
    """No seam: shading depends on place and distance alone, not on the tile that asks for it."""
    ground, points, shading, _, _ = shaded(HILLS, detail=1.0)
    some = np.random.default_rng(3).choice(len(points), 50, replace=False)
    assert np.array_equal(bare_shading(ground, points[some]), shading[some])


@dataclass(frozen=True, eq=False)
class ResidualCover:
    lift: Reals
    covered: Reals

    def colours(self, normals: Points, bare: Points) -> Points:
        return np.broadcast_to(0.5 + 0.5 * normals[:, 2:], bare.shape) * 0.5


@dataclass(frozen=True)
class Cloth:
    """Covers all of the ground, or none of it."""

    share: float
    highest: float = 2.0

    def residual(self, view, points) -> ResidualCover:
        return ResidualCover(
            np.full(len(points), 2.0 * self.share), np.full(len(points), self.share)
        )


def test_what_covers_the_ground_hides_its_bumps_and_lifts_it():
    bare, none, cloth = (
        replace(HILLS, aggregate_cover=far) for far in (None, Cloth(0.0), Cloth(1.0))
    )
    bumps = {}
    for name, terrain in (("bare", bare), ("none", none), ("cloth", cloth)):
        _, _, shading, near, mesh = shaded(terrain, detail=0.5)
        bumps[name] = (mesh.normals[near] - unit_normals(shading[:, :2])).std()
    assert bumps["none"] == bumps["bare"]
    assert bumps["cloth"] < 0.1 * bumps["bare"]
    view = view_of(HILLS, above=300.0)
    under, over = (cut_and_mesh(each, view)[1] for each in (bare, cloth))
    assert np.allclose(over.vertices - under.vertices, (0, 0, 2.0))
