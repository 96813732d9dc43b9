"""Air, display and eye shorten limit distances: each by its contrast, before the clamp."""

import math

import numpy as np
import pytest
from colour.contrast import (
    contrast_sensitivity_function_Barten1999,
    optical_MTF_Barten1999,
    pupil_diameter_Barten1999,
    retinal_illuminance_Barten1999,
)
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, minimize_scalar

from lod.air import Air, least_extinction
from lod.camera import Corner, camera_from_heading
from lod.eye import (
    CONTRAST_CLASSES,
    NEVER_LOST,
    SQUARE_WAVE_GAIN,
    Display,
    Eye,
    optical_sigma,
    sensitivity,
)
from lod.hierarchy import Hierarchy
from lod.metric import METRICS, limit_distances
from lod.view import View
from lod.viewing import (
    UNWEIGHTED,
    BlurWidths,
    ViewingConditions,
    blur_widths,
    eye_width,
    gaussian_transfer,
    perceptual_limits,
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


@settings(max_examples=100)
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


@pytest.mark.parametrize("contrast", [0.1, 1.0])
@pytest.mark.parametrize("visibility_m", [500.0, 5e4])
@pytest.mark.parametrize("detail", [0.5, 3.0])
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


def sigma_of(x, kernel):
    return math.sqrt(np.sum(kernel * x**2) / np.sum(kernel))


def test_widths_of_convolved_blurs_add_in_quadrature():
    """Two boxes and a Gaussian, convolved numerically."""
    x = np.arange(-2000, 2001) / 1000
    boxes = [(np.abs(x) <= half).astype(float) for half in (0.15, 0.3)]
    gauss = np.exp(-(x**2) / (2 * 0.1**2))
    widths = [math.sqrt(12) * sigma_of(x, kernel) for kernel in (*boxes, gauss)]
    spread = np.convolve(np.convolve(boxes[0], boxes[1], "same"), gauss, "same")
    assert math.sqrt(12) * sigma_of(x, spread) == pytest.approx(
        BlurWidths(*widths).effective, rel=1e-4
    )


def test_transfer_of_the_eye_is_bartens():
    display, eye = Display(), Eye()
    f = np.array([1.0, 5, 20, 40])
    expected = optical_MTF_Barten1999(f, optical_sigma(display, eye))
    assert gaussian_transfer(math.degrees(eye_width(display, eye)), f) == pytest.approx(expected)


def test_width_of_the_standard_observer():
    """σ₀ = 0.5', C_ab = 0.08'/mm and a pupil of 2.86 mm: σ = 0.550', so √12·σ = 1.90'."""
    assert math.degrees(eye_width(Display(), Eye())) * 60 == pytest.approx(1.904, abs=2e-3)


CAMERA = camera_from_heading(Corner(0, 0), np.array([0.0, 0.0, 2.0]), 0.0, 0.0, 60.0, (640, 360))
VIEW_PIXEL = CAMERA.pixel_angle
BETA = 3.5 / 2000


def tree_of(*contrasts):
    """A chain of parts with these classes, each a third of the one before and 1 m from it."""
    n = len(contrasts)
    size = 9.0 / 3.0 ** np.arange(n)
    return Hierarchy(
        parent=np.arange(-1, n - 1),
        level=np.arange(n),
        position=np.zeros((n, 3)),
        P=size,
        R=size,
        B=size + np.arange(n, 0, -1),
        separation=np.minimum(np.arange(n), 1.0),
        contrast=np.array(contrasts),
    )


def test_without_an_eye_all_is_kept_as_fine_as_asked_up_to_where_contrast_is_gone():
    sight, row = (
        ViewingConditions(BlurWidths(VIEW_PIXEL), BETA, acuity=False),
        CONTRAST_CLASSES.index(1.0),
    )
    clear = np.geomspace(1, 1e5, 200)
    seen = perceptual_limits(sight, clear, np.full(200, row), VIEW_PIXEL)
    gone = math.log(sensitivity(Display(), Eye()).value.max()) / BETA
    assert (seen == np.minimum(clear, gone)).all()
    assert gone * BETA / 3.912 == pytest.approx(1.745, abs=0.01)  # of V, in air as thick as red is


def test_with_an_eye_it_is_the_weighted_distance():
    widths = blur_widths(VIEW_PIXEL, Display(40.0), Eye())
    sight = ViewingConditions(widths, BETA, Display(40.0), Eye())
    clear, m = np.geomspace(1, 1e5, 50), sight.widths.effective
    for row, contrast in enumerate(CONTRAST_CLASSES):
        W = weighted_distance(contrast, BETA, m, widths, Display(40.0), Eye())
        assert (perceptual_limits(sight, clear, np.full(50, row), m) == W.inverse(clear)).all()


@pytest.mark.parametrize("acuity", [False, True])
def test_clear_air_and_what_is_never_lost_are_the_cut_of_today(acuity):
    tree = tree_of(NEVER_LOST, NEVER_LOST, NEVER_LOST)
    hazy = ViewingConditions(BlurWidths(VIEW_PIXEL), BETA, acuity=acuity)
    assert hazy.weighted(math.inf, VIEW_PIXEL) is UNWEIGHTED
    for metric in (each for each in METRICS.values() if not each.by_contrast):
        alone = limit_distances(tree, metric, VIEW_PIXEL)
        assert (limit_distances(tree, metric, VIEW_PIXEL, hazy) == alone).all()
    assert (
        ViewingConditions(BlurWidths(VIEW_PIXEL), 0.0, acuity=False).weighted(0.1, VIEW_PIXEL)
        is UNWEIGHTED
    )


def test_every_part_has_the_limit_of_its_own_contrast():
    """V = 2 km: what is bolder lasts ln(C ratio)/β further."""
    sight = ViewingConditions(BlurWidths(VIEW_PIXEL), BETA, acuity=False)
    gone = [sight.weighted(c, VIEW_PIXEL).vanishing_distance for c in CONTRAST_CLASSES[:-1]]
    assert np.diff(gone) == pytest.approx(np.diff(np.log(CONTRAST_CLASSES[:-1])) / BETA)
    D = limit_distances(tree_of(3, 1, 0), METRICS["blake"], 1e-4, sight)
    assert D == pytest.approx([gone[3], gone[1], gone[0]])


def test_limits_are_weighted_before_they_are_clamped():
    """A faint whole takes its bold part with it, and the clamp is in metres of the scene."""
    sight = ViewingConditions(BlurWidths(VIEW_PIXEL), BETA, acuity=False)
    faint = sight.weighted(CONTRAST_CLASSES[0], VIEW_PIXEL).vanishing_distance
    D = limit_distances(tree_of(0, 3, 3), METRICS["blake"], 1e-4, sight)
    assert D == pytest.approx([faint, faint - 1.0, faint - 2.0])


@given(
    contrast=st.lists(st.integers(0, NEVER_LOST), min_size=4, max_size=4),
    beta=st.floats(0, 0.1),
    m=st.floats(1e-4, 1e-2),
    acuity=st.booleans(),
    metric=st.sampled_from(sorted(METRICS)),
)
def test_cuts_stay_connected_and_air_only_takes(contrast, beta, m, acuity, metric):
    tree, sight = (
        tree_of(*contrast),
        ViewingConditions(BlurWidths(VIEW_PIXEL), beta, acuity=acuity),
    )
    clear = limit_distances(tree, METRICS[metric], m)
    D = limit_distances(tree, METRICS[metric], m, sight)
    assert (D <= clear).all()
    shown = D[1:] > 0
    assert (D[:-1][shown] >= D[1:][shown] + tree.separation[1:][shown]).all()


def test_a_view_weighs_in_view_and_out_of_it_each_with_its_own_detail():
    display = Display(200.0)
    sight = ViewingConditions(blur_widths(VIEW_PIXEL, display, Eye()), 20 * BETA, display)
    view, tree = View(CAMERA, METRICS["blake"], 1.0, conditions=sight), tree_of(2, 2, 1)
    inside, outside = view.limits(tree)
    assert view.m == pytest.approx(sight.widths.effective)
    assert view.m > 2 * VIEW_PIXEL
    assert (inside == limit_distances(tree, METRICS["blake"], view.m, sight)).all()
    assert (outside == limit_distances(tree, METRICS["blake"], 4 * view.m, sight)).all()
    assert (outside < limit_distances(tree, METRICS["blake"], 4 * view.m)).any()
    assert sight.weighted(0.5, view.m) is not sight.weighted(0.5, view.m_offscreen)
