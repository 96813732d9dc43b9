"""Fractal relief of an endless plain: fractional Brownian heights, exact at 10^12 m from home.

Octave k has wavelength λ_k = wavelength·2^-k and RMS a_k ∝ 2^(-H·k), so that
heights r apart differ by about r^H between the shortest wavelength and the longest (Mandelbrot &
Van Ness 1968, "Fractional Brownian motions"; summed over octaves as in Musgrave, Kolb & Mace 1989,
"The synthesis and rendering of eroded fractal terrains"). Lattices are indexed by integers and
their sides are whole multiples of a 1024th of a metre, so no absolute coordinate is ever a float.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Protocol, runtime_checkable

import numpy as np
from jaxtyping import Float64

from lod.arrays import Reals, frozen
from lod.camera import STEP_M, Corner
from lod.kernels import njit
from scenes.noise import (
    NOISE_BOUND,
    NOISE_MAX_SLOPE,
    RIDGED_MEAN,
    RIDGED_RMS,
    Octaves,
    height_slack,
    left_out_variance,
    octave_slopes,
    octave_values,
    octaves_at,
    unit_rms,
    unit_slope_variance,
)


@runtime_checkable
class Ground(Protocol):
    """A height field that objects, plumes and cameras stand on."""

    def height(self, corner: Corner, xy: np.ndarray) -> np.ndarray:
        """Height of the ground [m] at points (n, 2) [m] from the corner, (n,)."""

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest that the ground can be anywhere [m]."""


SHORTEST_M = 0.25  # wavelength of the last octave; smaller bumps count as grass [m]
LIKELY_RMS = 4.0  # how many times its RMS a sum of octaves rarely is away from its mean

_STREAM = 0x52454C494546
"""Word by which the relief's random numbers differ from others of the same seed."""


