"""Defocus as a blur of the cascade: its width, the distance that it makes of a distance, limits."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lod.camera import Corner, ThinLens, camera_from_heading
from lod.hierarchy import Hierarchy
from lod.law import chained_limits
from lod.metric import METRICS, limit_distances
from lod.view import View
from lod.viewing import (
    DISC_WIDTH,
    BlurWidths,
    Defocus,
    ViewingConditions,
    defocus_limits,
    defocus_width,
)

THETA = 1e-3
LENSES = st.builds(
    lambda diameter, focus, corner: Defocus(ThinLens(diameter, focus), corner),
    st.floats(1e-4, 0.5),
    st.floats(0.2, 1e4) | st.just(math.inf),
    st.floats(1.0, 2.0),
)


def test_a_uniform_disc_is_as_wide_as_its_standard_deviation_says():
    x, y = np.meshgrid(*[np.linspace(-0.5, 0.5, 2001)] * 2)
    inside = x * x + y * y <= 0.25
    assert math.sqrt(12) * x[inside].std() == pytest.approx(DISC_WIDTH, rel=1e-3)


def test_the_width_by_hand():
    """A lens 2 cm wide focused at 5 m: discs of 4 and 2 mrad at 2.5 m and at 10 m on its axis."""
    width = defocus_width(Defocus(ThinLens(0.02, 5.0)), np.array([2.5, 5.0, 10.0]))
    np.testing.assert_allclose(width, DISC_WIDTH * np.array([4e-3, 0.0, 2e-3]), atol=1e-15)


@given(lens=LENSES, d=st.floats(0.05, 1e5), share=st.floats(0, 1))
def test_no_part_of_the_picture_is_blurred_less(lens, d, share):
    """Anywhere in the picture the point is between d and d/corner along the axis."""
    cosine = 1 - share * (1 - 1 / lens.corner)
    blur = DISC_WIDTH * lens.lens.diameter_m * abs(1 / (d * cosine) - lens.vergence)
    assert defocus_width(lens, np.array([d]))[0] <= blur * (1 + 1e-9) + 1e-15


def defocused_distance(defocus, theta, distance):
    """W of each distance, which nowhere decreases, (n,) [m]."""
    q, p = defocus.ratio(theta), defocus.vergence
    d = np.maximum(distance, defocus.sharpest_m(theta))
    beside = np.maximum(np.maximum(1 - p * d, p * d - defocus.corner), 0.0)
    return np.hypot(d, q * beside)


@given(lens=LENSES)
def test_w_is_the_largest_that_increases_below_the_blurred_distance(lens):
    d = np.geomspace(1e-3, 1e6, 20001)
    if math.isfinite(lens.lens.focus_m):  # the dip about the focus may be narrow
        away = np.geomspace(1e-9, 0.1, 2000)
        d = np.sort(np.concatenate((d, lens.sharpest_m(THETA) * (1 + np.append(-away, away)))))
    blurred = d * np.hypot(THETA, defocus_width(lens, d)) / THETA
    hull = np.minimum.accumulate(blurred[::-1])[::-1]
    found = defocused_distance(lens, THETA, d)
    assert (found <= hull * (1 + 1e-9)).all()
    np.testing.assert_allclose(found, hull, rtol=2e-3)


@given(lens=LENSES, clear=st.floats(1e-3, 1e6))
def test_a_limit_is_where_w_reaches_it(lens, clear):
    (limit,) = defocus_limits(lens, THETA, np.array([clear]))
    assert 0 <= limit <= clear
    if limit == 0:
        assert clear <= defocused_distance(lens, THETA, np.zeros(1))[0] * (1 + 1e-9)
    else:
        assert defocused_distance(lens, THETA, np.array([limit]))[0] == pytest.approx(clear)


def chain(n=40):
    """A chain of parts, each smaller than the one that owns it and near it."""
    size = 8.0 * 0.8 ** np.arange(n)
    return Hierarchy(
        parent=np.arange(-1, n - 1),
        level=np.arange(n),
        position=np.zeros((n, 3)),
        P=size,
        R=size / 2,
        B=np.full(n, 20.0) - 0.01 * np.arange(n),
        separation=np.where(np.arange(n) > 0, 0.01, 0.0),
    )


@given(lens=LENSES)
def test_the_pruner_and_the_law_have_the_same_limits(lens):
    sight = ViewingConditions(BlurWidths(THETA), acuity=False, defocus=lens)
    found = limit_distances(chain(), METRICS["blake"], THETA, sight)
    np.testing.assert_allclose(
        found, chained_limits(chain(), METRICS["blake"], THETA, sight), rtol=1e-6, atol=1e-6
    )


def test_a_wider_opening_displays_no_part_farther():
    limits = [
        limit_distances(
            chain(),
            METRICS["blake"],
            THETA,
            ViewingConditions(
                BlurWidths(THETA), acuity=False, defocus=Defocus(ThinLens(diameter, 12.0), 1.2)
            ),
        )
        for diameter in (1e-6, 0.005, 0.02, 0.08)
    ]
    assert all((a >= b).all() and (a > b).any() for a, b in pairwise(limits))
    sharp = limit_distances(chain(), METRICS["blake"], THETA)
    np.testing.assert_allclose(limits[0], sharp, rtol=1e-4)


def test_out_of_view_nothing_is_displayed_farther_than_in_view():
    camera = camera_from_heading(Corner(0, 0), np.zeros(3), 0.0, 0.0, 60.0, (640, 360))
    camera = replace(camera, lens=ThinLens(0.02, 10.0))
    sight = ViewingConditions(
        BlurWidths(camera.pixel_angle),
        acuity=False,
        defocus=Defocus(camera.lens, camera.corner_secant),
    )
    inside, outside = View(camera, METRICS["blake"], conditions=sight).limits(chain())
    assert (outside <= inside).all()
    assert camera.corner_secant == pytest.approx(math.hypot(1, *camera.tan_half))
