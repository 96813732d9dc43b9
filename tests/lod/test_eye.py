"""The eye is Barten's; no air leaves more than the inherent contrast says."""

import math

import numpy as np
import pytest
from colour.contrast import (
    optical_MTF_Barten1999,
)
from hypothesis import given
from hypothesis import strategies as st

from lod.eye import (
    CONTRAST_CLASSES,
    SQUARE_WAVE_GAIN,
    Display,
    Eye,
    contrast_class,
    envelope,
    inherent_contrast,
    optical_sigma,
    sensitivity,
)

DISPLAYS = st.builds(Display, st.floats(20, 120), st.floats(0.1, 1000), st.floats(5, 100))
EYES = st.builds(Eye, st.floats(0.2, 2), st.floats(0, 0.2), st.floats(1, 6))


@given(display=DISPLAYS, eye=EYES)
def test_envelope_never_rises_and_keeps_the_peak(display, eye):
    table = sensitivity(display, eye)
    seen = envelope(table.value)
    assert (np.diff(seen) <= 0).all()
    assert seen[0] == pytest.approx(table.value.max())
    assert (envelope(table.value) >= table.value).all()
    assert (table.value[0] < table.value.max()).all()  # band-pass: there is something to fill


def test_standard_observer_sees_a_tenth_of_a_percent_at_best():
    """Barten (1999) at 100 cd/m²: best near 2.5 cycles/degree, a sensitivity of several hundred."""
    table = sensitivity(Display(), Eye())
    assert 2 < table.frequency[table.value.argmax()] < 4
    assert 600 < table.value.max() / SQUARE_WAVE_GAIN < 850
    assert 40 < table.frequency[np.flatnonzero(table.value > 1)[-1]] < 65


@given(display=DISPLAYS, eye=EYES)
def test_no_contrast_survives_the_end_of_the_table(display, eye):
    table = sensitivity(display, eye)
    assert table.value[-1] < 0.01
    faded = optical_MTF_Barten1999(table.frequency[-1], optical_sigma(display, eye))
    assert faded == pytest.approx(1e-6)


@given(eye=EYES, dim=st.floats(0.1, 500))
def test_more_light_shows_more(eye, dim):
    dark, bright = (sensitivity(Display(luminance=L), eye).value.max() for L in (dim, 2 * dim))
    assert bright > dark


def test_bars_are_seen_better_than_a_sinusoid():
    """The first Fourier term of a square wave between −1 and 1."""
    x = (np.arange(4096) + 0.5) / 4096
    square = np.sign(np.sin(2 * np.pi * x))
    assert 2 * np.mean(square * np.sin(2 * np.pi * x)) == pytest.approx(SQUARE_WAVE_GAIN, rel=1e-6)


LUMINANCE = st.floats(0, 1e4)


def one(*values):
    return [np.array([float(v)]) for v in values]


@pytest.mark.parametrize(
    ("Y", "Y_b", "A", "contrast"),
    [(1, 3, math.inf, 0.5), (3, 1, math.inf, 0.5), (0, 5, 9, 1.0), (7, 7, 1, 0), (6, 2, 1, 2.0)],
)
def test_inherent_contrast_by_hand(Y, Y_b, A, contrast):
    assert inherent_contrast(*one(Y, Y_b, A)) == pytest.approx([contrast])


@given(Y=LUMINANCE, Y_b=LUMINANCE, A=st.floats(1e-3, 1e4), depth=st.floats(0, 20))
def test_no_air_leaves_more_than_the_inherent_contrast_says(Y, Y_b, A, depth):
    T = math.exp(-depth)
    part, ground = (x * T + A * (1 - T) for x in (Y, Y_b))
    total = part + ground
    modulation = abs(part - ground) / total if total else 0.0
    assert modulation <= inherent_contrast(*one(Y, Y_b, A))[0] * T * (1 + 1e-9) + 1e-12


@given(contrast=st.floats(0, 10))
def test_classes_round_up(contrast):
    row = int(contrast_class(np.array([contrast]))[0])
    assert contrast <= CONTRAST_CLASSES[row]
    assert row == 0 or contrast > CONTRAST_CLASSES[row - 1]
