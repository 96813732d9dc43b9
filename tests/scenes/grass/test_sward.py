"""Tufts of grass: as many blades, as long, and in limits that are exact; and the law's counts."""

import numpy as np
import pytest

from bench.frame_counts import predict
from lod.camera import Corner, camera_from_heading
from lod.law import chained_limits, count_variance, disc_areas, expected_count
from lod.metric import METRICS
from lod.pruner import prune, prune_by_level
from lod.view import View
from scenes.field.species_field import Species, SpeciesField
from scenes.grass.sward import BLADES, RANKINGS, ROOT_M, ranked, tuft_prototypes
from scenes.ground.mesh import Terrain
from scenes.models.catalogue import model_prototypes
from scenes.presets.load import load_preset
from scenes.sticks.prototype import Prototype

FLAT = Terrain(seed=0, amplitude=0.0, wavelength=1024.0, hurst=1.0, reach=1000.0)
SIZES = (0.8, 1.0, 1.25)


def blades(tuft: Prototype) -> np.ndarray:
    """Corners of each blade: two at its root, two half-way up and its tip, (BLADES, 5, 3) [m]."""
    corners = tuft.meshes.vertices.reshape(-1, 5, 3)
    assert np.array_equal(tuft.meshes.vertex_owner[::5], np.arange(1, 1 + BLADES))
    return corners


def blade_lengths(tuft: Prototype, size: float) -> np.ndarray:
    """Length of each blade above the ground along its two halves, (BLADES,) [m]."""
    corners = blades(tuft)
    root, half, tip = corners[:, :2].mean(axis=1), corners[:, 2:4].mean(axis=1), corners[:, 4]
    lower, upper = np.linalg.norm(half - root, axis=1), np.linalg.norm(tip - half, axis=1)
    return lower - ROOT_M * size + upper


def test_blades_are_as_long_as_they_should_be():
    """In sizes from 0.8 to 1.25 they are 3 to 60 cm long, and most longer than 12."""
    tufts = model_prototypes("sward", 4, SIZES, False)[::RANKINGS]
    lengths = np.concatenate([blade_lengths(t, SIZES[k % 3]) for k, t in enumerate(tufts)])
    assert np.median(lengths) >= 0.12
    assert lengths.min() >= 0.03 - 1e-9 and lengths.max() <= 0.60 + 1e-9


@pytest.mark.parametrize("preset", ["meadow", "forest", "zoo"])
def test_presets_have_300_blades_to_the_square_metre_half_of_them_over_12_cm(preset):
    """Every prototype in every size of the preset is equally likely."""
    (sward,) = (e for e in load_preset(preset).species.values() if e.model == "sward")
    tufts = model_prototypes("sward", sward.prototypes, sward.sizes, False)[::RANKINGS]
    each = [blade_lengths(t, sward.sizes[k % len(sward.sizes)]) for k, t in enumerate(tufts)]
    assert sward.density * np.mean([len(lengths) for lengths in each]) >= 300
    assert np.median(np.concatenate(each)) >= 0.12


def test_p_and_r_are_those_of_the_blades():
    """P² is the largest area of three triangles over many directions; R reaches every corner."""
    toward = np.random.default_rng(0).normal(size=(20000, 3))
    toward /= np.linalg.norm(toward, axis=1)[:, None]
    for tuft in tuft_prototypes(0, 2):
        h, leaf = tuft.hierarchy, tuft.leaf
        for row, corners in enumerate(blades(tuft), start=1):
            a, b, c = corners[[[0, 0, 3], [1, 2, 2], [2, 3, 4]]]
            covered = np.abs(toward @ np.cross(b - a, c - a).T / 2).sum(axis=1)
            assert covered.max() * (1 - 1e-9) <= h.P[row] ** 2 <= 1.01 * covered.max()
            mine = slice(leaf.first[row], leaf.first[row + 1])
            points = np.concatenate((corners, leaf.start[mine], leaf.end[mine]))
            thick = np.r_[np.zeros(5), leaf.start_radius[mine], leaf.end_radius[mine]]
            far = np.linalg.norm(points - h.position[row], axis=1) + thick
            assert h.R[row] == pytest.approx(far.max())
            assert h.R[0] >= np.linalg.norm(corners, axis=1).max()


def test_a_round_stick_covers_what_its_blade_covers_on_average():
    """Over turns about its length: what stands for a blade in larger shapes has its area."""
    (tuft,) = tuft_prototypes(0, 1)
    for row, corners in enumerate(blades(tuft), start=1):
        width = np.linalg.norm(corners[1] - corners[0], axis=0) * 2 / np.pi
        assert 2 * tuft.leaf.start_radius[tuft.leaf.first[row]] == pytest.approx(width)


@pytest.mark.parametrize("metric", ["blake", "bounded", "solid_angle"])
def test_the_law_counts_them(metric):
    """On flat ground, all round, within 4 standard deviations."""
    tufts = tuple(each for tuft in tuft_prototypes(0, 2) for each in ranked(tuft))
    density = {"blake": 0.6}.get(metric, 15.0)
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 1.7)), 0, 0, 60.0, (160, 90))
    view = View(camera, METRICS[metric], 1.0, look_around=True)
    cut = prune(SpeciesField(Species("sward", tufts, density), 5, FLAT), view)
    for found, rows in ((cut.displayed_objects, slice(1)), (cut.displayed_parts, slice(None))):
        mean = variance = 0.0
        for tree in (each.hierarchy for each in tufts):
            limits = chained_limits(tree, view.metric, view.m)
            areas = disc_areas(limits, 1.7 - tree.position[:, 2])[rows]
            mean += expected_count(density / len(tufts), areas)
            variance += count_variance(density / len(tufts), areas)
        assert mean > 300
        assert abs(found - mean) < 4 * np.sqrt(variance)


def test_a_species_has_a_metric_of_its_own():
    """It is displayed as in a view of that metric; what has no limit, or a depth, is the view's."""
    tufts = tuft_prototypes(0, 2)
    camera = camera_from_heading(Corner(0, 0), np.array((0.0, 0.0, 1.7)), 0, 0, 60.0, (160, 90))

    def shown(own: str | None, name: str) -> tuple[int, int, float]:
        species = Species("sward", tufts, 2.0, metric=None if own is None else METRICS[own])
        field, view = SpeciesField(species, 5, FLAT, 12.0), View(camera, METRICS[name], 1.0)
        by_level = prune_by_level(field, species.seen_in(view))
        assert np.array_equal(by_level.part, prune(field, view).part)
        law = predict(field, view)
        return len(by_level), by_level.examined_parts, 0.0 if law is None else law.parts

    assert shown("bounded", "blake") == shown(None, "bounded") != shown(None, "blake")
    for name in ("full", "depth"):
        assert shown("bounded", name) == shown(None, name)
