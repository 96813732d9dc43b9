"""The layers of a rendered frame, as arrays; nothing here knows the renderer."""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import freeze

SKY_Z = np.float32(1e10)
"""Z of the sky [m]: farther than anything, finite, exact to read in every program."""


@dataclass(frozen=True, eq=False)
class Coverage:
    """Which objects cover which share of which pixel, each pair once, by pixel and object.

    pixel (n,) int64 row by row from the top; object (n,) uint32, 0 for the sky; share (n,) above 0
    """

    pixel: np.ndarray
    object: np.ndarray
    share: np.ndarray


@dataclass(frozen=True, eq=False)
class Mattes:
    """Cryptomatte: channels by name, (h, w) float32 each, and the attributes that tell of them."""

    channels: dict[str, np.ndarray]
    attributes: dict[str, str]


@dataclass(frozen=True, eq=False)
class Layers:
    """A rendered frame, rows from the top.

    rgb     (h, w, 3) linear Rec.709 radiance, haze included; mean of all samples, never negative
    Z       (h, w)    distance along the ray [m]; SKY_Z where the ray meets nothing
    N       (h, w, 3) unit shading normal, x east, y north, z up; 0 for the sky
    albedo  (h, w, 3) mean of all samples, 0 to 1; 0 for the sky
    object, part, level (h, w) frame-local ids; object 0 is the sky
    motion  (h, w, 2) to where the same point is in the next frame [px], x right, y up; or None
    denoised (h, w, 3) rgb as a denoiser leaves it, never negative; or None
    coverage     what covers each pixel, where it was asked for and is not yet mattes; or None
    mattes       the same as Cryptomatte; or None
    right        the same frame as the right eye of a pair sees it, these being the left; or None
    seconds      of each stage
    statistics   counts worth keeping: shapes, sticks, triangles, clamped and replaced pixels

    Z, N, the ids and motion are those of one sample of each pixel, which one the driver says.
    """

    rgb: np.ndarray
    Z: np.ndarray
    N: np.ndarray
    albedo: np.ndarray
    object: np.ndarray
    part: np.ndarray
    level: np.ndarray
    seconds: dict[str, float] = field(default_factory=dict)
    statistics: dict[str, int] = field(default_factory=dict)
    motion: np.ndarray | None = None
    denoised: np.ndarray | None = None
    coverage: Coverage | None = None
    mattes: Mattes | None = None
    right: "Layers | None" = None

    def __post_init__(self) -> None:
        freeze(self, rgb=np.float32, Z=np.float32, N=np.float32, albedo=np.float32)
        freeze(self, object=np.uint32, part=np.uint32, level=np.uint32)
        for name in ("motion", "denoised"):
            if getattr(self, name) is not None:
                freeze(self, **{name: np.float32})


def add_coverage(pixel: np.ndarray, objects: np.ndarray, share: np.ndarray) -> Coverage:
    """Add up the shares (n,) of each pair of pixel (n,) and object (n,)."""
    pairs = pixel.astype(np.uint64) << np.uint64(32) | objects.astype(np.uint64)
    pairs, row = np.unique(pairs, return_inverse=True)
    found, of = pairs & np.uint64(2**32 - 1), pairs >> np.uint64(32)
    shares = np.bincount(row, share, len(pairs))
    return Coverage(of.astype(np.int64), found.astype(np.uint32), shares)
