"""Radiance in an even layer of air over even ground, with all orders of scattering.

The equation of transfer of a plane-parallel layer (Chandrasekhar, "Radiative Transfer", 1950, §6
and §§9 to 11), by discrete directions and heights. Radiance is attenuated light from outside plus
the source function of the air on the way,

    J(z, ω) = ϖ·(p(ω·ω₀)·E·exp(−τ/sin e) + ∫p(ω·ω′)·L(z, ω′)dω′),

which is iterated until it converges. p is Henyey & Greenstein's phase function (Astrophys. J. 93,
1941). The ground is Lambertian; what stands on it is a second medium in the lowest steps
(``lod.canopy``), whose source is the same in all directions, ϱ/4π·(E + ∫L·dω).
Directions stand in rings of equal solid angle; the integral is a convolution in azimuth, so it is
computed frequency by frequency.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from lod.arrays import ArrayData, FloatArray, Reals

Field = Float64[np.ndarray, "rings spokes bands"]

RINGS, SPOKES = 64, 72
"""Directions: rings are the middles of even steps in the sine of elevation, spokes stand
clockwise from north."""

LOWEST_SUN = 1e-3
"""Least sine of the sun's elevation: the path of its light would be endless at 0."""

_SMALL = 1e-3
_SETTLED, _MOST_ROUNDS = 1e-4, 200
"""The iteration ends when J changes by less than this share of its greatest value, or after so
many rounds."""


@dataclass(frozen=True)
class Scattering:
    """The scattering of the air: single-scattering albedo ϖ, and asymmetry g (mean cosine)."""

    albedo: float
    asymmetry: float


@dataclass(frozen=True, eq=False)
class SlabInputs(ArrayData):
    """Inputs of the plane-parallel transfer: the layer, what bounds it, and what lights it.

    height   (levels,) from the ground up to the top [m]
    depth    (levels − 1, bands) ∫β of each step, straight up
    cover    (levels − 1,) optical depth of the plants in each step, straight up, K·ΔA
    to_sun   (3,) unit vector
    sun      (bands,) irradiance of a surface that faces the sun, above the layer
    sky      (RINGS / 2, SPOKES, bands) radiance above the layer
    ground   (bands,) albedo of the ground
    plants   (bands,) albedo of the plants
    """

    height: FloatArray
    depth: FloatArray
    cover: FloatArray
    to_sun: FloatArray
    sun: FloatArray
    sky: FloatArray
    ground: FloatArray
    plants: FloatArray

    @property
    def extinction_depth(self) -> np.ndarray:
        """Add up the optical depths of air and plants in each step, (levels − 1, bands)."""
        return self.depth + self.cover[:, None]


def directions() -> np.ndarray:
    """Give the unit vectors of all directions, (RINGS, SPOKES, 3), from the nadir to the zenith."""
    up, turn = _up(), np.arange(SPOKES) / SPOKES * 2 * np.pi
    level = np.sqrt(1 - up**2)[:, None]
    z = np.broadcast_to(up[:, None], (RINGS, SPOKES))
    return np.stack((level * np.sin(turn), level * np.cos(turn), z), axis=2)


def henyey_greenstein(cosine: np.ndarray, asymmetry: float) -> np.ndarray:
    """Compute Henyey & Greenstein's phase function p (1941) at cosines of scattering angles [1/sr].

    ``cosine`` is 1 where light goes on in its direction.
    """
    g = asymmetry
    return (1 - g**2) / (4 * np.pi * (1 + g**2 - 2 * g * cosine) ** 1.5)


def mean_path_fraction(depth: np.ndarray) -> np.ndarray:
    """Compute at which fraction of a path of optical depth t scattered light arises on average.

    It is ∫x·exp(−tx)dx / ∫exp(−tx)dx over 0 to 1, which is 1/t − 1/(exp(t) − 1), and ½ at t = 0.
    """
    t = np.maximum(depth, _SMALL)
    with np.errstate(over="ignore"):
        return np.where(depth > _SMALL, 1 / t - 1 / np.expm1(t), 0.5 - depth / 12)


