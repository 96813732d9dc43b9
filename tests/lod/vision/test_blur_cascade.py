import math

import numpy as np
import pytest
from colour.contrast import optical_MTF_Barten1999
from hypothesis import given
from hypothesis import strategies as st

from lod.errors import InputError
from lod.vision.blur_cascade import (
    FULL_WIDTH,
    BlurWidths,
    blur_widths,
    eye_width,
    gaussian_transfer,
)
from lod.vision.eye import Display, Eye, optical_sigma

ANGLE = st.floats(1e-6, 1e-2)


def test_quadrature_by_hand():
    assert BlurWidths(3.0, 4.0).effective == pytest.approx(5)
    assert BlurWidths(1.0, 2.0, 2.0, 4.0).effective == pytest.approx(5)
    assert BlurWidths(3.0, 7.0, 4.0).before_eye == pytest.approx(5)


@given(pixel=ANGLE)
def test_alone_a_pixel_has_its_own_width(pixel):
    assert BlurWidths(pixel).effective == pixel


def sigma_of(x, kernel):
    return math.sqrt(np.sum(kernel * x**2) / np.sum(kernel))


def test_a_box_pixel_has_its_own_width():
    x = np.linspace(-1, 1, 200001)
    box = (np.abs(x) <= 0.35).astype(float)
    assert FULL_WIDTH * sigma_of(x, box) == pytest.approx(0.7, rel=1e-4)


def test_widths_of_convolved_blurs_add_in_quadrature():
    """Two boxes and a Gaussian, convolved numerically."""
    x = np.arange(-2000, 2001) / 1000
    boxes = [(np.abs(x) <= half).astype(float) for half in (0.15, 0.3)]
    gauss = np.exp(-(x**2) / (2 * 0.1**2))
    widths = [FULL_WIDTH * sigma_of(x, kernel) for kernel in (*boxes, gauss)]
    spread = np.convolve(np.convolve(boxes[0], boxes[1], "same"), gauss, "same")
    assert FULL_WIDTH * sigma_of(x, spread) == pytest.approx(
        BlurWidths(*widths).effective, rel=1e-4
    )


@given(width=ANGLE, f=st.floats(0.1, 1e3))
def test_transfer_is_the_fourier_transform_of_the_gaussian(width, f):
    sigma = width / math.sqrt(12)
    assert gaussian_transfer(width, np.array([f]))[0] == pytest.approx(
        math.exp(-2 * (math.pi * sigma * f) ** 2)
    )


def test_transfer_of_the_eye_is_bartens():
    display, eye = Display(), Eye()
    f = np.array([1.0, 5, 20, 40])
    expected = optical_MTF_Barten1999(f, optical_sigma(display, eye))
    assert gaussian_transfer(math.degrees(eye_width(display, eye)), f) == pytest.approx(expected)


def test_width_of_the_standard_observer():
    """σ₀ = 0.5', C_ab = 0.08'/mm and a pupil of 2.86 mm: σ = 0.550', so √12·σ = 1.90'."""
    assert math.degrees(eye_width(Display(), Eye())) * 60 == pytest.approx(1.904, abs=2e-3)


@given(pixel=ANGLE, ppd=st.floats(20, 120))
def test_the_eye_covers_the_same_pixels_of_any_camera(pixel, ppd):
    display, eye = Display(ppd), Eye()
    seen = blur_widths(pixel, display, eye)
    assert seen.eye / pixel == pytest.approx(eye_width(display, eye) / display.pixel_angle)
    # A display that shows every pixel under the camera's own angle leaves the eye as it is.
    own = Display(1 / math.degrees(pixel))
    assert blur_widths(pixel, own, eye).eye == pytest.approx(eye_width(own, eye))


def test_an_ideal_eye_has_no_width():
    assert blur_widths(1e-3, Display(), None, 2e-5, 3e-5) == BlurWidths(1e-3, 0.0, 2e-5, 3e-5)


@pytest.mark.parametrize("name", ["eye", "atmosphere", "motion"])
@pytest.mark.parametrize("bad", [-1.0, math.nan, math.inf])
def test_bad_widths_are_refused(name, bad):
    with pytest.raises(InputError, match=name):
        BlurWidths(**{"pixel": 1e-3, name: bad})


def test_a_camera_without_pixels_is_refused():
    with pytest.raises(InputError, match="pixel"):
        BlurWidths(0.0)
