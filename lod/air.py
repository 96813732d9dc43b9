"""The air of a frame: even haze, and what a path through it takes away.

Extinction β is in 1/m, visibility V in m, wavelengths in nm. Visibility here is Koschmieder's: the
distance at which a black target keeps 2 % of its contrast against the horizon sky (Koschmieder,
1924; Middleton, "Vision through the Atmosphere", 1952). It is not the meteorological optical
range of the WMO (Guide No. 8, ch. 9), which keeps 5 % and is 0.77 of it.

The same β paints the haze and prunes the scene: the renderer uses ``haze_extinction`` in its bands,
the pruner ``least_extinction``.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from lod.arrays import frozen
from lod.errors import InputError

Bands = Float64[np.ndarray, " bands"]

CONTRAST_THRESHOLD = 0.02
"""Contrast that is left at a distance of one visibility (Koschmieder, 1924)."""

REFERENCE_NM = 550.0
"""Wavelength at which visibility is defined, where the eye by day is most sensitive."""

_MOLECULES_PER_CM3 = (6.02214179e23 / 22.4141) * (273.15 / 288.15) * (1 / 1000)
"""Molecules of air at 288.15 K and 1013.25 hPa: Avogadro's number over the molar volume."""


def extinction_from_visibility(visibility_m: float) -> float:
    """Compute β = ln(1/0.02)/V = 3.912/V at 550 nm [1/m] (Koschmieder, 1924).

    Raises InputError unless V is finite and at least 1 m.
    """
    if not (math.isfinite(visibility_m) and visibility_m >= 1):
        rule = "finite and at least 1 m"
        raise InputError("visibility", visibility_m, rule, "leave it out for clear air")
    return math.log(1 / CONTRAST_THRESHOLD) / visibility_m


def angstrom_exponent(visibility_m: float) -> float:
    """Compute q of β ∝ λ^−q (Ångström, 1929) for particles, from the visibility.

    Kim, McArthur & Korevaar (Proc. SPIE 4214, 2001, p. 26) give 0 below 0.5 km (fog is grey),
    V − 0.5 up to 1 km, 0.16·V + 0.34 up to 6 km, 1.3 up to 50 km, 1.6 above. Theirs steps at 50 km;
    here it climbs from 50 to 60 km, so that q, like all of the air, is continuous in V.
    """
    extinction_from_visibility(visibility_m)
    known_km, exponents = (0.5, 1.0, 6.0, 50.0, 60.0), (0.0, 0.5, 1.3, 1.3, 1.6)
    return float(np.interp(visibility_m / 1000, known_km, exponents))


def rayleigh_extinction(wavelengths_nm: Bands) -> Bands:
    """Compute β of air without particles at sea level: cross-section × molecules per volume [1/m].

    The formula is that of Bodhaine, Wood, Dutton & Slusser (1999), at 288.15 K and 1013.25 hPa. Air
    scatters and hardly absorbs in the visible, so this is all of its extinction.
    """
    if not ((wavelengths_nm >= 300.0) & (wavelengths_nm <= 1000.0)).all():
        raise InputError("wavelength", wavelengths_nm.tolist(), "300 to 1000 nm")
    return _rayleigh(tuple(wavelengths_nm.tolist()))


