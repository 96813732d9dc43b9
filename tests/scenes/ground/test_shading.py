"""What lies on the ground: where, and how bright.

How the ground is shaded: as rough as its relief, by waves that its mesh can show, and never by a
side that the eye does not see.

The light of relief too small to be drawn, against sampled facets and against rendered ones.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from lod.arrays import Points, Reals
from lod.camera import Corner
from scenes.ground.mesh import Terrain
from scenes.ground.relief import Relief, unit_normals
from scenes.ground.shading import (
    GROUND_MATERIALS,
    SNOW,
    GroundInView,
    bare_shading,
    cavity_albedo,
    ground_colours,
    seen_facets,
    seen_slopes,
    spacing_at,
)
from scenes.noise import unit_rms, unit_slope_variance
from scenes.presets.load import load_preset
from scenes.render import variants
from scenes.render.render import render_frame
from scenes.scene import Scene
from scenes.sticks.prototype import LUMINANCE
from tests.scenes.ground.grounds import HILLS, cut_and_mesh, view_of


def albedo(cover, rise, slope, n=4000):
    """Mean albedo of much ground of that height and slope, (3,)."""
    xy = np.random.default_rng(1).uniform(0, 5000, (n, 2))
    flat = np.full(n, rise), np.full(n, slope), np.zeros(n), np.full(n, 1.0)
    colours = ground_colours(4, Corner(0, 0), xy, *flat, GROUND_MATERIALS[cover])
    assert colours.min() >= 0 and colours.max() <= 1
    return colours.mean(axis=0)


def test_snow_lies_high_and_not_on_cliffs():
    below, above = albedo("snowy", -1.5, 0.1), albedo("snowy", 1.5, 0.1)
    cliff = albedo("snowy", 1.5, 2.0)
    assert above == pytest.approx(SNOW, abs=0.02)
    assert below.max() < 0.2 and cliff.max() < 0.25
    middle = albedo("snowy", GROUND_MATERIALS["snowy"].snow_line, 0.1)
    assert below[1] + 0.1 < middle[1] < above[1] - 0.1


@pytest.mark.parametrize("cover", list(GROUND_MATERIALS))
@pytest.mark.parametrize("spread", [0.1, 0.5])
@pytest.mark.parametrize("slope", [0.0, 1.0])
def test_hidden_slopes_leave_the_mean_of_their_albedo(cover, spread, slope):
    """Against 4000 sampled facets, on high ground, where snow slides off the steep ones."""
    random = np.random.default_rng(5)
    n, rise = 4000, 1.5
    xy = random.uniform(0, 5000, (n, 2))
    steep = np.hypot(*(random.normal(0, spread, (2, n)) + np.array([[slope], [0.0]])))
    same = 4, Corner(0, 0), xy, np.full(n, rise)
    coarse, materials = np.full(n, 4096.0), GROUND_MATERIALS[cover]
    facets = ground_colours(*same, steep, np.zeros(n), coarse, materials).mean(axis=0)
    found = ground_colours(*same, np.full(n, slope), np.full(n, spread**2), coarse, materials).mean(
        axis=0
    )
    assert found == pytest.approx(facets, abs=0.025)


def test_small_patches_leave_the_mean_of_their_albedo():
    xy = np.random.default_rng(1).uniform(0, 40_000, (40_000, 2))
    one = np.ones(len(xy))
    same = 4, Corner(0, 0), xy, -0.2 * one, 0.4 * one, 0 * one
    for cover, materials in GROUND_MATERIALS.items():
        fine = ground_colours(*same, 0.125 * one, materials)
        coarse = ground_colours(*same, 4096.0 * one, materials)
        assert coarse.mean(axis=0) == pytest.approx(fine.mean(axis=0), abs=0.03), cover


def test_trodden_turf_is_worn_to_earth_in_patches_and_about_as_light_as_grass():
    xy = np.random.default_rng(2).uniform(0, 40_000, (40_000, 2))
    one = np.ones(len(xy))
    same = 4, Corner(0, 0), xy, 0 * one, 0.02 * one, 0 * one
    turf, grass = GROUND_MATERIALS["trodden"], GROUND_MATERIALS["grassy"]
    fine, coarse = (ground_colours(*same, s * one, turf) for s in (0.0625, 4096.0))
    assert coarse.mean(axis=0) == pytest.approx(fine.mean(axis=0), rel=0.05)
    earthy = (fine[:, 0] > 1.15 * fine[:, 1]).mean()
    green = (fine[:, 0] < fine[:, 1]).mean()
    assert 0.1 < earthy < 0.5 < green + earthy and green > 0.2
    light = (ground_colours(*same, one, each).mean(axis=0) @ LUMINANCE for each in (turf, grass))
    assert next(light) == pytest.approx(next(light), rel=0.1)


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
    ground = GroundInView(
        view, terrain.relief, terrain.spacings, limits, materials, None, np.zeros(3)
    )
    return ground, mesh.vertices[near], bare_shading(ground, mesh.vertices[near]), near, mesh


@pytest.mark.parametrize("terrain", [HILLS, RIDGES])
def test_slopes_that_a_coarse_mesh_leaves_out_stay_as_variance(terrain):
    """Analytic variance of octaves: what is drawn and what is hidden add up to the relief's."""
    for detail in (1.0, 12.0):
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

    def residual(self, view, points, slopes=None) -> ResidualCover:
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


