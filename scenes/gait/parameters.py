"""The parameters of a gait, as files of animals give them under ``gait``: legs, waves and spins.

Lengths are shares of h, the height of the first leg's hip at rest. Speed and stride are those of
dynamically similar animals: speed² = Froude·g·h, and stride = 2.3·h·Froude^0.3 (Alexander,
"Estimates of speeds of dinosaurs", Nature 261:129, 1976; for people from four years on, the same
author, Am. J. Phys. Anthropol. 63:23, 1984).
"""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from scenes.model_files.read import CLOSED

Axis = Literal["x", "y", "z"]
AXES: tuple[Axis, ...] = ("x", "y", "z")

GRAVITY = 9.81
"""Acceleration of free fall [m/s²]."""


@dataclass(frozen=True)
class Leg:
    """A pair of legs: joints without their side, phases of the left one, lengths [shares of h].

    strike, apart  phase at which the foot lands; how much later the right one does
    pitch    (phase after landing, degrees) of the foot to the ground, toes up above 0
    ahead, spread  where the foot stands in mid-stance, ahead of the hip and aside of the middle;
        without spread, where it rests, and ahead of that
    bend     +1: a positive angle about y flexes the knee; −1 for elbows that point back
    toes     joints that stay flat on the ground while the foot rises; ``flat_toes``: at any
        pitch
    sticks_out  the hip turns about z towards the foot, not about x (insects)
    """

    __pydantic_config__ = CLOSED

    hip: str
    knee: str
    ankle: str
    pitch: tuple[tuple[float, float], ...] = ((0.0, 0.0), (0.5, 0.0))
    toes: tuple[str, ...] = ()
    strike: float = 0.0
    apart: float = 0.5
    ahead: float = 0.0
    spread: float | None = None
    turnout: float = 0.0
    bend: int = 1
    clearance: float = 0.03
    sticks_out: bool = False
    flat_toes: bool = False
    curl: float = 0.0


@dataclass(frozen=True)
class Wave:
    """One joint's swing about one axis: mean + amplitude·cos 2π(cycles·phase − peak) [degrees].

    Added to the angle at rest where ``mean`` is None. Of joints on both sides this is the left
    one; the right one is its mirror image, ``apart`` of a cycle later. Joint "" bobs and sways the
    whole [shares of h].
    """

    __pydantic_config__ = CLOSED

    joint: str
    axis: Axis
    amplitude: float
    peak: float = 0.0
    cycles: int = 1
    mean: float | None = None
    apart: float = 0.5


@dataclass(frozen=True)
class Spin:
    """A joint that goes round: whole rounds about an axis in one cycle."""

    __pydantic_config__ = CLOSED

    joint: str
    axis: Axis
    rounds: int


@dataclass(frozen=True)
class Gait:
    """How one kind of object moves.

    duty    share of the cycle that a foot stands; froude: speed²/(g·h)
    stride  ground covered in a cycle [shares of h], and period [s]: instead of what ``froude``
        gives
    steepest  slope of the ground that its feet follow; tilts: as in Motion
    """

    __pydantic_config__ = CLOSED

    legs: tuple[Leg, ...] = ()
    waves: tuple[Wave, ...] = ()
    spins: tuple[Spin, ...] = ()
    duty: Annotated[float, Field(gt=0, le=1)] = 0.62
    froude: Annotated[float, Field(gt=0)] = 0.22
    stride: Annotated[float, Field(ge=0)] | None = None
    period: Annotated[float, Field(gt=0)] | None = None
    steepest: Annotated[float, Field(ge=0)] = 0.3
    tilts: bool = False

    def stride_m(self, height: float) -> float:
        """Return the ground covered in one cycle, by what stands ``height`` tall at the hip [m]."""
        relative = 2.3 * self.froude**0.3 if self.stride is None else self.stride
        return relative * height

    def period_s(self, height: float) -> float:
        """Return the duration of one cycle [s]."""
        if self.period is not None:
            return self.period
        return self.stride_m(height) / math.sqrt(self.froude * GRAVITY * height)
