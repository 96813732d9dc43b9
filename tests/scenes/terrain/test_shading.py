"""How the ground is shaded: as rough as its relief however coarse its mesh, and never by a side
that the eye does not see."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.arrays import Points, Reals
from scenes.terrain import ground_mesh
from scenes.terrain.relief import unit_normals
from scenes.terrain.shading import LEAST_FACING, LEVEL_FACING, SHOWN_PX, bend_toward_eye
from scenes.terrain.terrain import Terrain
from tests.scenes.terrain.grounds import HILLS, cut_and_mesh, view_of

RIDGES = Terrain(9, 190.0, 4096.0, 0.95, reach=6000.0, ridged=True)
ways = st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: np.linalg.norm(v) > 1e-3)


def unit(v):
    return np.asarray(v) / np.linalg.norm(v, axis=-1, keepdims=True)


@given(n=ways, smooth=ways, way=ways, far=st.floats(0.1, 1e5))
def test_a_normal_is_bent_no_more_than_it_must(n, smooth, way, far):
    n, smooth, way = (unit(v)[None] for v in (n, smooth, way))
    bent = bend_toward_eye(n, smooth, far * way)
    facing, level = (n * way).sum(), abs((smooth * way).sum())
    least = np.clip(level, LEVEL_FACING, LEAST_FACING)
    assert np.isfinite(bent).all()
    if facing >= least + 1e-12:
        assert np.array_equal(bent, n)
    elif abs(facing) < 0.999999:
        assert (bent * way).sum() == pytest.approx(least, abs=1e-9)
        assert np.linalg.norm(bent) == pytest.approx(1.0, abs=1e-9)
        # in the plane of both: nothing that bends it less faces the eye as much
        turned = np.arccos(np.clip(facing, -1, 1)) - np.arccos(least)
        assert np.arccos(np.clip((n * bent).sum(), -1, 1)) == pytest.approx(turned, abs=1e-5)


def test_plains_are_not_tilted():
    n, way = np.array([[0.0, 0.0, 1.0]]), np.array([[3000.0, 0.0, 1.7]])
    assert np.array_equal(bend_toward_eye(n, n, way), n)


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
def test_no_seen_ground_is_shaded_by_a_side_that_turns_away(above, detail, monkeypatch):
    view = view_of(RIDGES, above=above, detail=detail, size=(160, 90), look_around=True)
    bent = facing_on_seen_ground(cut_and_mesh(RIDGES, view)[1], view)
    monkeypatch.setattr(ground_mesh, "bend_toward_eye", lambda normals, *_: normals)
    plain = facing_on_seen_ground(cut_and_mesh(RIDGES, view)[1], view)
    assert (plain < 0).mean() > 0.01
    assert (bent < 0).mean() < 1e-4  # underfoot, where one face spans many directions


def steepness(terrain, **settings):
    """RMS slope of the normals of ground 200 to 400 m from an eye 300 m up."""
    view = view_of(terrain, above=300.0, size=(320, 180), look_around=True, **settings)
    mesh = cut_and_mesh(terrain, view)[1]
    d = np.hypot(*(mesh.vertices - view.camera.eye)[:, :2].T)
    near = (d > 200) & (d < 400)
    return np.sqrt(np.mean(np.sum((mesh.normals[near, :2] / mesh.normals[near, 2:]) ** 2, axis=1)))


def test_a_coarse_mesh_is_as_rough_as_a_fine_one():
    fine, coarse = (steepness(HILLS, detail=detail) for detail in (0.5, 12.0))
    assert coarse == pytest.approx(fine, rel=0.05)


def test_normals_are_the_reliefs_down_to_what_the_picture_shows():
    view = view_of(HILLS, above=300.0, size=(320, 180), look_around=True)
    mesh = cut_and_mesh(HILLS, view)[1]
    way, xy = view.camera.eye - mesh.vertices, mesh.vertices[:, :2]
    shortest = SHOWN_PX * view.camera.pixel_angle * np.linalg.norm(way, axis=1)
    told, whole = (
        unit_normals(HILLS.relief.slopes(view.camera.corner, xy, waves))
        for waves in (shortest, np.zeros(len(xy)))
    )
    faced = (told * unit(way)).sum(axis=1) > LEAST_FACING
    assert faced.mean() > 0.5
    assert np.allclose(mesh.normals[faced], told[faced], rtol=0, atol=1e-12)
    assert np.abs(mesh.normals - whole)[faced].max() > 0.1


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
    assert steepness(none, detail=12.0) == steepness(bare, detail=12.0)
    assert steepness(cloth, detail=12.0) < 0.9 * steepness(bare, detail=12.0)
    view = view_of(HILLS, above=300.0)
    under, over = (cut_and_mesh(each, view)[1] for each in (bare, cloth))
    assert np.allclose(over.vertices - under.vertices, (0, 0, 2.0))
