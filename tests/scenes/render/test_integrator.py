"""Paths of light: analytic values, Mitsuba's own integrators as the reference, and pictures.

Means are held against Mitsuba's ``path`` on the same camera rays, by differences of whole seeds:
their standard error over SEEDS seeds says how much noise a mean has.
"""

import math
from dataclasses import replace

import numpy as np
import pytest

from lod.shapes import Triangles
from scenes.frame.frame_input import DisplayedRepresentation, FrameInput
from scenes.render import variants
from scenes.render.description import describe_frame

JIT = [variants.JIT_VARIANT, *(("cuda_ad_rgb",) if variants.works("cuda_ad_rgb") is True else ())]
ALBEDO, IRRADIANCE, ELEVATION = np.array([0.5, 0.2, 0.8]), np.array([3.0, 2.0, 1.0]), 35.0
SEEDS, SPP = 8, 16


@pytest.fixture(params=JIT)
def jit(request):
    if (answer := variants.works(request.param)) is not True:
        pytest.skip(f"{request.param} does not work here: {answer}")
    variants.use(request.param)
    return request.param


def looking_down(shapes, sky, sun, max_depth, count=20_000, spread=0.0):
    """Radiance (count, 3) along rays straight down onto shapes, from 1 m above the origin."""
    import drjit as dr
    import mitsuba as mi

    from scenes.render.build import BuiltScene, Surfaces, load_plugin
    from scenes.render.jit import trace_paths

    up = math.radians(ELEVATION)
    lights = {
        "sky": {"type": "constant", "radiance": {"type": "rgb", "value": [sky] * 3}},
        "sun": {
            "type": "directional",
            "direction": [0, -math.cos(up), -math.sin(up)],
            "irradiance": {"type": "rgb", "value": list(map(float, sun))},
        },
    }
    scene = load_plugin({"type": "scene", **lights, **shapes})
    description = {"integrator": {"max_depth": max_depth}, "after": None}
    known = scene, description, {}, (), np.zeros((1, 3)), (), None
    built = BuiltScene(*known, Surfaces(scene))
    sampler = load_plugin({"type": "independent"})
    sampler.seed(3, count)
    start = mi.Point3f(dr.zeros(mi.Float, count), 0.0, 1.0)
    colour, guides = trace_paths(built, sampler, mi.Ray3f(start, mi.Vector3f(0, 0, -1)), True)
    dr.eval(colour, guides)
    return np.array(colour).T


def plane(albedo):
    colour = {"type": "rgb", "value": list(map(float, np.broadcast_to(albedo, 3)))}
    return {"type": "rectangle", "bsdf": {"type": "diffuse", "reflectance": colour}}


@pytest.mark.parametrize("max_depth", [2, 4, 9])
def test_a_plane_under_the_sun_alone_reflects_albedo_by_pi_of_its_irradiance(jit, max_depth):
    """Every sample has the very value: nothing about it is random."""
    seen = looking_down({"plane": plane(ALBEDO)}, 0.0, IRRADIANCE, max_depth)
    expected = ALBEDO / math.pi * IRRADIANCE * math.sin(math.radians(ELEVATION))
    np.testing.assert_allclose(seen, np.broadcast_to(expected, seen.shape), rtol=1e-5)


def test_a_plane_under_an_even_sky_reflects_its_albedo_of_it(jit):
    """Every ray that the plane sends meets the same sky."""
    seen = looking_down({"plane": plane(ALBEDO)}, 2.0, np.zeros(3), 3)
    np.testing.assert_allclose(seen, np.broadcast_to(2 * ALBEDO, seen.shape), rtol=1e-5)


@pytest.mark.parametrize("max_depth", [1, 2, 3, 6, 12, 40])
def test_a_closed_room_that_glows_evenly_is_a_geometric_series(jit, max_depth):
    """L = Le·(1 + a + a² + …), a term for each edge, of walls that both give and reflect light.

    Under roulette the mean of 20 000 samples has a standard error of at most 0.3 %.
    """
    glow = {"type": "area", "radiance": {"type": "rgb", "value": [1.0, 1.0, 1.0]}}
    room = {**plane(0.8), "type": "sphere", "radius": 2.0, "flip_normals": True, "emitter": glow}
    seen = looking_down({"room": room}, 0.0, np.zeros(3), max_depth)
    expected = (1 - 0.8**max_depth) / (1 - 0.8)
    assert seen.mean(axis=0) == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("height", [0.05, 0.3, 2.0])
