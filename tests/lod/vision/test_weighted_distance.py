import math

import numpy as np
import pytest
from colour.contrast import (
    contrast_sensitivity_function_Barten1999,
    pupil_diameter_Barten1999,
    retinal_illuminance_Barten1999,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from lod.atmosphere.air import Air, least_extinction
from lod.errors import InputError
from lod.vision.blur_cascade import BlurWidths, blur_widths
from lod.vision.contrast import CONTRAST_CLASSES
from lod.vision.eye import SQUARE_WAVE_GAIN, Display, Eye, optical_sigma
from lod.vision.weighted_distance import (
    UNWEIGHTED,
    WeightedDistance,
    display_frequency,
    weighted_distance,
)

PIXEL = 1e-3


def decades(low, high):
    return st.floats(math.log(low), math.log(high)).map(math.exp)


AIRS = decades(50, 1e6).map(lambda V: V if V < 3.3e5 else None)
CONTRASTS = decades(1e-3, 2) | st.sampled_from(CONTRAST_CLASSES)
DISPLAYS = st.builds(Display, st.floats(20, 120), decades(0.01, 1e4), st.floats(5, 120))
EYES = st.builds(Eye, st.floats(0.1, 3), st.floats(0, 0.3), st.floats(1, 10))
DETAILS = decades(0.1, 30)


def tabulated(visibility_m, contrast, display, eye, detail, blurs=(0.0, 0.0), pixel=PIXEL):
    widths = blur_widths(pixel, display, eye, *blurs)
    beta = least_extinction(Air(visibility_m))
    return weighted_distance(contrast, beta, detail * widths.effective, widths, display, eye)


def distances(W):
    """Over every scale, and close about the knots and the end."""
    ends = W.distance[-1] * np.array([1 - 1e-6, 1 - 1e-9, 1, 1 + 1e-9, 1 + 1e-6])
    near = W.distance[:: max(1, len(W.distance) // 16)]
    every = np.concatenate(([0.0], np.geomspace(1e-3, 1e13, 80), ends, near, near * (1 + 1e-9)))
    return np.unique(every)


@pytest.mark.slow
@settings(max_examples=10_000)
@given(
    visibility_m=AIRS,
    contrast=CONTRASTS,
    display=DISPLAYS,
    eye=EYES,
    detail=DETAILS,
    blurs=st.tuples(st.floats(0, 1e-2), st.floats(0, 1e-2)),
)
def test_weighted_distance_and_its_inverse(visibility_m, contrast, display, eye, detail, blurs):
    W = tabulated(visibility_m, contrast, display, eye, detail, blurs)
    d = distances(W)
    weighted = W.weight(d)
    finite = np.isfinite(weighted)
    # Never below clear air; strictly increasing while finite, then infinite for good.
    assert (weighted >= d).all()
    gaps = np.diff(d) > 1e-12 * d[1:]
    assert (np.diff(weighted[finite])[gaps[: finite.sum() - 1]] > 0).all()
    assert (finite == (d <= W.vanishing_distance)).all()
    # There and back.
    back = W.inverse(weighted[finite])
    assert (np.abs(back - d[finite]) <= 1e-9 * d[finite]).all()
    # Limit distances only shrink, in order, and none is past the end.
    limit = W.inverse(d)
    assert (limit <= d).all()
    assert (np.diff(limit) >= 0).all()
    assert (limit <= W.vanishing_distance).all()


@given(display=DISPLAYS, contrast=CONTRASTS, visibility_m=AIRS, eye=EYES)
def test_an_ideal_eye_or_endless_contrast_loses_nothing(display, contrast, visibility_m, eye):
    assert tabulated(visibility_m, contrast, display, None, 1.0) is UNWEIGHTED
    assert tabulated(visibility_m, math.inf, display, eye, 1.0) is UNWEIGHTED


def test_identity_is_exact_to_the_last_bit():
    d = np.append(np.random.default_rng(5).lognormal(5, 5, 1000), [0, np.inf, 5e-324])
    assert (UNWEIGHTED.weight(d) == d).all()
    assert (UNWEIGHTED.inverse(d) == d).all()
    # Clear air, a real eye: what it sees at the metric's limit is not weighted either.
    assert (tabulated(None, 1.0, Display(), Eye(), 1.0).weight(d) == d).all()


def direct(contrast, beta, m, display, eye, d):
    """W from its definition alone, by root finding on colour-science's curve (box pixel blur)."""
    sigma = optical_sigma(display, eye)
    pupil = pupil_diameter_Barten1999(display.luminance, display.field_deg)
    blur_sigma = 1 / display.pixels_per_degree / math.sqrt(12)

    def log_seen(log_f):
        f = math.exp(log_f)
        barten = contrast_sensitivity_function_Barten1999(
            f,
            sigma,
            X_0=display.field_deg,
            E=retinal_illuminance_Barten1999(display.luminance, pupil),
        )
        return math.log(SQUARE_WAVE_GAIN * barten) - 2 * (math.pi * blur_sigma * f) ** 2

    peak = minimize_scalar(lambda x: -log_seen(x), bounds=(-1, 3), method="bounded").x
    left = math.log(contrast) - beta * d
    if left + log_seen(peak) < 0:
        return math.inf
    f_s = math.exp(brentq(lambda x: left + log_seen(x), peak, math.log(150)))
    f_m = display.pixels_per_degree / (2 * m / PIXEL)
    return d * max(1.0, f_m / f_s)


@pytest.mark.parametrize("contrast", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("visibility_m", [500.0, 5e3, 5e4])
@pytest.mark.parametrize("detail", [0.5, 1.0, 3.0])
@pytest.mark.parametrize("display", [Display(), Display(30.0, 10.0, 25.0)])
def test_table_against_the_definition(contrast, visibility_m, detail, display):
    """Never above the curve, and within two steps of frequency below it."""
    eye, m = Eye(), detail * PIXEL
    beta = least_extinction(Air(visibility_m))
    W = weighted_distance(contrast, beta, m, BlurWidths(PIXEL), display, eye)
    d = np.append(np.linspace(0.02, 0.98, 12) * W.vanishing_distance, 1.001 * W.vanishing_distance)
    exact = np.array([direct(contrast, beta, m, display, eye, x) for x in d])
    got = W.weight(d)
    assert np.isinf(exact[-1])
    assert np.isinf(got[-1])
    assert (got[:-1] <= exact[:-1] * (1 + 1e-5)).all()
    assert (got[:-1] >= exact[:-1] * 0.99).all()


def test_haze_takes_large_far_parts_and_leaves_small_near_ones():
    """V = 2 km, grey on grey: what could be seen at 300 m still is; 3 km and 30 km end together."""
    W = tabulated(2e3, 0.2, Display(), Eye(), 1.0)
    small, large, largest = W.inverse(np.array([300.0, 3e4, 3e5]))
    assert small == 300
    assert large == largest == W.vanishing_distance
    assert 2000 < W.vanishing_distance < 4000


def test_a_fine_display_hides_what_is_faint_even_in_clear_air():
    """200 pixels per degree: its pixels are finer than sight, so the limit is 2·f_m/f_s nearer."""
    W = weighted_distance(1.0, 0.0, PIXEL, BlurWidths(PIXEL), Display(200.0), Eye())
    assert 1.5 < W.beyond < 2.5
    assert W.vanishing_distance == math.inf
    assert W.inverse(np.array([100.0]))[0] == pytest.approx(100 / W.beyond)


def test_contrast_that_nobody_sees_has_no_distance():
    W = tabulated(None, 1e-4, Display(), Eye(), 1.0)
    assert W.vanishing_distance == 0
    assert W.weight(np.array([0.0, 1e-9])).tolist() == [0, np.inf]
    assert W.inverse(np.array([1.0, np.inf])).tolist() == [0, 0]


@given(
    visibility_m=decades(100, 1e5),
    contrast=st.floats(0.05, 0.9),
    eye=EYES,
    detail=DETAILS,
    factor=st.floats(1.1, 3),
)
def test_thicker_air_and_less_contrast_weigh_more(visibility_m, contrast, eye, detail, factor):
    W = tabulated(visibility_m, contrast, Display(), eye, detail)
    thinner = tabulated(factor * visibility_m, contrast, Display(), eye, detail)
    bolder = tabulated(visibility_m, factor * contrast, Display(), eye, detail)
    d = np.geomspace(1, 1e6, 200)
    for easier in (thinner, bolder):
        assert easier.vanishing_distance >= W.vanishing_distance
        assert (easier.weight(d) <= W.weight(d) * 1.01).all()


@given(pixel=decades(1e-5, 1e-2), detail=DETAILS)
def test_only_pixels_count_not_the_lens(pixel, detail):
    """A picture looks the same on a display, whatever angle its pixels had at the camera."""
    wide = tabulated(5e3, 0.5, Display(), Eye(), detail)
    tele = tabulated(5e3, 0.5, Display(), Eye(), detail, pixel=pixel)
    d = np.geomspace(10, 9e3, 50)
    assert tele.weight(d) == pytest.approx(wide.weight(d), rel=0.01)


def test_the_blur_of_the_eye_counts_once():
    """It is in Barten's sensitivity; seeing and motion are not, and take more."""
    m, display, eye = 2 * PIXEL, Display(), Eye()
    seen = blur_widths(PIXEL, display, eye)
    alone, with_eye, shaken = (
        weighted_distance(0.5, 1e-3, m, widths, display, eye)
        for widths in (BlurWidths(PIXEL), seen, BlurWidths(PIXEL, motion=seen.eye))
    )
    d = np.linspace(0.5, 0.99, 20) * alone.vanishing_distance
    assert (with_eye.weight(d) == alone.weight(d)).all()
    assert (shaken.weight(d) > 1.05 * alone.weight(d)).any()


def test_a_pixel_is_half_a_period_on_the_display():
    assert display_frequency(PIXEL, BlurWidths(PIXEL), Display(60.0)) == pytest.approx(30.0)
    assert display_frequency(3 * PIXEL, BlurWidths(PIXEL), Display(60.0)) == pytest.approx(10.0)


def test_one_table_per_setting():
    assert tabulated(5e3, 0.5, Display(), Eye(), 1.0) is tabulated(5e3, 0.5, Display(), Eye(), 1.0)


@pytest.mark.parametrize(
    ("contrast", "beta", "m"),
    [(0.0, 0, 1), (math.nan, 0, 1), (1, -1, 1), (1, math.nan, 1), (1, math.inf, 1), (1, 0, 0)],
)
def test_bad_settings_are_refused(contrast, beta, m):
    with pytest.raises(InputError):
        weighted_distance(contrast, beta, m, BlurWidths(PIXEL), Display(), Eye())


@pytest.mark.parametrize("bad", [-1.0, math.nan])
def test_bad_distances_are_refused(bad):
    with pytest.raises(InputError):
        UNWEIGHTED.weight(np.array([bad]))
    with pytest.raises(InputError):
        UNWEIGHTED.inverse(np.array([bad]))


@pytest.mark.parametrize(
    ("d", "w", "beyond"),
    [
        ([], [], 1.0),
        ([1.0], [1.0], 1.0),
        ([0.0, 1.0], [0.0, 0.5], 1.0),
        ([0.0, 1.0, 1.0], [0.0, 1.0, 2.0], 1.0),
        ([0.0, 1.0, 2.0], [0.0, 3.0, 3.0], 1.0),
        ([0.0, 1.0], [0.0, math.inf], 1.0),
        ([0.0], [0.0], 0.5),
        ([0.0], [0.0], math.nan),
    ],
)
def test_a_table_that_is_no_weighted_distance_is_refused(d, w, beyond):
    with pytest.raises(InputError, match="W"):
        WeightedDistance(np.array(d), np.array(w), beyond)
