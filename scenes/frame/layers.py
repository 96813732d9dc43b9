"""The layers of a rendered frame, as arrays; nothing here knows the renderer."""

from dataclasses import dataclass, field

import numpy as np

from lod.arrays import freeze

SKY_Z = np.float32(1e10)
"""Z of the sky [m]: farther than anything, finite, exact to read in every program."""


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

    def __post_init__(self) -> None:
        freeze(self, rgb=np.float32, Z=np.float32, N=np.float32, albedo=np.float32)
        freeze(self, object=np.uint32, part=np.uint32, level=np.uint32)
        for name in ("motion", "denoised"):
            if getattr(self, name) is not None:
                freeze(self, **{name: np.float32})
