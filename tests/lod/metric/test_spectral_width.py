import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import j1

from lod.errors import InputError
from lod.metric.family import solid_angle
from lod.metric.spectral_width import priority_from_area, spectral_width

SAMPLES, PITCH = 512, 0.01
_AXIS = (np.arange(SAMPLES) - SAMPLES // 2) * PITCH
X, Y = np.meshgrid(_AXIS, _AXIS)


@pytest.mark.parametrize(("half_x", "half_y"), [(0.305, 0.305), (1.005, 0.105), (0.055, 2.005)])
def test_width_of_a_box_is_one_over_its_area(half_x, half_y):
    box = ((np.abs(X) < half_x) & (np.abs(Y) < half_y)).astype(float)
    assert spectral_width(box, PITCH) == pytest.approx(1 / (4 * half_x * half_y), rel=1e-9)


@pytest.mark.parametrize("radius", [0.2, 0.5, 1.0, 2.0])
def test_width_of_a_disc_is_one_over_its_area(radius):
    disc = (np.hypot(X, Y) < radius).astype(float)
    assert spectral_width(disc, PITCH) == pytest.approx(1 / (math.pi * radius**2), rel=0.02)


@pytest.mark.parametrize("radius", [0.2, 1.0, 3.0])
def test_width_of_a_disc_from_its_analytic_spectrum(radius):
    """E(k) = r·J₁(2πkr)/k; its volume, summed with a factor exp(−εk) that is let go to 0."""

    def volume(damping):
        def ring(k):
            return 2 * math.pi * radius * j1(2 * math.pi * k * radius) * math.exp(-damping * k)

        end = 40 / damping
        steps = np.linspace(0, end, 200)
        return sum(quad(ring, a, b, limit=200)[0] for a, b in pairwise(steps))

    damping = 0.02 * radius
    width = volume(damping) / (math.pi * radius**2)
    assert width == pytest.approx(1 / (math.pi * radius**2), rel=1e-2)


def test_width_of_a_gaussian_by_hand():
    """Not uniform: e(0, 0)/∬e = 1/(2πσ²)."""
    sigma = 0.3
    assert spectral_width(np.exp(-(X**2 + Y**2) / (2 * sigma**2)), PITCH) == pytest.approx(
        1 / (2 * math.pi * sigma**2), rel=1e-9
    )


def test_the_brightness_does_not_matter():
    disc = (np.hypot(X, Y) < 1).astype(float)
    assert spectral_width(7 * disc, PITCH) == pytest.approx(spectral_width(disc, PITCH))


def test_the_receding_figure_spreads_its_spectrum():
    """At twice the distance the image is half as large, and its spectrum four times as wide."""
    near, far = ((np.hypot(X, Y) < r).astype(float) for r in (2.0, 1.0))
    assert spectral_width(far, PITCH) / spectral_width(near, PITCH) == pytest.approx(4, rel=0.01)


@pytest.mark.parametrize("half", [0.105, 0.405])
def test_the_cut_by_spectral_width_is_the_metric(half):
    """A square of side 2·half metres is cut where its width passes 1/m²: at P/m."""
    P, m = priority_from_area(4 * half**2), 0.01
    square = ((np.abs(X) < half) & (np.abs(Y) < half)).astype(float)
    in_metres = spectral_width(square, PITCH)
    cut_at = math.sqrt(1 / (m**2 * in_metres))  # the width at distance d is d² times that
    assert cut_at == pytest.approx(solid_angle(np.array([P]), np.zeros(1), m)[0])


@pytest.mark.parametrize(("image", "pitch"), [(np.zeros((4, 4)), 1.0), (np.ones((4, 4)), 0.0)])
def test_what_has_no_width_is_refused(image, pitch):
    with pytest.raises(InputError):
        spectral_width(image, pitch)


@pytest.mark.parametrize("area", [0.0, -1.0, math.nan, math.inf])
def test_bad_areas_are_refused(area):
    with pytest.raises(InputError, match="area"):
        priority_from_area(area)