@lru_cache(maxsize=64)
def _rayleigh(wavelengths_nm: tuple[float, ...]) -> np.ndarray:
    """β by the cross-section of a molecule of air with 300 ppm of CO₂.

    It is that of Bodhaine et al. (1999, eq. 4, 5 and 23) with Peck & Reeder's refraction (J. Opt.
    Soc. Am. 62, 1972), operation by operation as in colour-science (``colour.phenomena.rayleigh``,
    BSD-3-Clause), which takes seconds and 0.1 GB to import; tests hold it against that.
    """
    wavelength_cm = np.array(wavelengths_nm) * 1e-7
    um, co2_per_cent = wavelength_cm * 10e3, 300 * 1e-4
    refraction = 8060.51 + 2480990 / (132.274 - um ** (-2)) + 17455.7 / (39.32957 - um ** (-2))
    n = refraction / 1.0e8 + 1
    nitrogen = 1.034 + 3.17 * 1.0e-4 * (1 / um**2)
    oxygen = 1.096 + 1.385 * 1.0e-3 * (1 / um**2) + 1.448 * 1.0e-4 * (1 / um**4)
    mixed = 78.084 * nitrogen + 20.946 * oxygen + 0.934 * 1 + co2_per_cent * 1.15
    king = mixed / (78.084 + 20.946 + 0.934 + co2_per_cent)
    scattered = 24 * np.pi**3 * (n**2 - 1) ** 2
    area = scattered / (wavelength_cm**4 * _MOLECULES_PER_CM3**2 * (n**2 + 2) ** 2) * king
    return frozen(area * _MOLECULES_PER_CM3 * 100.0, np.float64)


@lru_cache(maxsize=1)
def rgb_wavelengths() -> np.ndarray:
    """Give the effective wavelengths of red, green and blue, about 642.4, 543.0 and 440.9 nm, (3,).

    A channel is a weighted integral of the spectrum: its weights r(λ) are the CIE 1931 2° colour
    matching functions through the Rec.709 matrix, negative lobes and all. For a white of D65 seen
    through a little air it dims by d·∫β(λ)·r(λ)·D65(λ)dλ / ∫r(λ)·D65(λ)dλ; where β is nearly
    straight over the channel, that is β at the centroid of r·D65, to first order in d and in β's
    slope. Against the spectral result, for greys and simple colours in airs of 1 to 50 km at 0.1 to
    4 optical depths, the median ΔE2000 is below 0.2; with the primaries' dominant wavelengths
    (611, 549, 464) it is four times that.
    """
    # They follow from colour-science's tables, which takes seconds and 0.1 GB to import; a test
    # compares them.
    return frozen((642.4434140806299, 543.0002219571127, 440.86762935203524), np.float64)


@dataclass(frozen=True)
class Air:
    """Haze that is the same everywhere.

    visibility_m  Koschmieder visibility (2 %) of the haze [m]; None = clear, β = 0
    """

    visibility_m: float | None = None

    def __post_init__(self) -> None:
        haze_extinction(self, np.array([REFERENCE_NM]))


def haze_extinction(air: Air, wavelengths_nm: Bands) -> Bands:
    """Compute β of the even haze, its air and particles together [1/m]; it is 3.912/V at 550 nm.

    In clear air it is 0, without Rayleigh's extinction. Kim's exponent was fitted to the whole
    extinction; here it shapes what is left once Rayleigh's part is taken out, which makes blue
    thicker than Kim has it: by 5 % at 20 km, 13 % at 50 km. Raises InputError where the air alone
    is thicker than V allows, beyond 340 km.
    """
    V = air.visibility_m
    if V is None:
        return np.zeros_like(wavelengths_nm)
    total, clean = extinction_from_visibility(V), _rayleigh((REFERENCE_NM,))[0]
    if total < clean:
        most_km = math.log(1 / CONTRAST_THRESHOLD) / clean / 1000
        rule = f"at most {most_km:.0f} km, that of pure air"
        raise InputError("visibility", V, rule, "leave it out for clear air")
    # Of particles by Ångström's law with q of V.
    particles = (total - clean) * (wavelengths_nm / REFERENCE_NM) ** -angstrom_exponent(V)
    return rayleigh_extinction(wavelengths_nm) + particles


CLEAR = Air()


def rgb_extinction(air: Air) -> Bands:
    """Compute β of the even haze in linear Rec.709 red, green and blue, (3,) [1/m]."""
    return haze_extinction(air, rgb_wavelengths())


def least_extinction(air: Air) -> float:
    """Find the least β over red, green and blue [1/m], so that nothing visible is dropped."""
    return float(rgb_extinction(air).min())
