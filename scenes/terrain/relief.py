"""The relief of an endless plain: fractional Brownian heights, as exact at 10^12 m as at home.

Octave k has wavelength λ_k = wavelength·l^-k and RMS a_k ∝ l^(-H·k), l the lacunarity, so that
heights r apart differ by about r^H between the shortest wavelength and the longest (Mandelbrot &
Van Ness 1968, "Fractional Brownian motions"; summed over octaves as in Musgrave, Kolb & Mace 1989,
"The synthesis and rendering of eroded fractal terrains"). Lattices are indexed by integers and
their sides are whole multiples of a 1024th of a metre, so no absolute coordinate is ever a float.
"""

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from jaxtyping import Float64
from numba import njit

from lod.arrays import Points, Reals, frozen
from lod.camera import STEP_M, Corner
from lod.errors import InputError
from scenes.noise.lattice import NOISE_BOUND, NOISE_MAX_SLOPE, RIDGED_MEAN, RIDGED_RMS, unit_rms
from scenes.noise.octaves import Octaves, height_slack, octave_slopes, octave_values, octaves_at

SHORTEST_M = 0.25
"""Wavelength of the last octave: what is smaller is no relief but grass."""

LIKELY_RMS = 4.0
"""Times its RMS a sum of octaves is hardly anywhere further from its mean."""

_STREAM = 0x52454C494546
"""Tells the relief's random numbers from those of anything else with the same seed."""


