"""How boulders are made: octrees of broken, weathered stone, half sunk into the ground.

The shape is an ellipsoid cut by random planes (the faces along which rock breaks), its edges
rounded and its surface roughened by noise of every size. Sizes are of the preset's choosing; here
the block is about a metre and a half across.
"""

from functools import lru_cache

import numpy as np
from jaxtyping import Float64
from scipy.ndimage import zoom

from lod.errors import InputError
from scenes.models.octree import Solid, octree_prototype
from scenes.sticks.prototype import Prototype

STONE = np.linspace((0.19, 0.18, 0.165), (0.37, 0.36, 0.33), 7)
LICHEN = np.array(((0.33, 0.30, 0.16), (0.24, 0.26, 0.19)))
TINTS = np.concatenate((STONE, LICHEN))
"""Linear Rec.709 albedo of weathered granite, from dark to light, and of what grows on it; chosen
by eye."""

SIDE_M = 2.0
"""Side of the octree's cube."""

DEPTH = 6
"""Finest cells are 2^-DEPTH of the cube: 3 cm."""

_PLANES = 11
_STREAM = 0xB01D


@lru_cache(maxsize=16)
def boulder_prototypes(seed: int, count: int) -> tuple[Prototype, ...]:
    """Make ``count`` boulders; the k-th depends on the seed and on k only."""
    if count < 1:
        raise InputError("species.boulder.prototypes", count, "at least one prototype")
    return tuple(
        octree_prototype(f"boulder {k}", boulder_solid(seed, k), TINTS) for k in range(count)
    )


def boulder_solid(seed: int, k: int, depth: int = DEPTH) -> Solid:
    """Make the k-th block of that seed, sampled finely enough for an octree of that depth."""
    rng = np.random.Generator(np.random.Philox(np.random.SeedSequence((seed, _STREAM, k))))
    s = 2 ** (depth + 1)
    axis = (np.arange(s) + 0.5) / s * 2 - 1
    xyz = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1)
    # An ellipsoid, wider than high, and the planes that cut it; negative inside.
    half = rng.uniform((0.66, 0.55, 0.45), (0.8, 0.7, 0.6))
    outside = np.linalg.norm(xyz / half, axis=-1) - 1
    normals = rng.normal(size=(_PLANES, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    support = np.linalg.norm(normals * half, axis=1)
    depths = support * rng.uniform(0.62, 0.95, _PLANES)
    for normal, far in zip(normals, depths, strict=True):
        outside = _rounded_max(outside, (xyz @ normal - far) / half.mean(), 0.07)
    outside = outside + 0.09 * _noise(rng, s, 2, 2.6)
    tone, growth = _noise(rng, s, 4, 1.8), _noise(rng, s, 3, 2.0)
    corner = SIDE_M * np.array((-0.5, -0.5, -0.43))
    return Solid(outside < 0, _albedo(tone, growth, xyz[..., 2]), corner, SIDE_M)


def _albedo(
    tone: Float64[np.ndarray, "s s s"],
    growth: Float64[np.ndarray, "s s s"],
    height: Float64[np.ndarray, "s s s"],
) -> Float64[np.ndarray, "s s s 3"]:
    """Stone of uneven tone; lichen in patches, more of it above."""
    row = np.clip(np.rint(3 + 2.2 * tone), 0, len(STONE) - 1).astype(np.int64)
    patch = growth + 0.5 * height
    lichen = np.where(tone > 0, 0, 1)[..., None]
    return np.where((patch > 1.25)[..., None], LICHEN[lichen[..., 0]], STONE[row])


def _rounded_max(
    a: Float64[np.ndarray, "s s s"], b: Float64[np.ndarray, "s s s"], width: float
) -> Float64[np.ndarray, "s s s"]:
    """The greater of two fields, rounded where they are within ``width`` (a quadratic blend)."""
    near = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.maximum(a, b) + near * near * width / 4


def _noise(
    rng: np.random.Generator, s: int, coarsest: int, fall: float
) -> Float64[np.ndarray, "s s s"]:
    """Noise of RMS 1 by spectral synthesis (Voss 1988, in "The Science of Fractal Images").

    Amplitudes fall as 1/(f + ``coarsest``)^fall, f in waves along the cube. Drawn on half as many
    points along each side, straight lines between.
    """
    n = s // 2
    frequency = np.fft.fftfreq(n, 1 / n), np.fft.fftfreq(n, 1 / n), np.fft.rfftfreq(n, 1 / n)
    x, y, z = np.meshgrid(*frequency, indexing="ij")
    f = np.sqrt(x * x + y * y + z * z)
    weight = np.where(f > 0, (f + coarsest) ** -fall, 0.0)
    values = np.fft.irfftn(
        weight * np.fft.rfftn(rng.normal(size=(n, n, n))), s=(n, n, n), axes=(0, 1, 2)
    )
    return zoom(values / values.std(), 2, order=1, mode="nearest")
