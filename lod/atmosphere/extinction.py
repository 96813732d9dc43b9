"""How fast air takes contrast away, from its visibility: Koschmieder, Rayleigh and Ångström.

Extinction β is in 1/m, visibility V in m, wavelengths in nm. Visibility here is Koschmieder's: the
distance at which a black target keeps 2 % of its contrast against the horizon sky (Koschmieder,
1924; Middleton, "Vision through the Atmosphere", 1952). It is not the meteorological optical
range of the WMO (Guide No. 8, ch. 9), which keeps 5 % and is 0.77 of it.
"""

import math
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

_CO2_PER_CENT = 300 * 1e-4

_SHORTEST_NM, _LONGEST_NM = 300.0, 1000.0

_VISIBILITY_KM = (0.5, 1.0, 6.0, 50.0, 60.0)
_EXPONENT = (0.0, 0.5, 1.3, 1.3, 1.6)


def extinction_from_visibility(visibility_m: float) -> float:
    """Compute β = ln(1/0.02)/V = 3.912/V at 550 nm [1/m] (Koschmieder, 1924).

    Raises InputError unless V is finite and at least 1 m.
    """
    if not (math.isfinite(visibility_m) and visibility_m >= 1):
        rule = "finite and at least 1 m"
        raise InputError("visibility", visibility_m, rule, "leave it out for clear air")
    return math.log(1 / CONTRAST_THRESHOLD) / visibility_m


def visibility_from_extinction(extinction: float) -> float:
    """Compute V = ln(1/0.02)/β [m], infinite for β = 0: invert ``extinction_from_visibility``."""
    if not (math.isfinite(extinction) and extinction >= 0):
        raise InputError("extinction", extinction, "finite and at least 0 /m")
    return math.log(1 / CONTRAST_THRESHOLD) / extinction if extinction else math.inf


def angstrom_exponent(visibility_m: float) -> float:
    """Compute q of β ∝ λ^−q (Ångström, 1929) for particles, from the visibility.

    Kim, McArthur & Korevaar (Proc. SPIE 4214, 2001, p. 26) give 0 below 0.5 km (fog is grey),
    V − 0.5 up to 1 km, 0.16·V + 0.34 up to 6 km, 1.3 up to 50 km, 1.6 above. Theirs steps at 50 km;
    here it climbs from 50 to 60 km, so that q, like all of the air, is continuous in V.
    """
    extinction_from_visibility(visibility_m)
    return float(np.interp(visibility_m / 1000, _VISIBILITY_KM, _EXPONENT))


def rayleigh_extinction(wavelengths_nm: Bands) -> Bands:
    """Compute β of air without particles at sea level: cross-section × molecules per volume [1/m].

    The formula is that of Bodhaine, Wood, Dutton & Slusser (1999), at 288.15 K and 1013.25 hPa. Air
    scatters and hardly absorbs in the visible, so this is all of its extinction.
    """
    _check(wavelengths_nm)
    return _rayleigh(tuple(wavelengths_nm.tolist()))


@lru_cache(maxsize=64)
def _rayleigh(wavelengths_nm: tuple[float, ...]) -> np.ndarray:
    wavelength_cm = np.array(wavelengths_nm) * 1e-7
    per_cm = _cross_section(wavelength_cm) * _MOLECULES_PER_CM3
    return frozen(per_cm * 100.0, np.float64)


def _cross_section(wavelength_cm: Bands) -> Bands:
    """Compute the cross-section of a molecule of air with 300 ppm of CO₂ [cm²].

    It is that of Bodhaine et al. (1999, eq. 4, 5 and 23) with Peck & Reeder's refraction (J. Opt.
    Soc. Am. 62, 1972), operation by operation as in colour-science (``colour.phenomena.rayleigh``,
    BSD-3-Clause), which takes seconds and 0.1 GB to import; tests hold it against that.
    """
    um = wavelength_cm * 10e3
    refraction = 8060.51 + 2480990 / (132.274 - um ** (-2)) + 17455.7 / (39.32957 - um ** (-2))
    n = refraction / 1.0e8 + 1
    nitrogen = 1.034 + 3.17 * 1.0e-4 * (1 / um**2)
    oxygen = 1.096 + 1.385 * 1.0e-3 * (1 / um**2) + 1.448 * 1.0e-4 * (1 / um**4)
    mixed = 78.084 * nitrogen + 20.946 * oxygen + 0.934 * 1 + _CO2_PER_CENT * 1.15
    king = mixed / (78.084 + 20.946 + 0.934 + _CO2_PER_CENT)
    density = _MOLECULES_PER_CM3
    scattered = 24 * np.pi**3 * (n**2 - 1) ** 2
    return np.asarray(scattered / (wavelength_cm**4 * density**2 * (n**2 + 2) ** 2) * king)


def particle_extinction(visibility_m: float, at_550: float, wavelengths_nm: Bands) -> Bands:
    """Compute β of particles [1/m] from β at 550 nm, ``at_550``, by Ångström's law with q of V."""
    _check(wavelengths_nm)
    return at_550 * (wavelengths_nm / REFERENCE_NM) ** -angstrom_exponent(visibility_m)


def hazy_extinction(visibility_m: float, wavelengths_nm: Bands) -> Bands:
    """Compute β of air and its particles together [1/m]; it is 3.912/V at 550 nm.

    Kim's exponent was fitted to the whole extinction; here it shapes what is left once Rayleigh's
    part is taken out, which makes blue thicker than Kim has it: by 5 % at 20 km, 13 % at 50 km.
    Raises InputError where the air alone is thicker than V allows, beyond 340 km.
    """
    total, clean = extinction_from_visibility(visibility_m), _rayleigh((REFERENCE_NM,))[0]
    if total < clean:
        raise InputError(
            "visibility",
            visibility_m,
            f"at most {visibility_from_extinction(clean) / 1000:.0f} km, that of pure air",
            "leave it out for clear air",
        )
    particles = particle_extinction(visibility_m, total - clean, wavelengths_nm)
    return rayleigh_extinction(wavelengths_nm) + particles


def _check(wavelengths_nm: Bands) -> None:
    if not ((wavelengths_nm >= _SHORTEST_NM) & (wavelengths_nm <= _LONGEST_NM)).all():
        raise InputError(
            "wavelength", wavelengths_nm.tolist(), f"{_SHORTEST_NM:.0f} to {_LONGEST_NM:.0f} nm"
        )