def test_a_lamp_above_a_plane_gives_what_its_form_factor_says(jit, height):
    """Of a square parallel to the plane, seen from a point below one of its corners (Howell, B-3).

    F = (x/√(1+x²)·atan(x/√(1+x²)))/π for a side of x heights; both ways of sampling it are used:
    the nearer it is, the more of its light comes by rays that the plane sends.
    """
    import mitsuba as mi

    side = 0.5
    place = mi.ScalarTransform4f().translate([side / 2, side / 2, height])
    shape = place.rotate([1, 0, 0], 180).scale([side / 2, side / 2, 1])
    glow = {"type": "area", "radiance": {"type": "rgb", "value": [4.0, 4.0, 4.0]}}
    lamp = {"type": "rectangle", "to_world": shape, "emitter": glow, "bsdf": plane(0)["bsdf"]}
    # Just outside the corner, so that the ray down passes the lamp by.
    ground = {**plane(0.5), "to_world": mi.ScalarTransform4f().translate([-1e-4, -1e-4, 0])}
    lamp["to_world"] = mi.ScalarTransform4f().translate([1e-4, 1e-4, 0]) @ shape
    seen = looking_down({"plane": ground, "lamp": lamp}, 0.0, np.zeros(3), 2, 200_000)
    ratio = side / height / math.sqrt(1 + (side / height) ** 2)
    form_factor = ratio * math.atan(ratio) / math.pi
    assert seen.mean(axis=0) == pytest.approx(0.5 * 4.0 * form_factor, rel=0.01)


def flame(make, at, glows=((3.0, 1.0, 0.2), (0.5, 0.2, 0.1))):
    """Two glowing walls, one behind the other, that face the camera."""
    corners = np.array([(-0.3, 0, 0), (0.3, 0, 0), (0.3, 0, 0.8), (-0.3, 0, 0.8)]) + np.array(at)
    wall = make.quad(corners, 0.6, "flame")
    shape = Triangles(
        vertices=np.concatenate((corners, corners + np.array([0.2, 0.5, 0.3]))),
        normals=np.tile(wall.shape.normals, (2, 1)),
        colours=np.tile(wall.shape.colours, (2, 1)),
        faces=np.concatenate((wall.shape.faces, wall.shape.faces + 4)),
        owner=np.zeros(4),
        glow=np.array([0, 0, 1, 1]),
        glows=np.array(glows),
    )
    return DisplayedRepresentation("flame", wall.cut, shape)


def crowded(make):
    spots = [(x, y, z) for x in np.arange(-4, 4.1, 1.0) for y in (8, 11) for z in (0.4, 1.6)]
    black = make.balls([(0.5, 9.5, 1.0), (-2.5, 9.5, 1.0)], 0.6, 0.0, "black")
    return [make.balls(spots, radius=0.45, albedo=0.8), black, make.ground(), make.wall(30, 0.7)]


def both_ways(make, jit, displayed, max_depth, moving=False):
    """A small scene, Mitsuba's integrator of image and guides, and its rays by seed."""
    from scenes.render.build import build_scene, load_plugin
    from scenes.render.jit import trace_paths
    from scenes.render.light import emitters
    from scenes.render.samples import sample_rays, sensor

    camera = make.camera((48, 24))
    quality = make.quality(jit, SPP, max_depth=max_depth)
    after = make.camera((48, 24), heading=1.0) if moving else None
    made = FrameInput(camera, tuple(displayed), make.clear, make.light, quality, after)
    described = describe_frame(made)
    built = build_scene(described, emitters(described["light"]))
    aovs = "depth:depth,normal:sh_normal,albedo:albedo,shape:shape_index,prim:prim_index"
    aovs += ",position:position" * moving
    path = {"type": "path", "max_depth": max_depth}
    mitsuba = load_plugin({"type": "aov", "aovs": aovs, "image": path})
    view = sensor(built.description["camera"])

    def sampled(seed):
        import drjit as dr

        found = []
        for ours in (True, False):
            pixels, group = slice(0, 48 * 24), replace(quality, seed=seed)
            sampler, ray = sample_rays(view, (48, 24), pixels, group)
            if ours:
                colour, guides = trace_paths(built, sampler, ray, True)
            else:
                colour, _, guides = mitsuba.sample(built.scene, sampler, ray, None, True)
                guides = guides[4:]
            dr.eval(colour, guides)
            found.append(
                (np.array(colour).T.astype(float), np.stack([np.array(g) for g in guides]))
            )
        return found

    return sampled


