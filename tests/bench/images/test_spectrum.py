"""Power stands in the octave of its wave and adds up; verdicts follow from the powers."""

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.spectrum import DETAILS, EDGES, picture, spectrum
from bench.records.records import Column, Point, predictions
from scenes.render.variants import choose

OCTAVES = len(EDGES) - 1


@pytest.mark.parametrize("octave", range(1, OCTAVES))
def test_a_wave_has_its_power_in_its_own_octave(octave):
    """Of amplitude 1 it is 1/2."""
    frequency = 1.4 * EDGES[octave]
    x = np.arange(256)
    found = spectrum(np.cos(2 * np.pi * frequency * x)[None, :] * np.ones((128, 1)))
    assert found[octave] == pytest.approx(0.5, rel=0.03)
    assert found.sum() == pytest.approx(0.5, rel=0.03)


def test_a_constant_has_none_and_white_noise_its_variance():
    assert spectrum(np.full((64, 96), 0.7)).sum() == pytest.approx(0.0, abs=1e-20)
    rng = np.random.Generator(np.random.Philox(3))
    found = spectrum(rng.standard_normal((256, 256)))
    # Octaves of rings within 1/2; the corners of the square of frequencies are beyond.
    assert found[-1] == pytest.approx(np.pi * (0.25 - 0.0625), rel=0.03)


def planted(low, high, left):
    """Difference of so much power below and above the cut-off, and a share left above it."""
    points = []
    for detail in DETAILS:
        cutoff, samples = 1 / (2 * detail), []
        for k in range(OCTAVES):
            above = EDGES[k] >= cutoff
            lost = high if above else low
            rows = {
                "whole": [1000, 1010, 990],
                "pruned": [round(v * (left if above else 1)) for v in (1000, 1010, 990)],
                "lost": [lost, lost + 1, lost + 2],
            }
            for name, row in rows.items():
                samples.append(Column("power", row, {"picture": name, "octave": k}))
        points.append(
            Point(
                {"topic": "spectrum", "detail": detail},
                predictions({"cutoff": cutoff}),
                tuple(samples),
            )
        )
    return tuple(points)


def test_verdicts_follow_from_powers():
    assert {c.verdict for c in EXPERIMENT.judged(planted(1, 500, 0.02))} == {"holds"}
    assert {c.verdict for c in EXPERIMENT.judged(planted(500, 500, 0.9))} == {"refuted"}


@pytest.mark.slow
def test_nothing_pruned_is_nothing_lost():
    variant = choose()
    assert np.array_equal(picture(20.0, None, variant, 6), picture(20.0, None, variant, 6))
    apart = [
        spectrum(picture(20.0, d, variant, 6) - picture(20.0, None, variant, 6)).sum()
        for d in (1e-3, 4.0, 16.0)
    ]
    assert apart[0] < apart[1] / 10 < apart[2] / 10
