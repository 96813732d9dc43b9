"""Airlight from scattering: the radiance that an endless level path through a layer tends to.

It is the layer's source term, J(ω) = ϖ·∫p(ω, ω′)·L(ω′)dω′ (Chandrasekhar, "Radiative Transfer",
1950, §6), for the air that ``medium`` describes. L is the light at the eye: the sun's, the sky's
and that of even ground, each dimmed by the layer in between, and in its place the layer's own,

    L = L₀·exp(−t) + J·(1 − exp(−t)),    t = β·height/|sin elevation|,

with J taken to be the same all along the way. So the equation is solved for J by repetition, and
light may scatter as often as it will. Left out: that J varies with height, and what stands in it
and casts shadows.
"""

import numpy as np

from lod.arrays import frozen
from scenes.render.airlight import AZIMUTHS, sky_radiance
from scenes.render.build import sun_irradiance
from scenes.render.describe import Description
from scenes.render.medium import ALBEDO, ASYMMETRY, extent

_RINGS, _SPOKES = 96, 64
_ROUNDS = 40


def scattered(description: Description, beta: np.ndarray) -> np.ndarray:
    """J for level directions by azimuth, (AZIMUTHS + 1, bands); ``beta`` (bands,) is at the eye."""
    light, (up, turn, solid_angle) = description["light"], _directions()
    to_sun, (above, below) = light["to_sun"], _layer(description)
    # Dimming from without to the eye, by ring and band; the sun's by its own elevation.
    height = np.where(up > 0, above, below)
    dim = np.exp(-beta * (height / np.abs(up))[:, None])[:, None]
    sun = sun_irradiance(light) * np.exp(-beta * above / max(to_sun[2], 1e-3))
    outside = _outside(description, up, turn, solid_angle)
    by_sun, by_rest = _kernels(up, turn, to_sun, solid_angle)
    first = ALBEDO * by_sun[..., None] * sun
    source = first + _scatter(by_rest, outside)
    for _ in range(_ROUNDS):
        source = first + _scatter(by_rest, outside * dim + source * (1 - dim))
    arriving = outside * dim + source * (1 - dim)
    return _level(up, turn, arriving, sun, to_sun, solid_angle)


def _directions() -> tuple[np.ndarray, np.ndarray, float]:
    """Sines of elevation of rings of equal area, azimuths of spokes, solid angle of a share."""
    up = (np.arange(_RINGS) + 0.5) / _RINGS * 2 - 1
    turn = np.arange(_SPOKES) / _SPOKES * 2 * np.pi
    return up, turn, 4 * np.pi / (_RINGS * _SPOKES)


def _layer(description: Description) -> tuple[float, float]:
    """Metres of air above the eye, and below it down to the mean height of the ground."""
    eye, (bottom, top, _) = float(description["camera"]["eye"][2]), extent(description)
    meshes = [s["vertices"][:, 2] for s in description["shapes"].values() if s["type"] == "mesh"]
    ground = float(np.concatenate(meshes).mean()) if meshes else bottom
    return top - eye, max(eye - ground, 0.0)


def _outside(
    description: Description, up: np.ndarray, turn: np.ndarray, solid_angle: float
) -> np.ndarray:
    """Light that enters the layer, (rings, spokes, bands): the sky's, and from below that of even
    ground under sun and sky, whose albedo is the mean of the scene's meshes."""
    light, above = description["light"], up > 0
    sky = sky_radiance(light, _vectors(up[above], turn).reshape(-1, 3))
    lit = sun_irradiance(light) * light["to_sun"][2]
    lit = lit + (sky * np.repeat(up[above], len(turn))[:, None]).sum(axis=0) * solid_angle
    made = np.empty((len(up), len(turn), sky.shape[1]))
    made[above] = sky.reshape(-1, len(turn), sky.shape[1])
    made[~above] = _ground_albedo(description) * lit / np.pi
    return made


def _kernels(
    up: np.ndarray, turn: np.ndarray, to_sun: np.ndarray, solid_angle: float
) -> tuple[np.ndarray, np.ndarray]:
    """Phase function towards the sun, (rings, spokes), and between rings by difference of azimuth,
    as its Fourier transform, (rings, rings, frequencies), times albedo and solid angle."""
    level = np.sqrt(1 - up**2)
    cosine = up[:, None, None] * up[None, :, None]
    cosine = cosine + (level[:, None] * level[None])[..., None] * np.cos(turn)
    between = phase(cosine)
    between /= between.sum(axis=(1, 2), keepdims=True) * solid_angle  # no light is lost or made
    return phase(_vectors(up, turn) @ to_sun), ALBEDO * solid_angle * np.fft.rfft(between, axis=2)


def _scatter(kernel: np.ndarray, arriving: np.ndarray) -> np.ndarray:
    """ϖ·∫p·L over all directions, (rings, spokes, bands): a convolution in azimuth."""
    waves = np.einsum("rsk,skb->rkb", kernel, np.fft.rfft(arriving, axis=1))
    return np.fft.irfft(waves, n=arriving.shape[1], axis=1)


def _level(
    up: np.ndarray,
    turn: np.ndarray,
    arriving: np.ndarray,
    sun: np.ndarray,
    to_sun: np.ndarray,
    solid_angle: float,
) -> np.ndarray:
    """The source term of level directions, from the light that arrives."""
    at = np.arange(AZIMUTHS + 1) / AZIMUTHS * 2 * np.pi
    view = np.stack((np.sin(at), np.cos(at), np.zeros_like(at)), axis=1)
    weight = phase(view @ _vectors(up, turn).reshape(-1, 3).T)
    weight /= weight.sum(axis=1, keepdims=True)
    diffuse = weight @ arriving.reshape(-1, arriving.shape[2])
    return frozen(ALBEDO * (phase(view @ to_sun)[:, None] * sun + diffuse), np.float64)


def phase(cosine: np.ndarray) -> np.ndarray:
    """Henyey & Greenstein's phase function [1/sr] of the cosine between where light comes from and
    the line of sight: at 1 light goes on as it came."""
    g = ASYMMETRY
    return (1 - g**2) / (4 * np.pi * (1 + g**2 - 2 * g * cosine) ** 1.5)


def _vectors(up: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Unit vectors, (rings, spokes, 3)."""
    level = np.sqrt(1 - up**2)[:, None]
    z = np.broadcast_to(up[:, None], (len(up), len(turn)))
    return np.stack((level * np.sin(turn), level * np.cos(turn), z), axis=2)


def _ground_albedo(description: Description) -> np.ndarray:
    """Mean colour of the vertices of all meshes, (3,); black where there is none."""
    meshes = [s["colours"] for s in description["shapes"].values() if s["type"] == "mesh"]
    return np.concatenate(meshes).mean(axis=0) if meshes else np.zeros(3)
