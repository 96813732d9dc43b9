"""Why priority is the root of an area: the width of an image's spectrum is 1/area (§2.2).

Let e(x, y) be an image over angles x, y, and E(u, v) = ∬ e·exp(−2πi(ux + vy)) dx dy its spectrum
(Bracewell, "The Fourier Transform and Its Applications", ch. 8 on equivalent width). At the
origins, E(0, 0) = ∬e dx dy and, by the inverse transform, e(0, 0) = ∬E du dv. The box that has the
spectrum's central height and its volume therefore covers ∬E du dv / E(0, 0) = e(0, 0) / ∬e dx dy.
It is a real width for a real and even image, whose spectrum is real; and where the image is
uniform, e = e(0, 0) over an area a and 0 elsewhere, it is **1/a**, whatever the shape.

So for a part of cross-section P² at distance d, whose image covers a = P²/d² steradians (P ≪ d),
the two-dimensional width is d²/P². It grows as d²: the receding figure spreads its spectrum (§2.1).
A display, an eye and the air pass frequencies up to some width 1/m², m the side of the smallest
resolved square; the part is kept while d²/P² < 1/m², which is **P > m·d**. The side of the square
of that area, the root of the cross-section, is then the one length that stands for a part, and the
largest cross-section over all directions keeps the part whichever way it turns: that is P (§2.4).
The paper takes the spectrum for circularly symmetric, so a stick counts for √(length × width).
"""

import math

import numpy as np
import pytest

from lod.metric import solid_angle

SAMPLES, PITCH = 512, 0.01
_AXIS = (np.arange(SAMPLES) - SAMPLES // 2) * PITCH
X, Y = np.meshgrid(_AXIS, _AXIS)


def spectral_width(image, pitch):
    """∬E du dv / E(0, 0) of an image with samples of side ``pitch``, by its discrete spectrum.

    The image's origin is its sample (height // 2, width // 2).
    """
    spectrum = np.fft.fft2(np.fft.ifftshift(image))
    return spectrum.sum().real / (image.size * pitch**2) / spectrum[0, 0].real


@pytest.mark.parametrize(("half_x", "half_y"), [(0.305, 0.305), (1.005, 0.105), (0.055, 2.005)])
def test_width_of_a_box_is_one_over_its_area(half_x, half_y):
    box = ((np.abs(X) < half_x) & (np.abs(Y) < half_y)).astype(float)
    assert spectral_width(box, PITCH) == pytest.approx(1 / (4 * half_x * half_y), rel=1e-9)


@pytest.mark.parametrize("half", [0.105, 0.405])
def test_the_cut_by_spectral_width_is_the_metric(half):
    """A square of side 2·half metres is cut where its width passes 1/m²: at P/m."""
    P, m = 2 * half, 0.01  # the root of the area
    square = ((np.abs(X) < half) & (np.abs(Y) < half)).astype(float)
    in_metres = spectral_width(square, PITCH)
    cut_at = math.sqrt(1 / (m**2 * in_metres))  # the width at distance d is d² times that
    assert cut_at == pytest.approx(solid_angle(np.array([P]), np.zeros(1), m)[0])
