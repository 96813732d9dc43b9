"""What motion hides: the blur of an open shutter, and the detail that it leaves (§5.2, §2.1).

The paper leaves the metric of motion to the future; its own argument joins it to the spatial one.
Variances of successive blurs add (Bracewell, ch. 8), and what passes by an angle L while the
shutter is open is convolved with a box of that full width, along its path alone:

    θ_along² = θ² + L²,    θ_across = θ,    m = τ·√(θ_along·θ_across) = τ·θ·(1 + (L/θ)²)^¼,

θ that of all other blurs: what limits an area is the geometric mean, so a pole along a pan stays as
fine as it was across it, and θ_motion of the cascade is the even blur of the same area. The growth
(1 + (L/θ)²)^¼ of m is told on a scale of STEPS to each octave.

L is one for a whole object: the least that anything of it moves (``lod.smear``).
"""

from dataclasses import dataclass

from lod.camera import Camera

STEPS = 8
"""Steps of the scale of smears to each doubling of m."""


@dataclass(frozen=True, eq=False)
class Exposure:
    """While the shutter is open: the camera as it opens and as it closes, and when [s]."""

    opens: Camera
    closes: Camera
    opens_s: float
    closes_s: float

    @property
    def seconds(self) -> float:
        """How long the shutter is open [s]."""
        return self.closes_s - self.opens_s


def growth(smear: float) -> float:
    """How much m grows at a place on the scale of smears, from 0: a factor, 1 or more."""
    return float(2.0 ** (smear / STEPS))
