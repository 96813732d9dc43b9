"""The light of relief too small to be drawn, against sampled facets and against rendered ones."""

import math

import numpy as np
import pytest

from lod.camera import Corner
from scenes.frame.assemble import assemble_frame
from scenes.noise import unit_rms, unit_slope_variance
from scenes.preset.load import load_preset
from scenes.render import variants
from scenes.render.pipeline.render import render_frame
from scenes.terrain.hidden_relief import cavity_albedo, seen_facets, seen_slopes
from scenes.terrain.relief import Relief, unit_normals
from scenes.world.world import build_world

SLOPES = np.array([[0.0, 0.0], [0.3, -0.2], [-0.6, 0.1], [0.1, 0.9]])
WAYS = [(0.0, 0.0, 1.0), (1.0, 0.3, 1.0), (-1.0, 2.0, 0.4), (1.0, 0.0, 0.02)]


def sampled_facets(slope, sigma, way, count=400_000):
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
@pytest.mark.parametrize("sigma", [0.05, 0.3, 0.6])
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
@pytest.mark.parametrize("sigma", [0.05, 0.3, 0.6])
def test_the_mean_normal_is_that_of_sampled_facets(way, sigma):
    for slope in SLOPES:
        _, facets, seen = sampled_facets(slope, sigma, way)
        if seen.mean() < 1e-3:
            continue
        units = facets / np.linalg.norm(facets, axis=1, keepdims=True)
        normal, share = seen_facets(
            slope[None], np.array([sigma**2]), np.array([way], np.float64), None
        )
        expected = np.average(units, axis=0, weights=seen)
        assert share[0] * normal[0] == pytest.approx(expected, abs=0.04)
        assert normal[0] @ np.array(way) > 0


def test_smooth_ground_keeps_its_normal_and_its_light():
    eye, sun = np.tile((0.2, 0.1, 1.0), (len(SLOPES), 1)), np.array((0.6, 0.0, 0.8))
    normals, share = seen_facets(SLOPES, np.zeros(len(SLOPES)), eye, sun)
    assert normals == pytest.approx(unit_normals(SLOPES), abs=0.01)
    assert share == pytest.approx(1.0, abs=1e-4)


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
    frame = assemble_frame(build_world(preset), preset, 1, variants.JIT_VARIANT)
    return float(render_frame(frame).rgb.mean())


@pytest.mark.parametrize("sun", [20, 35, 55])
@pytest.mark.parametrize("azimuth", [180, 90, 0])
@pytest.mark.parametrize(("ridged", "amplitude", "most"), [(False, 1.0, 0.06), (True, 0.5, 0.1)])
def test_hidden_relief_leaves_its_light(ridged, amplitude, most, sun, azimuth):
    """Relief all drawn, with its shadows, against the same all hidden, in one law of light.

    Slopes of crests are not normally distributed, so that less is sure of them.
    """
    case = ridged, amplitude, 20.0, sun, azimuth
    drawn, hidden = (patch_light(*case, detail) for detail in (0.4, 400.0))
    assert hidden == pytest.approx(drawn, rel=most)