@dataclass(frozen=True)
class Relief:
    """Heights above the datum.

    amplitude   RMS of the relief [m]; 0 = perfectly flat, z = 0
    wavelength  longest wavelength [m], a power of two from 1 m up
    hurst       H in (0, 1]: the larger, the smoother the small relief beside the large
    lacunarity  by how much each octave's wavelength is shorter than the one before, 1.5 to 4
    ridged      octaves have crests where the noise crosses 0, as 1 − |noise| has (Musgrave, in
                Ebert et al. 2003, *Texturing & Modeling*, ch. 16)
    """

    seed: int
    amplitude: float
    wavelength: float
    hurst: float
    ridged: bool = False
    lacunarity: float = 2.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.amplitude) and self.amplitude >= 0):
            raise InputError("terrain.amplitude", self.amplitude, "finite, at least 0 m", "try 30")
        if not 0 < self.hurst <= 1:
            raise InputError("terrain.hurst", self.hurst, "above 0, at most 1", "try 0.95")
        if not 1.5 <= self.lacunarity <= 4:
            raise InputError("terrain.lacunarity", self.lacunarity, "from 1.5 to 4", "try 2")
        if not (math.isfinite(self.wavelength) and 1 <= self.wavelength <= 2**24):
            raise InputError("terrain.wavelength", self.wavelength, "1 m to 2^24 m", "try 2048")
        if 2 ** round(math.log2(self.wavelength)) != self.wavelength:
            nearest = 2 ** round(math.log2(self.wavelength))
            raise InputError(
                "terrain.wavelength", self.wavelength, "a power of two [m]", f"try {nearest}"
            )

    @cached_property
    def wavelengths(self) -> Reals:
        """Wavelength of each octave, longest first, (k,) [m]: whole multiples of STEP_M."""
        octaves = math.log(self.wavelength / SHORTEST_M, self.lacunarity)
        sides = self.wavelength / self.lacunarity ** np.arange(math.floor(octaves + 1e-9) + 1)
        return frozen(np.rint(sides / STEP_M) * STEP_M, np.float64)

    @cached_property
    def rms(self) -> Reals:
        """RMS height of each octave, (k,) [m]; their squares add up to amplitude²."""
        share = self.lacunarity ** (-self.hurst * np.arange(len(self.wavelengths)))
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
        """Height of an octave's bumps beside its RMS: a crest stands by its mean |noise| above it,
        and is as sharp as a coarser mesh is sure to cut off."""
        return self.crest / self.unit if self.ridged else 1.0

    def bounds(self) -> tuple[float, float]:
        """Heights that no point of the relief is beyond [m]."""
        highest = self.bound_below(math.inf)
        return -highest, highest

    def bound_below(self, wavelength: float) -> float:
        """Height that the octaves shorter than ``wavelength`` together never exceed [m]."""
        return NOISE_BOUND / self.unit * float(np.sum(self.rms[self.wavelengths < wavelength]))

    def rms_between(self, shortest: float, longest: float) -> float:
        """RMS height of the octaves from ``shortest`` up to below ``longest`` [m]."""
        of_them = (self.wavelengths >= shortest) & (self.wavelengths < longest)
        return math.sqrt(float(np.sum(self.rms[of_them] ** 2)))

    def likely_below(self, wavelength: Reals) -> Reals:
        """Height that the octaves shorter than each wavelength rarely exceed, (n,) [m]: 4 RMS, and
        as they are independent it is their squares that add."""
        shorter = self.wavelengths < np.asarray(wavelength)[:, None]
        return LIKELY_RMS * np.sqrt(np.where(shorter, self.rms**2, 0.0).sum(axis=1))

    def height_bounds(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], radius: Reals
    ) -> tuple[Reals, Reals]:
        """Heights that the ground within ``radius`` of each point is not beyond, (n,) each [m].

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
        """How much higher the ground within ``radius`` of a point rarely is than the middle of what
        ``height_bounds`` says of it, (n,) [m]."""
        return self.likely_below(_shortest_relevant(radius))

    def height(self, corner: Corner, xy: Float64[np.ndarray, "n 2"]) -> Reals:
        """Height above the datum of points ``xy`` from ``corner`` [m]."""
        return self.low_pass_height(corner, xy, np.zeros(len(xy)))

    def low_pass_height(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals
    ) -> Reals:
        """Height without the octaves shorter than ``shortest`` at each point, (n,) [m]."""
        if self.amplitude == 0:
            return np.zeros(len(xy))
        return octave_values(_octaves(self, corner), xy, shortest, self.crest)

    def normal(
        self, corner: Corner, xy: Float64[np.ndarray, "n 2"], shortest: Reals | None = None
    ) -> Points:
        """Unit normals; given ``shortest``, without the octaves shorter than it at each point."""
        return unit_normals(
            self.slopes(corner, xy, np.zeros(len(xy)) if shortest is None else shortest)
        )

    def slopes(
        self,
        corner: Corner,
        xy: Float64[np.ndarray, "n 2"],
        shortest: Float64[np.ndarray, "n ..."],
    ) -> Float64[np.ndarray, "n _"]:
        """Two slopes without the octaves shorter than ``shortest`` at each point, (n, 2).

        Given several columns of ``shortest``, two for each of them, (n, 2k).
        """
        least = shortest if shortest.ndim == 2 else shortest[:, None]
        if self.amplitude == 0:
            return np.zeros((len(xy), 2 * least.shape[1]))
        return octave_slopes(_octaves(self, corner), xy, least, self.crest)


def _shortest_relevant(radius: Reals) -> Reals:
    """Wavelengths below which an octave's bound is less than its steepest slope × radius [m]."""
    return np.asarray(2.0 ** np.ceil(np.log2(NOISE_MAX_SLOPE / NOISE_BOUND * radius)))


def unit_normals(slopes: Float64[np.ndarray, "n 2"]) -> Points:
    """Upward unit normals of a surface with these slopes, (n, 3)."""
    return np.asarray(_unit_normals(slopes))


@njit(cache=True, nogil=True)
def _unit_normals(slopes: np.ndarray) -> np.ndarray:
    up = np.empty((len(slopes), 3))
    for i in range(len(slopes)):
        x, y = -slopes[i, 0], -slopes[i, 1]
        length = math.sqrt(x * x + y * y + 1.0)
        up[i, 0], up[i, 1], up[i, 2] = x / length, y / length, 1.0 / length
    return up


@lru_cache(maxsize=64)
def _octaves(relief: Relief, corner: Corner) -> Octaves:
    return octaves_at(corner, relief.seed ^ _STREAM, relief.wavelengths, relief.rms / relief.unit)
