"""Blur adds in quadrature: the widths of pixel, eye, atmosphere and motion, and their sum (§2.1).

The variance of a convolution is the sum of the variances (Bracewell, "The Fourier Transform and Its
Applications", ch. 8), so θ_eff² = θ_pixel² + θ_eye² + θ_atmosphere² + θ_motion² where each θ is a
full width √12·σ: that of the box with the same variance, so a box pixel has its own width. In
quadrature nothing has to be Gaussian; as a transfer function each blur is taken for the Gaussian of
its variance.
"""

import math
from dataclasses import dataclass, fields

import numpy as np

from lod.arrays import Reals
from lod.errors import InputError
from lod.vision.eye import Display, Eye, optical_sigma

FULL_WIDTH = math.sqrt(12.0)
"""Full width of a box over its standard deviation."""


@dataclass(frozen=True)
class BlurWidths:
    """Full widths √12·σ of the blurs between scene and viewer, as angles at the camera [rad].

    pixel       angle of one pixel: a box of that width, σ = θ/√12
    eye         the viewer's optics, carried to the camera by the display (``blur_widths``)
    atmosphere  seeing: the blur by turbulence of the air, in a long exposure
    motion      what passes by while the shutter is open: a box of angular speed × open time
    """

    pixel: float
    eye: float = 0.0
    atmosphere: float = 0.0
    motion: float = 0.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"width.{field.name}", value, "finite and at least 0 rad")
        if self.pixel == 0:
            raise InputError("width.pixel", self.pixel, "above 0 rad: a camera has pixels")

    @property
    def effective(self) -> float:
        """θ_eff [rad] is the root of the sum of the squares; m = τ·θ_eff."""
        return math.hypot(self.pixel, self.eye, self.atmosphere, self.motion)

    @property
    def before_eye(self) -> float:
        """θ_eff without the eye [rad]: the blur that light has when it reaches the eye."""
        return math.hypot(self.pixel, self.atmosphere, self.motion)


def blur_widths(
    pixel_angle: float,
    display: Display,
    eye: Eye | None,
    atmosphere: float = 0.0,
    motion: float = 0.0,
) -> BlurWidths:
    """Give the blurs of a camera whose picture is looked at on a display, at the camera [rad].

    The display shows a camera's pixel under an angle of its own. So the eye's width, an angle at
    the viewer, covers (eye width)/(display pixel) pixels, each of which is ``pixel_angle`` at the
    camera. An ideal eye (None) has no width.
    """
    seen = 0.0 if eye is None else eye_width(display, eye) * pixel_angle / display.pixel_angle
    return BlurWidths(pixel_angle, seen, atmosphere, motion)


def eye_width(display: Display, eye: Eye) -> float:
    """Compute the full width √12·σ_opt of the eye's optics, an angle at the viewer [rad].

    Barten's optical transfer function is exp(−2π²σ²f²), a Gaussian (1999, ch. 3).
    """
    return FULL_WIDTH * math.radians(optical_sigma(display, eye))


def gaussian_transfer(width: float, frequency: Reals) -> Reals:
    """Compute the share of a sinusoid's contrast that a blur leaves, (n,).

    It is exp(−2π²σ²f²) with σ = width/√12, the Fourier transform of a Gaussian. ``width`` and
    1/``frequency`` are in the same unit.
    """
    return np.exp(-((math.pi * width * frequency) ** 2) / 6)
