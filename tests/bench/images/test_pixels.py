"""Pixels that sticks cover are those of plane geometry; verdicts follow from the counts."""

import math
import re

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.pixels import covered, drawn
from bench.part_sizes import camera
from bench.records.provenance import provenance
from bench.records.records import Point, Record, columns
from bench.statistics.estimates import two_sided_quantile
from lod.metric import METRICS
from lod.view import View
from tests.bench.edited import svg_of

VIEW = View(camera(640), METRICS["blake"], look_around=True)
THETA = VIEW.camera.pixel_angle


def sphere(radius, away, aside=0.0):
    centre = VIEW.camera.eye + np.array([[aside, away, 0.0]])
    return centre, centre, np.array([radius]), np.array([radius])


@pytest.mark.parametrize("pixels", [10.0, 30.0])
def test_a_sphere_covers_its_disc(pixels):
    """π r² in area; and as pixels the disc grown by half a pixel or so on every side."""
    away = 50.0
    count, area = covered(sphere(pixels * THETA * away, away), VIEW, np.array((1, 2)))
    assert area == pytest.approx(math.pi * pixels**2, rel=0.03)
    assert math.pi * pixels**2 < count < math.pi * (pixels + 1) ** 2


def test_what_is_seen_twice_covers_once():
    one = sphere(1.0, 50.0)
    twice = tuple(np.concatenate((each, each)) for each in one)
    phase = np.zeros(2, np.int64)
    assert covered(one, VIEW, phase) == covered(twice, VIEW, phase)


def point(metric, parts, pixels):
    case = {"topic": "pixels", "species": "tree", "metric": metric, "detail": 1.0}
    area = [1000 * each for each in pixels]
    return Point(case, samples=columns({"parts": parts, "pixels": pixels, "area": area}))


def test_verdicts_follow_from_counts():
    few, many = point("blake", [3] * 200, [2] * 200), point("bounded", [90] * 200, [9] * 200)
    held, refuted = EXPERIMENT.judged((few, many))
    assert (held.verdict, refuted.verdict) == ("holds", "refuted")
    mixed = point("blake", [30] * 30 + [3] * 170, [2] * 200)
    assert EXPERIMENT.judged((mixed,))[0].verdict == "refuted", "15 % have more"


def test_the_interval_of_a_quantile_covers_it():
    rng = np.random.Generator(np.random.Philox(4))
    found = [two_sided_quantile(rng.exponential(1.0, 400), 0.95) for _ in range(400)]
    inside = np.mean([each.low <= -math.log(0.05) <= each.high for each in found])
    assert 0.93 < inside < 0.995


def test_parts_are_those_of_the_objects_drawn_and_repeat():
    found = drawn("figure", "bounded", 4.0, 20, 1)
    assert found == drawn("figure", "bounded", 4.0, 20, 1)
    assert len(found["parts"]) == len(found["pixels"]) == 20 and min(found["parts"]) >= 1
    points = (
        Point(
            {"topic": "pixels", "species": "figure", "metric": "bounded", "detail": 4.0},
            samples=columns(found),
        ),
    )
    record = Record("images", 1, True, "", provenance("", 1), points, EXPERIMENT.judged(points), {})
    assert not any(re.search(r"\bnan\b", svg_of(plot)) for plot in EXPERIMENT.plots(record))
