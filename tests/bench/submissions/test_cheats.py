"""Ten cheats and ten honest mistakes: each is void, or named by its cause; what is right counts."""

import re

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter, median_filter

from bench.submissions.diagnosis import enlarged, halved, moved
from bench.submissions.score import LEAST_KEPT, WITHIN, judge_picture
from scenes.frame.layers import SKY_Z
from scenes.render.pictures import to_srgb
from tests.bench.submissions import worlds

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def target():
    return worlds.target()


@pytest.fixture(scope="module")
def made():
    return worlds.handed_in()


def eight_bit(picture):
    return np.clip(np.round(picture / picture.max() * 255), 0, 255) / 255 * picture.max()


def with_nans(picture):
    found = picture.copy()
    found[10:14, 20:30] = np.nan
    return found


def without_far(picture, target):
    """Everything beyond 50 m painted as the mean of what is seen there."""
    far = (target.Z > 50) & (target.Z < SKY_Z)
    return np.where(far[..., None], picture[far].mean(axis=0), picture)


# What is done to a picture, whether it must be void, and what its cause must say.
MISTAKES = {
    "flipped": (lambda p, t: p["right"][:, ::-1], True, "flipped left to right"),
    "wrong gamma": (lambda p, t: to_srgb(p["right"], 1.0, "linear"), True, "gamma"),
    "half size": (lambda p, t: halved(p["right"]), True, "half size"),
    "no haze": (lambda p, t: p["no haze"], True, "no haze"),
    "field of view": (lambda p, t: p["fov"], True, r"field of view off by \+(0\.9|1\.[0-3])"),
    "sun": (lambda p, t: p["sun"], True, "sun azimuth"),
    "high sun": (lambda p, t: p["high sun"], True, "sun elevation"),
    "missing species": (lambda p, t: p["no tree"], True, "without tree"),
    "another missing": (lambda p, t: p["no figure"], True, "without figure"),
    "one frame late": (lambda p, t: p["late"], True, "one frame late"),
    "NaNs": (lambda p, t: with_nans(p["right"]), True, "NaNs"),
    "8 bit": (lambda p, t: eight_bit(p["right"]), False, "8 bit"),
}
CHEATS = {
    "nothing beyond 50 m": (lambda p, t: p["beyond 50 m"], True, "nothing beyond 50 m"),
    "beyond 50 m painted": (lambda p, t: without_far(p["right"], t), True, ""),
    "no things at all": (lambda p, t: p["nothing"], True, "without"),
    "blurred": (lambda p, t: gaussian_filter(p["right"], (2, 2, 0)), True, "blurred"),
    "median": (lambda p, t: median_filter(p["right"], (7, 7, 1)), True, ""),
    "half size enlarged": (
        lambda p, t: enlarged(halved(p["right"]), p["right"].shape, 1),
        False,
        "half size|blurred",
    ),
    "the reference": (lambda p, t: t.mean, True, "a copy"),
    "one half of it": (lambda p, t: t.halves[0], True, "a copy"),
    "nearly the reference": (lambda p, t: 0.8 * t.mean + 0.2 * p["right"], True, "a copy"),
    "brighter": (lambda p, t: 1.05 * p["right"], True, "exposure times 1.0"),
    "moved": (lambda p, t: moved(p["right"], 1, 1, 0), True, "camera turned"),
}


@pytest.mark.parametrize("name", [*MISTAKES, *CHEATS])
def test_each_is_void_or_named(name, made, target):
    change, void, cause = (MISTAKES | CHEATS)[name]
    found = judge_picture(change(made[0], target), target)
    assert bool(found.void) or not void, found
    assert re.search(cause, found.cause), (found.cause, found.explains, found.void)


def test_what_is_right_counts_and_agrees(made, target):
    pictures, Z = made
    found = judge_picture(pictures["right"], target, Z)
    assert (found.void, found.cause) == ("", "")
    assert abs(found.land - 1) < WITHIN
    assert abs(found.coverage - 1) < 2 * WITHIN  # one sample of each of 14 400 pixels
    assert all(b.kept > 0.95 for b in found.bands if np.isfinite(b.kept) and b.share > 0.01)


def test_a_coarse_cut_counts_and_is_farther_off(made, target):
    right, coarse = (judge_picture(made[0][name], target) for name in ("right", "coarse"))
    assert coarse.void == ""
    assert coarse.flip > 1.5 * right.flip
    assert min(b.kept for b in coarse.bands[:-1] if b.share > 0.01) > LEAST_KEPT
