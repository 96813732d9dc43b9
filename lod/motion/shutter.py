"""What motion hides: the blur of an open shutter, and the detail that it leaves (§5.2, §2.1).

The paper leaves the metric of motion to the future; its own argument joins it to the spatial one.
Variances of successive blurs add (Bracewell, ch. 8). What passes by an angle L while the shutter is
open is convolved with a box of that full width, along its path alone, and a part of size s and
contrast C is then spread over √(s² + θ²) across it and √(s² + θ² + L²) along, θ that of all other
blurs. Its contrast falls by so much and its area grows by so much; what counts is the square of the
contrast over the area, the error that leaving it out makes (Parseval: its energy, in frequencies):

    E = C²s⁴/(√(s² + θ²)·√(s² + θ² + L²)),    m grows by the g of E(g·θ, L) = E(θ, 0) = C²θ²/2,
    L²/θ² = 4g⁸/(g² + 1) − (g² + 1),          which is g = (L/2θ)^⅓ where L is long.

A part as large as its blurred area √(θ·√(θ² + L²)) is too much to leave out: g = (L/θ)^½ makes an
error that grows with L, because a part of that size has lost contrast and not its area (the
experiment ``motion`` has its planted cut about there). Even parts are meant: a pole along the pan
keeps more of its contrast, one across it less.
The growth g of m is measured on a scale with STEPS_PER_OCTAVE steps to each octave.

L is one for a whole object: the least that anything of it moves (``lod.motion.image_motion``).

A camera can stop between two frames, and all that its motion hid would come at once. So what is
hidden eases: from one frame to the next the scale goes by EASE at most,

    step(f) = min over k of own(f + k) + EASE·|k|,

the largest such that is never more than the frame's own. The path of a camera is known ahead:
detail comes back before the motion ends, and goes after it has begun. At rest it is 0, and where
all frames are alike it is their own.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lod.arrays import Reals
from lod.camera import Camera

STEPS_PER_OCTAVE = 8
"""Steps of the motion scale to each doubling of m."""

EASE_PER_FRAME = 0.5
"""Greatest difference between two frames in steps: 4 % of D, a fifth of a fade band."""

MAX_NEIGHBOURS = 48
"""Most frames before and after that count: farther ones matter only where L > 1100 θ."""


@dataclass(frozen=True, eq=False)
class ShutterInterval:
    """The interval in which the shutter is open: the camera at both ends, and their times [s].

    opening, closing  the camera as the shutter opens, and as it closes
    open_s, close_s   the times of both [s]
    neighbour         function from a number of frames to the interval that many frames later
                      (earlier where it is negative); None = motion hiding is not eased
    """

    opening: Camera
    closing: Camera
    open_s: float
    close_s: float
    neighbour: Callable[[int], "ShutterInterval"] | None = None

    @property
    def duration_s(self) -> float:
        """Compute how long the shutter is open [s]."""
        return self.close_s - self.open_s


def motion_coarsening(motion_step: float) -> float:
    """Compute the factor by which m grows at a place on the motion scale: 1 at place 0."""
    return float(2.0 ** (motion_step / STEPS_PER_OCTAVE))


def subframe_offsets(subframes: int) -> Reals:
    """Compute the middles of equal shares of a shutter interval, from its own middle, (n,)."""
    return (np.arange(subframes) + 0.5) / subframes - 0.5