@dataclass(frozen=True)
class Relief:
    """Heights of the ground above the datum, a sum of octaves of noise.

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

    @cached_property
    def wavelengths(self) -> Reals:
        """Wavelength of each octave, longest first, (k,) [m]: whole multiples of STEP_M."""
        octaves = math.floor(math.log2(self.wavelength / SHORTEST_M) + 1e-9)
        sides = self.wavelength / 2.0 ** np.arange(octaves + 1)
        return frozen(np.rint(sides / STEP_M) * STEP_M, np.float64)

    @cached_property
    def rms(self) -> Reals:
        """RMS height of each octave, (k,) [m]; their squares add up to amplitude²."""
        share = 2.0 ** (-self.hurst * np.arange(len(self.wavelengths)))
        return frozen(self.amplitude * share / math.sqrt(np.sum(share**2)), np.float64)

    @property
    def unit(self) -> float:
        """RMS of unit noise, or of its crests.

        Crests too are never beyond NOISE_BOUND and NOISE_MAX_SLOPE.
        """
        return RIDGED_RMS if self.ridged else unit_rms()

    @property
    def crest(self) -> float:
        """Mean of the crests' |noise|; 0 where there are none."""
        return RIDGED_MEAN if self.ridged else 0.0

    @property
    def bump(self) -> float:
        """Height of an octave's bumps over its RMS.

        A crest stands above the mean by its mean |noise|, and is so sharp that a coarser mesh cuts
        it off.
        """
        return self.crest / self.unit if self.ridged else 1.0

    @cached_property
    def slope_variances(self) -> Reals:
        """Variance of each octave's slope along an axis, (k,)."""
        steepness = self.rms / self.unit / self.wavelengths
        return frozen(unit_slope_variance() * steepness**2, np.float64)

    def left_out_slope_variance(self, shortest: Reals) -> Reals:
        """Variance along an axis of the slopes that ``slopes`` leaves out, (n,)."""
        return np.asarray(left_out_variance(shortest, self.wavelengths, self.slope_variances))

    def bounds(self) -> tuple[float, float]:
        """Lowest and highest that the relief can be anywhere [m]."""
        highest = NOISE_BOUND / self.unit * float(np.sum(self.rms))
        return -highest, highest

    def rms_between(self, shortest: float, longest: float) -> float:
        """RMS height of the octaves from ``shortest`` up to below ``longest`` [m]."""
        of_them = (self.wavelengths >= shortest) & (self.wavelengths < longest)
        return math.sqrt(float(np.sum(self.rms[of_them] ** 2)))

    def likely_below(self, wavelength: Reals) -> Reals:
        """Height that the octaves shorter than each wavelength rarely exceed, (n,) [m].

        It is LIKELY_RMS times their RMS; octaves are independent, so that their squares add.
        """
        shorter = self.wavelengths < np.asarray(wavelength)[:, None]
        return LIKELY_RMS * np.sqrt(np.where(shorter, self.rms**2, 0.0).sum(axis=1))

    def height_bounds(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], radius: Reals
    ) -> tuple[Reals, Reals]:
        """Lowest and highest that the ground within circles can be, (n,) each [m].

        An octave so short that its bound is less than its steepest slope × radius is left out.
        """
        if self.amplitude == 0:
            return np.zeros(len(xy)), np.zeros(len(xy))
        highest = NOISE_BOUND / self.unit * self.rms
        steepest = NOISE_MAX_SLOPE / self.unit * self.rms / self.wavelengths
        shortest = _shortest_relevant(radius)
        most = height_slack(radius, shortest, self.wavelengths, highest, steepest)
        height = self.low_pass_height(corner, xy, shortest)
        return height - most, height + most

    def likely_rise_within(self, radius: Reals) -> Reals:
        """Height above the middle of its bounds that ground in circles rarely exceeds, (n,) [m]."""
        return self.likely_below(_shortest_relevant(radius))

    def height(self, corner: Corner, xy: Float64[np.ndarray, "n 2"]) -> Reals:
        """Height above the datum of points ``xy`` from ``corner`` [m]."""
        return self.low_pass_height(corner, xy, np.zeros(len(xy)))

    def low_pass_height(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals
    ) -> Reals:
        """Height of the octaves that are no shorter than ``shortest`` at each point, (n,) [m]."""
        if self.amplitude == 0:
            return np.zeros(len(xy))
        return octave_values(_octaves(self, corner), xy, shortest, self.crest)

    def slopes(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Float64[np.ndarray, "n ..."]
    ) -> Float64[np.ndarray, "n _"]:
        """Slopes along x and y without octaves shorter than ``shortest`` at each point, (n, 2).

        Given several columns of ``shortest``, two for each of them, (n, 2k).
        """
        least = shortest if shortest.ndim == 2 else shortest[:, None]
        if self.amplitude == 0:
            return np.zeros((len(xy), 2 * least.shape[1]))
        return octave_slopes(_octaves(self, corner), xy, least, self.crest)


def _shortest_relevant(radius: Reals) -> Reals:
    """Wavelengths below which an octave's bound is less than its steepest slope × radius [m]."""
    return np.asarray(2.0 ** np.ceil(np.log2(NOISE_MAX_SLOPE / NOISE_BOUND * radius)))


@njit(cache=True, nogil=True)
def unit_normals(slopes: np.ndarray) -> np.ndarray:
    """Upward unit normals of a surface with these slopes (n, 2) along x and y, (n, 3)."""
    up = np.empty((len(slopes), 3))
    for i in range(len(slopes)):
        x, y = -slopes[i, 0], -slopes[i, 1]
        length = math.sqrt(x * x + y * y + 1.0)
        up[i, 0], up[i, 1], up[i, 2] = x / length, y / length, 1.0 / length
    return up


@lru_cache(maxsize=64)
def _octaves(relief: Relief, corner: Corner) -> Octaves:
    return octaves_at(corner, relief.seed ^ _STREAM, relief.wavelengths, relief.rms / relief.unit)
