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

import numpy as np
from jaxtyping import Float64

from lod.errors import InputError

Image = Float64[np.ndarray, "height width"]


def spectral_width(image: Image, pitch: float) -> float:
    """∬E du dv / E(0, 0) of a sampled image, by its discrete spectrum (§2.2).

    ``pitch`` is the side of a sample; the answer is in 1/pitch². The image's origin is its sample
    (height // 2, width // 2). Raises InputError for an image that has no mean.
    """
    if not (np.isfinite(pitch) and pitch > 0):
        raise InputError("pitch", pitch, "finite and above 0")
    # In units of pitch²: it cancels in the ratio.
    spectrum = np.fft.fft2(np.fft.ifftshift(image))
    central = spectrum[0, 0].real
    if not (np.isfinite(central) and central != 0):
        raise InputError("image", float(central), "its integral is finite and not 0")
    cell = 1 / (image.size * pitch**2)
    return float(spectrum.sum().real * cell / central)


def priority_from_area(area: float) -> float:
    """P = √(largest cross-section of the leaf appearance) [m] (§2.4)."""
    if not (np.isfinite(area) and area > 0):
        raise InputError("area", area, "finite and above 0 m²")
    return float(np.sqrt(area))
