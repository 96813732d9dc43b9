"""The relief has the size, roughness and exactness that it says; first its laws.

Endless: at 10¹² m from the origin every object is where exact arithmetic puts it.
"""

import math
from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import GRID_M, Corner
from lod.pruner import prune
from scenes.ground import relief as relief_file
from scenes.ground.relief import Relief, unit_normals
from scenes.noise import (
    GRADIENT_LENGTH,
    NOISE_BOUND,
    NOISE_MAX_SLOPE,
    RIDGED_MEAN,
    RIDGED_RMS,
    cell_slopes,
    cell_value,
    fill_corners,
    octave_values,
    octaves_at,
    twin_values,
    unit_rms,
)
from scenes.presets.load import load_preset
from scenes.scene import Scene

HOME = Corner(0, 0)
FAR = Corner(62_500_000_123, -62_499_999_877)  # 10^12 m from home
MASK = 2**64 - 1


def spread(rng: np.random.Generator, count: int, side: float) -> np.ndarray:
    return rng.uniform(-side, side, (count, 2))


@pytest.mark.parametrize("hurst", [0.3, 0.95])
def test_amplitude_is_the_rms_of_the_relief(hurst):
    rng = np.random.default_rng(1)
    ground = Relief(seed=5, amplitude=30.0, wavelength=64.0, hurst=hurst)
    height = ground.height(HOME, spread(rng, 200_000, 60_000.0))
    assert np.sqrt(np.mean(height**2)) == pytest.approx(30.0, rel=0.01)
    assert abs(np.mean(height)) < 0.3


@pytest.mark.parametrize("hurst", [0.2, 0.8])
def test_heights_apart_differ_as_distance_to_the_power_hurst(hurst):
    rng = np.random.default_rng(2)
    ground = Relief(6, 50.0, 2.0**14, hurst)
    xy = spread(rng, 100_000, 4e6)
    turn = rng.uniform(0, 2 * np.pi, len(xy))
    way = np.stack((np.cos(turn), np.sin(turn)), axis=1)
    distances = 2.0 ** np.arange(2, 10)  # well inside the octaves, 2^-2 m to 2^14 m
    here = ground.height(HOME, xy)
    rms = [np.sqrt(np.mean((ground.height(HOME, xy + r * way) - here) ** 2)) for r in distances]
    slope = np.polyfit(np.log(distances), np.log(rms), 1)[0]
    assert slope == pytest.approx(hurst, abs=0.03)


@pytest.mark.parametrize("corner", [HOME, FAR])
@given(
    x=st.floats(-2e4, 2e4), y=st.floats(-2e4, 2e4), dx=st.integers(-999, 999), dy=st.integers(-9, 9)
)
def test_a_place_has_one_height_whatever_the_corner(corner, x, y, dx, dy):
    ground = Relief(seed=7, amplitude=30.0, wavelength=2048.0, hurst=0.9)
    other = Corner(corner.x + dx, corner.y + dy)
    here = ground.height(corner, np.array([[x, y]]))
    there = ground.height(other, np.array([[x - dx * GRID_M, y - dy * GRID_M]]))
    assert abs(here - there)[0] < 1e-9


def test_the_spectrum_falls_as_frequency_to_the_power_minus_2_hurst_plus_1():
    """Along lines, between the shortest wavelength and the longest, by octaves of frequency."""
    hurst, step, count = 0.6, 0.5, 2**14
    ground = Relief(6, 50.0, 2.0**11, hurst)
    along = np.stack((np.arange(count) * step, np.zeros(count)), axis=1)
    lines = [ground.height(Corner(1000 * k, 77 * k), along) for k in range(40)]
    power = np.mean([abs(np.fft.rfft(z * np.hanning(count))) ** 2 for z in lines], axis=0)
    edges = count * step / 2.0 ** np.arange(9, 2, -1)  # waves of 512 m to 8 m
    bands = [power[int(a) : int(b)].mean() for a, b in pairwise(edges)]
    slope = np.polyfit(np.arange(len(bands)), np.log2(bands), 1)[0]
    assert slope == pytest.approx(-(2 * hurst + 1), abs=0.15)


def split_mix(seed: int, index: int) -> int:
    """Output ``index``, from 1, of the SplitMix64 stream of ``seed``, in Python's integers."""
    z = (seed + index * 0x9E3779B97F4A7C15) & MASK
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return z ^ (z >> 31)


def exact_height(ground: Relief, corner: Corner, x: float, y: float) -> float:
    """The relief from its definition, in fractions and Python's integers."""
    where = (corner.x * 16 + Fraction(x), corner.y * 16 + Fraction(y))
    total = 0.0
    for exponent, rms in zip(range(12, -3, -1), ground.rms, strict=True):
        seed = (ground.seed ^ relief_file._STREAM) & MASK
        key = split_mix(split_mix(seed, exponent), 0)
        cells = [math.floor(w / Fraction(2) ** exponent) for w in where]
        parts = [float(w / Fraction(2) ** exponent - c) for w, c in zip(where, cells, strict=True)]
        for i, j in ((0, 0), (1, 0), (0, 1), (1, 1)):
            bits = split_mix(split_mix(key, cells[0] + i), cells[1] + j)
            turn = 2 * math.pi * (bits % 256) / 256
            du, dv = parts[0] - i, parts[1] - j
            value = (bits >> 11) / 2**52 - 1
            value += GRADIENT_LENGTH * (math.cos(turn) * du + math.sin(turn) * dv)
            weight = [6 * (1 - abs(t)) ** 5 - 15 * (1 - abs(t)) ** 4 for t in (du, dv)]
            weight = [w + 10 * (1 - abs(t)) ** 3 for w, t in zip(weight, (du, dv), strict=True)]
            total += rms / unit_rms() * weight[0] * weight[1] * value
    return total