CASES = {
    "by day": ([], 4),
    "direct light only": ([], 2),
    "with roulette": ([], 12),
    "by a flame": ([(0.0, 6.5, 0.2)], 4),
    "what shines alone": ([(0.0, 6.5, 0.2)], 1),
}


@pytest.mark.parametrize("case", CASES)
def test_guides_are_those_of_mitsuba_to_the_bit_and_means_within_noise(make, jit, case):
    """Means of land and sky, and of blocks of 4 × 4 pixels together by their squared t.

    Seeds of our own way and of Mitsuba's are paired, and the differences give the means' variance:
    a standard error of at most 0.2 % of the land's mean.
    """
    flames, max_depth = CASES[case]
    shown = [*crowded(make), *(flame(make, at) for at in flames)]
    sampled = both_ways(make, jit, shown, max_depth, moving=True)
    land, blocks, mean = [], [], []
    for seed in range(SEEDS):
        (colour, guides), (expected, known) = sampled(seed)
        np.testing.assert_array_equal(guides, known)
        met = guides[0] > 0
        assert met.any() and not met.all()
        np.testing.assert_allclose(colour[~met], expected[~met], rtol=1e-5)
        land.append((colour - expected)[met].mean(axis=0))
        blocks.append((colour - expected).reshape(6, 4, 12, 4, SPP, 3).mean(axis=(1, 3, 4)))
        mean.append(expected[met].mean(axis=0))
    if max_depth == 1:  # nothing is random
        assert not np.any(land) and np.mean(mean) > 0
        return
    error = np.std(land, axis=0, ddof=1) / math.sqrt(SEEDS)
    assert (error < 2e-3 * np.mean(mean, axis=0)).all()
    assert (np.abs(np.mean(land, axis=0)) < 5 * error).all()
    spread = np.var(blocks, axis=0, ddof=1) / SEEDS
    noisy = spread > 0
    t_squared = np.mean(blocks, axis=0)[noisy] ** 2 / spread[noisy]
    # A squared t of 7 degrees of freedom has mean 7/5 and standard deviation 2.8; colours go along.
    assert t_squared.mean() == pytest.approx(1.4, abs=5 * 2.8 / math.sqrt(t_squared.size / 3))


def test_other_light_compiles_nothing_anew(make, jit):
    """Of the sun, its hour and place; of flames, how bright they are."""
    import drjit as dr

    misses = []
    lights = [make.light, replace(make.light, sun_azimuth_deg=20, sun_elevation_deg=12)]
    glows = [((3.0, 1.0, 0.2), (0.5, 0.2, 0.1)), ((2.0, 1.0, 0.3), (0.7, 0.2, 0.1))]
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
        for light, glow in zip((*lights, *lights), (*glows, *glows[::-1]), strict=True):
            scene = (make.ground(), flame(make, (0, 8, 1), glow))
            dr.kernel_history_clear()
            make.rendered(jit, *scene, light=light)
            misses.append([not k["cache_hit"] for k in dr.kernel_history() if "cache_hit" in k])
    assert all(misses) and not any(any(each) for each in misses[1:])


def test_a_triangle_far_longer_than_wide_has_an_albedo_and_light(make, jit):
    """Mitsuba's own interpolation of colours has no digit left there, and is NaN in places."""
    width = 1e-3
    long = np.array([(-width, 1, 0), (width, 1, 0), (width, 2e4, 0), (-width, 2e4, 0)])
    ends = np.array([[0.2] * 3, [0.2] * 3, [0.6] * 3, [0.6] * 3])
    camera = make.camera((4, 64), heading=0.0, pitch=-25.0, fov=100 * width)
    seen = make.rendered(jit, make.quad(long, ends), camera=camera, spp=64)
    assert (seen.Z < 1e9).any()
    assert np.isfinite(seen.albedo).all() and 0 <= seen.albedo.min() <= seen.albedo.max() <= 0.6
    assert seen.statistics["replaced"] == 0
