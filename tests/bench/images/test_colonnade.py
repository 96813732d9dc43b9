"""Leonardo's columns: what is known of them before anything is rendered, and what a run says."""

import math
import re

import numpy as np
import pytest

from bench.experiments.images import EXPERIMENT
from bench.images.colonnade import (
    COUNT,
    DEPTH_M,
    EYE_M,
    SHOTS,
    camera,
    cut,
    image_width,
    picture,
    pixel_solid_angle,
    places,
)
from bench.runs import RunRequest, run_experiment
from scenes.frame.frame_input import Quality
from scenes.models.stone import HEIGHT_M, RADIUS_M
from scenes.render.variants import choose
from tests.bench.edited import edited, svg_of


def test_images_grow_and_angles_shrink_to_the_side():
    right = places()[COUNT // 2 :]
    tan_x, tan_y = camera().tan_half
    assert (places()[-1] + 1) / DEPTH_M < tan_x, (
        "every column is in the picture, with room to spare"
    )
    assert max(EYE_M, HEIGHT_M - EYE_M) / DEPTH_M < tan_y
    assert (np.diff([image_width(x) for x in right]) > 0).all()
    assert (np.diff([RADIUS_M / math.hypot(x, DEPTH_M) for x in right]) < 0).all()


def test_solid_angles_of_pixels_add_up_to_that_of_the_picture():
    """Of a rectangle ahead, 4·atan(ab/√(1 + a² + b²)) for half sides a and b."""
    a, b = camera().tan_half
    whole = 4 * math.atan(a * b / math.sqrt(1 + a * a + b * b))
    assert pixel_solid_angle().sum() == pytest.approx(whole, rel=1e-4)


def test_distance_takes_detail_from_the_side_and_depth_from_all_alike():
    for shot in SHOTS:
        parts = cut(shot)[1]
        if shot[0] == "depth":
            assert len(set(parts)) == 1
        else:
            assert parts[0] < parts[COUNT // 2] and parts == parts[::-1]


def test_nothing_pruned_is_no_error():
    quality = Quality(choose(), 1, 3, 2)
    one, owner = picture(("blake", 1e-9), quality)
    two, _ = picture(("depth", 1e-9), quality)
    assert np.array_equal(one, two)
    assert set(np.unique(owner)) == set(range(COUNT + 1))


@pytest.mark.slow
def test_a_quick_run_holds_what_it_must_and_is_judged_by_its_samples():
    record = run_experiment(EXPERIMENT, RunRequest("images", ("colonnade",), quick=True))
    by_angle = "luminance error weighted by solid angle, blake at 8 px ÷ depth at 12 px"
    verdict = {claim.estimand: claim.verdict for claim in record.claims}
    for name in ("width of the image, outermost ÷ middle", by_angle):
        assert verdict[name] == "holds", name
    worse = tuple(
        edited(p, "error_ppm", lambda _: [10**6] * 3, weight="eye")
        if p.case["metric"] == "blake"
        else p
        for p in record.points
    )
    again = {claim.estimand: claim.verdict for claim in EXPERIMENT.judged(worse)}
    assert again[by_angle] == "refuted"
    assert not any(re.search(r"\bnan\b", svg_of(plot)) for plot in EXPERIMENT.plots(record))