@pytest.mark.parametrize("corner", [HOME, FAR, Corner(-(2**55), 2**55 + 1)])
def test_heights_agree_with_exact_integers(corner):
    ground = Relief(seed=2**63 - 1, amplitude=30.0, wavelength=4096.0, hurst=0.9)
    xy = spread(np.random.default_rng(3), 40, 4e4)
    exact = [exact_height(ground, corner, x, y) for x, y in xy]
    np.testing.assert_allclose(ground.height(corner, xy), exact, rtol=0, atol=1e-9)


@pytest.mark.parametrize("corner", [HOME, FAR])
def test_slopes_are_those_of_the_heights(corner):
    ground = Relief(seed=8, amplitude=30.0, wavelength=512.0, hurst=0.9)
    xy, step = spread(np.random.default_rng(4), 500, 1e3), 1e-4
    slopes = ground.slopes(corner, xy, np.zeros(len(xy)))
    for axis in (0, 1):
        move = step * np.eye(2)[axis]
        rise = ground.height(corner, xy + move) - ground.height(corner, xy - move)
        np.testing.assert_allclose(slopes[:, axis], rise / (2 * step), atol=2e-6)
    up = unit_normals(slopes)
    np.testing.assert_allclose(np.linalg.norm(up, axis=1), 1.0)
    np.testing.assert_allclose(-up[:, :2] / up[:, 2:], slopes, rtol=1e-12)
    np.testing.assert_array_equal(unit_normals(ground.slopes(corner, xy, np.zeros(len(xy)))), up)


def test_octaves_up_to_twice_too_short_fade():
    """Half an octave in, half of the octave's slope is there."""
    ground = Relief(seed=8, amplitude=30.0, wavelength=512.0, hurst=0.9)
    xy = spread(np.random.default_rng(5), 200, 1e3)
    none, half, whole = (
        ground.slopes(HOME, xy, np.full(len(xy), s)) for s in (64.0, 64.0 / 2**0.5, 32.0)
    )
    np.testing.assert_allclose(half, (none + whole) / 2, atol=1e-12)


def unit_noise(key, ix, iy, u, v):
    """Noise and its two slopes at (u, v) in [0, 1)² of a lattice cell."""
    cell = np.empty(12)
    fill_corners(key, ix, iy, cell)
    return cell_value(cell, u, v), *cell_slopes(cell, u, v)


def test_unit_noise_keeps_its_bounds_and_its_size():
    rng = np.random.default_rng(6)
    cells = rng.integers(-(2**60), 2**60, (200_000, 2))
    parts = rng.random((200_000, 2))
    key = np.uint64(1)
    noise = np.array(
        [unit_noise(key, *c, *p) for c, p in zip(cells[:50_000], parts[:50_000], strict=True)]
    )
    assert np.abs(noise[:, 0]).max() < NOISE_BOUND
    assert np.hypot(noise[:, 1], noise[:, 2]).max() < NOISE_MAX_SLOPE
    assert np.sqrt(np.mean(noise[:, 0] ** 2)) == pytest.approx(unit_rms(), rel=0.01)


def test_twins_are_two_noises_like_any_other():
    """As large, as smooth, and with nothing to do with one another."""
    rng = np.random.default_rng(7)
    octave = octaves_at(FAR, 99, np.ones(1), np.ones(1))
    xy, none = rng.uniform(0, 3e3, (300_000, 2)), np.zeros(300_000)
    twins = twin_values(octave, xy, none)
    assert np.sqrt(np.mean(twins**2, axis=0)) == pytest.approx(unit_rms(), rel=0.01)
    assert np.abs(twins).max() < NOISE_BOUND
    assert abs(np.corrcoef(twins.T)[0, 1]) < 0.01
    on_edges = np.floor(xy)
    apart = twin_values(octave, on_edges - 1e-9, none) - twin_values(octave, on_edges + 1e-9, none)
    assert np.abs(apart).max() < 1e-7
    half = twin_values(octave, xy[:100], np.full(100, 2**0.5))
    np.testing.assert_allclose(half, twins[:100] / 2, atol=1e-12)