SLOPES = np.array([[0.0, 0.0], [0.3, -0.2], [-0.6, 0.1], [0.1, 0.9]])
WAYS = [(0.0, 0.0, 1.0), (1.0, 0.3, 1.0), (-1.0, 2.0, 0.4), (1.0, 0.0, 0.02)]


def sampled_facets(slope, sigma, way, count=100_000):
    """Slopes about one, and how much of each the eye sees."""
    slopes = slope + sigma * np.random.default_rng(2).standard_normal((count, 2))
    facets = np.column_stack((-slopes, np.ones(count)))
    return slopes, facets, np.maximum(facets @ np.array(way), 0.0)


@pytest.mark.parametrize("ridged", [False, True])
def test_octaves_have_the_slope_variance_that_is_worked_out(ridged):
    relief = Relief(3, 20.0, 1024.0, 0.9, ridged)
    xy = np.random.default_rng(0).uniform(-2e5, 2e5, (100_000, 2))
    for shortest in (0.0, 6.0, 64.0):
        waves = np.full(len(xy), shortest)
        drawn = relief.slopes(Corner(0, 0), xy, waves).var(axis=0).mean()
        left_out = relief.left_out_slope_variance(waves)[0]
        assert drawn + left_out == pytest.approx(relief.slope_variances.sum(), rel=0.02)
        assert (left_out > 0) == (shortest > 0)
    assert unit_slope_variance() > unit_rms() ** 2


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("sigma", [0.05, 0.6])
def test_seen_slopes_are_those_of_sampled_facets(way, sigma):
    for slope in SLOPES:
        slopes, _, seen = sampled_facets(slope, sigma, way)
        if seen.mean() < 1e-3:
            continue
        mean, spread = seen_slopes(
            slope[None], np.array([sigma**2]), np.ones(1), np.array([way], np.float64)
        )
        expected = np.average(slopes, axis=0, weights=seen)
        assert mean[0] == pytest.approx(expected, abs=0.03 * sigma)
        square = np.average((slopes - expected) ** 2, axis=0, weights=seen).mean()
        assert spread[0] == pytest.approx(square, rel=0.05)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("sigma", [0.05, 0.6])
def test_the_mean_normal_is_that_of_sampled_facets(way, sigma):
    for slope in SLOPES:
        _, facets, seen = sampled_facets(slope, sigma, way)
        if seen.mean() < 1e-3:
            continue
        units = facets / np.linalg.norm(facets, axis=1, keepdims=True)
        normal, share = seen_facets(
            slope[None], np.array([sigma**2]), np.array([way], np.float64), np.zeros(3)
        )
        expected = np.average(units, axis=0, weights=seen)
        assert share[0] * normal[0] == pytest.approx(expected, abs=0.04)
        assert normal[0] @ np.array(way) > 0


def test_a_cavity_returns_what_escapes_at_every_bounce():
    albedo = np.linspace(0, 1, 11)[:, None] * np.ones(3)
    for share in (0.3, 0.8, 1.0):
        bounces = [share * albedo * (albedo * (1 - share)) ** n for n in range(200)]
        found = cavity_albedo(albedo, np.full(len(albedo), share))
        assert found == pytest.approx(np.sum(bounces, axis=0), abs=1e-12)


def patch_light(ridged, amplitude, depression, sun, azimuth, detail):
    """Mean light of 150 m of rough ground, seen from 1500 m."""
    height = 1500 * math.sin(math.radians(depression))
    shape = "wavelength=16", f"amplitude={amplitude}", f"ridged={str(ridged).lower()}"
    preset = load_preset(
        "mountain",
        [
            "species.conifer.density=0",
            "species.boulder.density=0",
            *(f"terrain.{each}" for each in (*shape, 'cover="bare"', "reach=4000", "finest=0.25")),
            f"camera.height={height}",
            f"camera.pitch={-depression}",
            "camera.heading=0",
            "camera.fov=6",
            f"light.sun_elevation={sun}",
            f"light.sun_azimuth={azimuth}",
            'air.visibility="clear"',
            f"view.detail={detail}",
            "render.size=48x48",
            "render.spp=16",
        ],
    )
    frame = Scene(preset).input(1, variants.JIT_VARIANT)
    return float(render_frame(frame).rgb.mean())


@pytest.mark.parametrize(("sun", "azimuth"), [(20, 180), (35, 0)])
@pytest.mark.parametrize(("ridged", "amplitude", "most"), [(False, 1.0, 0.06), (True, 0.5, 0.1)])
def test_hidden_relief_leaves_its_light(ridged, amplitude, most, sun, azimuth):
    """Relief all drawn, with its shadows, against the same all hidden, in one law of light.

    Slopes of crests are not normally distributed, so that less is sure of them.
    """
    case = ridged, amplitude, 20.0, sun, azimuth
    drawn, hidden = (patch_light(*case, detail) for detail in (0.4, 400.0))
    assert hidden == pytest.approx(drawn, rel=most)
