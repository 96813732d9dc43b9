"""The relief of an endless plain: fractional Brownian heights, as exact at 10^12 m as at home.

Octave k has wavelength λ_k = wavelength·2^-k and RMS a_k ∝ 2^(-H·k), so that heights r apart
differ by about r^H between the shortest wavelength and the longest (Mandelbrot & Van Ness 1968,
"Fractional Brownian motions"; summed over octaves as in Musgrave, Kolb & Mace 1989, "The synthesis
and rendering of eroded fractal terrains"). Lattices have sides of powers of two and are indexed by
integers, so no absolute coordinate is ever a float.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import Points, Reals
from lod.camera import Corner
from lod.errors import InputError
from scenes.terrain_noise import (
    BOUND,
    RIDGED_MEAN,
    RIDGED_RMS,
    STEEPEST,
    Octaves,
    octave_sums,
    octaves_at,
    unit_rms,
)

SHORTEST_M = 0.25
"""Wavelength of the last octave: what is smaller is no relief but grass."""

_STREAM = 0x52454C494546
"""Tells the relief's random numbers from those of anything else with the same seed."""


@dataclass(frozen=True)
class Relief:
    """Heights above the datum.

    amplitude   RMS of the relief [m]; 0 = perfectly flat, z = 0
    wavelength  longest wavelength [m], a power of two from 1 m up
    hurst       H in (0, 1]: the larger, the smoother the small relief beside the large
    ridged      octaves have crests where the noise crosses 0, as 1 − |noise| has (Musgrave, in
                Ebert et al. 2003, *Texturing & Modeling*, ch. 16)
    """

    seed: int
    amplitude: float
    wavelength: float
    hurst: float
    ridged: bool = False

    def __post_init__(self) -> None:
        if not (math.isfinite(self.amplitude) and self.amplitude >= 0):
            raise InputError("terrain.amplitude", self.amplitude, "finite, at least 0 m", "try 30")
        if not 0 < self.hurst <= 1:
            raise InputError("terrain.hurst", self.hurst, "above 0, at most 1", "try 0.95")
        if not (math.isfinite(self.wavelength) and 1 <= self.wavelength <= 2**24):
            raise InputError("terrain.wavelength", self.wavelength, "1 m to 2^24 m", "try 2048")
        if 2 ** round(math.log2(self.wavelength)) != self.wavelength:
            nearest = 2 ** round(math.log2(self.wavelength))
            raise InputError(
                "terrain.wavelength", self.wavelength, "a power of two [m]", f"try {nearest}"
            )

    @property
    def exponents(self) -> range:
        """log₂ of each octave's wavelength in metres, longest first."""
        return range(round(math.log2(self.wavelength)), round(math.log2(SHORTEST_M)) - 1, -1)

    @property
    def wavelengths(self) -> Reals:
        """Wavelength of each octave, longest first, (k,) [m]."""
        return 2.0 ** np.array(self.exponents, np.float64)

    @property
    def rms(self) -> Reals:
        """RMS height of each octave, (k,) [m]; their squares add up to amplitude²."""
        share = 2.0 ** (-self.hurst * np.arange(len(self.exponents)))
        return self.amplitude * share / math.sqrt(np.sum(share**2))

    @property
    def unit(self) -> float:
        """RMS of unit noise, or of its crests; those too are never beyond BOUND and STEEPEST."""
        return RIDGED_RMS if self.ridged else unit_rms()

    @property
    def crest(self) -> float:
        """Mean of the crests' |noise|; 0 where there are none."""
        return RIDGED_MEAN if self.ridged else 0.0

    def bounds(self) -> tuple[float, float]:
        """Heights that no point of the relief is beyond [m]."""
        highest = self.bound_below(math.inf)
        return -highest, highest

    def bound_below(self, wavelength: float) -> float:
        """Height that the octaves shorter than ``wavelength`` together never exceed [m]."""
        return BOUND / self.unit * float(np.sum(self.rms[self.wavelengths < wavelength]))

    def within(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], radius: Reals
    ) -> tuple[Reals, Reals]:
        """Heights that the ground within ``radius`` of each point is not beyond, (n,) each [m].

        An octave leaves its height at the point by at most its steepest slope × radius; one so
        short that its bound is less than that is left out, and its bound taken instead.
        """
        highest = BOUND / self.unit * self.rms
        steepest = STEEPEST / self.unit * self.rms / self.wavelengths
        most = np.minimum(highest, steepest * radius[:, None]).sum(axis=1)
        if self.amplitude == 0:
            return -most, most
        # Sides are powers of two: rounded up, it leaves out just the octaves shorter than it.
        shortest = 2.0 ** np.ceil(np.log2(STEEPEST / BOUND * radius))
        height = octave_sums(_octaves(self, corner), xy, shortest, True, self.crest)[:, 0]
        return height - most, height + most

    def height(self, corner: Corner, xy: Float64[np.ndarray, "n 2"]) -> Reals:
        """Height above the datum of points ``xy`` from ``corner`` [m]."""
        return self.sums(corner, xy, np.full(len(xy), np.inf))[:, 0]

    def normal(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals | None = None
    ) -> Points:
        """Unit normals; given ``shortest``, without the octaves shorter than it at each point."""
        return normals(self.sums(corner, xy, np.zeros(len(xy)) if shortest is None else shortest))

    def sums(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals
    ) -> Float64[np.ndarray, "n 3"]:
        """Full height [m], and its two slopes without octaves shorter than ``shortest``, (n, 3)."""
        if self.amplitude == 0:
            return np.zeros((len(xy), 3))
        return octave_sums(_octaves(self, corner), xy, shortest, crest=self.crest)


def normals(sums: Float64[np.ndarray, "n 3"]) -> Points:
    """Upward unit normals of a surface with slopes ``sums[:, 1:]``."""
    up = np.stack((-sums[:, 1], -sums[:, 2], np.ones(len(sums))), axis=1)
    return up / np.linalg.norm(up, axis=1, keepdims=True)


@lru_cache(maxsize=64)
def _octaves(relief: Relief, corner: Corner) -> Octaves:
    return octaves_at(corner, relief.seed ^ _STREAM, relief.exponents, relief.rms / relief.unit)