@given(x=st.floats(-1e4, 1e4), y=st.floats(-1e4, 1e4), log_radius=st.floats(-3, 4))
def test_ground_stays_within_what_is_said_of_a_circle(x, y, log_radius):
    ground, radius = Relief(3, 30.0, 512.0, 0.8), 10.0**log_radius
    low, high = ground.height_bounds(HOME, np.array([[x, y]]), np.array([radius]))
    turn, away = np.random.default_rng(8).random((2, 2000))
    circle = radius * np.sqrt(away) * np.exp(2j * np.pi * turn)
    height = ground.height(HOME, np.stack((x + circle.real, y + circle.imag), axis=1))
    assert low[0] <= height.min() and height.max() <= high[0]
    lowest, highest = ground.bounds()
    assert lowest <= height.min() and height.max() <= highest
    assert high[0] - low[0] <= 2 * (highest - lowest)


def test_crests_have_their_size_and_bounds():
    """The constants of |noise|, and a ridged relief's RMS, mean and bounds."""
    xy = np.random.default_rng(5).uniform(0, 3e4, (400_000, 2))
    octave = octaves_at(Corner(0, 0), 99, np.ones(1), np.ones(1))
    noise = np.abs(octave_values(octave, xy, np.zeros(len(xy))))
    assert noise.mean() == pytest.approx(RIDGED_MEAN, rel=0.005)
    assert noise.std() == pytest.approx(RIDGED_RMS, rel=0.005)
    relief = Relief(3, 50.0, 64.0, 0.8, ridged=True)
    height = relief.height(Corner(7, -3), xy)
    assert height.std() == pytest.approx(50.0, rel=0.03)
    assert height.mean() == pytest.approx(0.0, abs=1.0)
    low, high = relief.bounds()
    assert low < height.min() and height.max() < high
    low, high = relief.height_bounds(Corner(7, -3), xy[:1000], np.full(1000, 3.0))
    assert np.all((low <= height[:1000]) & (height[:1000] <= high))


def test_ridged_slopes_are_those_of_the_heights():
    relief, xy = Relief(3, 5.0, 64.0, 1.0, True), np.random.default_rng(6).uniform(0, 500, (500, 2))
    step = np.array((1e-6, 0.0))
    east = relief.height(Corner(0, 0), xy + step) - relief.height(Corner(0, 0), xy - step)
    slope = relief.slopes(Corner(0, 0), xy, np.zeros(len(xy)))[:, 0]
    assert np.mean(np.isclose(east / 2e-6, slope, atol=1e-5)) > 0.99  # crests between apart


def test_no_point_minds_which_were_asked_for_before_it():
    """Cells of the lattice are kept from point to point: the same bytes in any order, or alone."""
    rng = np.random.default_rng(8)
    ground = Relief(seed=3, amplitude=9.0, wavelength=256.0, hurst=0.8)
    xy = np.concatenate((spread(rng, 200, 400.0), rng.uniform(0, 3, (200, 2))))
    order, shortest = rng.permutation(len(xy)), rng.uniform(0, 20, len(xy))
    for of in (ground.low_pass_height, ground.slopes):
        found = of(FAR, xy, shortest)
        assert np.array_equal(of(FAR, xy[order], shortest[order]), found[order])
        for row in order[:40]:
            one = slice(row, row + 1)
            assert np.array_equal(of(FAR, xy[one], shortest[one]), found[one])


@pytest.mark.parametrize("cell", [(0, 0), (62_500_000_000, -62_500_000_000)])
def test_positions_are_exact_to_a_micrometre(cell):
    """Homes relative to the eye, against rational arithmetic on the plane's own coordinates."""
    preset = load_preset("meadow", [f"camera.cell={list(cell)}", "render.size=320x180"])
    scene = Scene(preset)
    world = scene.world
    view = scene.view(1)
    corner, eye = view.camera.corner, view.camera.eye
    assert abs(corner.x) * GRID_M >= (1e12 if cell[0] else 0)
    for field in world.fields:
        objects = prune(field, view).parts.state
        assert len(objects) > 100
        side, samples = Fraction(field.cells.side_m), objects.samples
        for k in range(0, len(objects), len(objects) // 100):
            for axis, (number, first) in enumerate(
                ((samples.cell_x[k], corner.x), (samples.cell_y[k], corner.y))
            ):
                there = (int(number) + Fraction(float(samples.u[k, axis]))) * side
                seen_from = int(first) * Fraction(GRID_M) + Fraction(float(eye[axis]))
                found = Fraction(float(objects.instances.origin[k, axis])) - Fraction(
                    float(eye[axis])
                )
                assert abs(found - (there - seen_from)) < Fraction(1, 10**6)


@pytest.mark.slow
def test_a_frame_does_not_know_how_far_the_world_goes():
    """The same cut, ids included, in worlds of 10⁶ to 10¹⁵ objects around the same eye."""
    cuts = []
    for side in (8e3, 1.8e8, None):
        extent = [] if side is None else [f"world.extent={side!r}"]
        preset = load_preset("crowd", ["render.size=160x90", *extent])
        scene = Scene(preset)
        world = scene.world
        cuts.append(prune(world.fields[0], scene.view(3)))
    for cut in cuts[1:]:
        for name in ("object", "part", "parent", "level"):
            assert np.array_equal(getattr(cut, name), getattr(cuts[0], name))
        assert np.array_equal(cut.parts.position, cuts[0].parts.position)