def source_function(
    slab: SlabInputs, air: Scattering
) -> Float64[np.ndarray, "levels rings spokes bands"]:
    """Compute the source function J of the air at every height, with all orders of scattering."""
    kernel = _kernel(air)
    toward_sun = henyey_greenstein(directions() @ slab.to_sun, air.asymmetry)
    first = air.albedo * toward_sun[None, ..., None] * direct_irradiance(slab)[:, None, None]
    source, plant_source = first, slab.plants / (4 * np.pi) * direct_irradiance(slab)
    for _ in range(_MOST_ROUNDS):
        light = radiance(slab, source, plant_source)
        before, source = source, first + _scatter(kernel, light)
        around = light.sum(axis=(1, 2)) * _SOLID_ANGLE
        plant_source = slab.plants / (4 * np.pi) * (direct_irradiance(slab) + around)
        if np.abs(source - before).max() <= _SETTLED * np.abs(source).max():
            break
    return source


def direct_irradiance(slab: SlabInputs) -> Float64[np.ndarray, "levels bands"]:
    """Compute the direct irradiance, at each height, of a surface that faces the sun."""
    above = np.concatenate(
        (slab.extinction_depth[::-1].cumsum(axis=0)[::-1], np.zeros((1, len(slab.sun))))
    )
    return slab.sun * np.exp(-above / max(float(slab.to_sun[2]), LOWEST_SUN))


def radiance(
    slab: SlabInputs, source: np.ndarray, plant_source: Float64[np.ndarray, "levels bands"]
) -> Float64[np.ndarray, "levels rings spokes bands"]:
    """Compute the radiance L at every height: down through the layer, off the ground, and up.

    ``source`` is the source function of the air, ``plant_source`` that of the plants.
    """
    half, up = RINGS // 2, _up()[RINGS // 2 :]
    steps = slab.extinction_depth[:, None, None] / up[:, None, None]
    through, share = np.exp(-steps), mean_path_fraction(steps)
    # Source functions of air and plants together at the lower and upper end of each step.
    extinct, nothing = slab.extinction_depth, np.ones_like(slab.depth)
    air = np.divide(slab.depth, extinct, out=nothing, where=extinct > 0)[:, None, None]
    plants = plant_source[:, None, None]
    low = air * source[:-1] + (1 - air) * plants[:-1]
    high = air * source[1:] + (1 - air) * plants[1:]
    light = np.empty_like(source)
    light[-1, half:] = slab.sky
    for k in range(len(slab.depth) - 1, -1, -1):
        own = low[k, half:] * (1 - share[k]) + high[k, half:] * share[k]
        light[k, half:] = light[k + 1, half:] * through[k] + own * (1 - through[k])
    light[0, :half] = slab.ground / np.pi * irradiance(slab, light[0, half:])
    through, share = through[:, ::-1], share[:, ::-1]  # rings below the horizon, from the lowest
    for k in range(len(slab.depth)):
        own = high[k, :half] * (1 - share[k]) + low[k, :half] * share[k]
        light[k + 1, :half] = light[k, :half] * through[k] + own * (1 - through[k])
    return light


def irradiance(slab: SlabInputs, down: Field) -> Reals:
    """Compute the irradiance of the ground by direct sun and radiance from above, (bands,)."""
    diffuse = (down * _up()[RINGS // 2 :, None, None]).sum(axis=(0, 1)) * _SOLID_ANGLE
    return direct_irradiance(slab)[0] * max(float(slab.to_sun[2]), 0.0) + diffuse


_SOLID_ANGLE = 4 * np.pi / (RINGS * SPOKES)


def _up() -> Reals:
    return (np.arange(RINGS) + 0.5) / RINGS * 2 - 1


def _kernel(air: Scattering) -> np.ndarray:
    """Compute ϖ·p·dω between rings as a Fourier transform in azimuth, (frequencies, rings, rings).

    It is normalised, so that the discrete directions neither lose nor add light.
    """
    up, turn = _up(), np.arange(SPOKES) / SPOKES * 2 * np.pi
    level = np.sqrt(1 - up**2)
    cosine = up[:, None, None] * up[None, :, None]
    cosine = cosine + (level[:, None] * level[None])[..., None] * np.cos(turn)
    between = henyey_greenstein(cosine, air.asymmetry)
    between *= air.albedo / between.sum(axis=(1, 2), keepdims=True)
    return np.fft.rfft(between, axis=2).transpose(2, 0, 1)


def _scatter(kernel: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Compute ϖ·∫p·L·dω at every height."""
    levels, rings, spokes, bands = light.shape
    waves = np.fft.rfft(light, axis=2).transpose(2, 1, 0, 3).reshape(-1, rings, levels * bands)
    turned = (kernel @ waves).reshape(-1, rings, levels, bands).transpose(2, 1, 0, 3)
    return np.fft.irfft(turned, n=spokes, axis=2)
