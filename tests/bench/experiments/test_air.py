"""The air experiment judges by its samples alone; its colours are compared as eyes see them."""

import numpy as np
import pytest

from bench.experiments.air import EXPERIMENT, SKY, delta_e
from bench.records.records import Point, columns


def band(analytic, delta, low=100.0, pixels=50):
    samples = {"pixels": [pixels] * 3, "analytic": analytic}
    samples |= {"medium": [100] * 3, "spectral": [100] * 3, "delta_e": delta}
    return Point({"topic": "air", "what": "bands", "from": low}, samples=columns(samples))


def verdicts(*points):
    return {claim.name: claim.verdict for claim in EXPERIMENT.judged(points)}


def test_bands_are_judged_against_the_medium_and_two_units_of_colour():
    judged = verdicts(
        band([150, 151, 149], [900, 950, 1000]), band([100] * 3, [3000, 3001, 3002], SKY)
    )
    assert list(judged.values()) == ["refuted", "holds", "refuted"]
    assert [name.split("/")[-1] for name in judged] == ["from_100_m"] * 2 + ["sky"]


def test_bands_of_few_pixels_are_not_judged():
    assert not verdicts(band([100] * 3, [100] * 3, pixels=5))


def test_delta_e_sees_colour_and_not_exposure():
    rng = np.random.Generator(np.random.Philox(3))
    picture = rng.uniform(0.05, 0.5, (8, 8, 3))
    assert delta_e(picture, 3 * picture).max() == pytest.approx(0.0, abs=1e-9)
    assert np.median(delta_e(picture, picture * (1.2, 1.0, 1.0))) > 2
