"""What goes into a rendered frame and what comes out of it; nothing here knows the renderer."""

import hashlib
import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from lod.arrays import freeze
from lod.atmosphere.air import Air
from lod.camera import Camera
from lod.canopy.turbid_medium import BARE, Canopy
from lod.errors import InputError
from lod.pruning.parts import Sticks, Triangles
from lod.pruning.pruner import Cut

SKY_Z = np.float32(1e10)
"""Z of the sky [m]: farther than anything, finite, exact to read in every program."""

SEED_LIMIT = 2**63

HAZES = ("analytic", "scattered", "medium")
"""Closed form whose airlight is the horizon's sky; closed form in the light of a layer of air,
which scatters what sun, sky and ground send; a medium that scatters light (the reference)."""


@dataclass(frozen=True, eq=False)
class Visible:
    """One representation's cut and its looks; ``shape.owner`` gives rows of ``cut.parts``.

    later  the same sticks as they are in the next frame, in this one's coordinates; None: as now
    """

    name: str
    cut: Cut
    shape: Sticks | Triangles
    later: Sticks | None = None


@dataclass(frozen=True)
class Light:
    """Sun and sky: azimuth clockwise from north (+y), elevation above the horizon [degrees]; and
    the canopy whose shade is in the air, where that is worked out (see HAZES: scattered)."""

    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float = 3.0
    canopy: Canopy = BARE

    def __post_init__(self) -> None:
        if not math.isfinite(self.sun_azimuth_deg):
            raise InputError("light.sun_azimuth", self.sun_azimuth_deg, "finite [degrees]")
        if not 0 <= self.sun_elevation_deg <= 90:
            raise InputError("light.sun_elevation", self.sun_elevation_deg, "from 0° to 90°")
        if not 1 <= self.turbidity <= 10:
            raise InputError("light.turbidity", self.turbidity, "from 1 (clear) to 10", "try 3")

    @property
    def to_sun(self) -> np.ndarray:
        """Unit vector to the sun, (3,)."""
        a, e = math.radians(self.sun_azimuth_deg), math.radians(self.sun_elevation_deg)
        return np.array((math.sin(a) * math.cos(e), math.cos(a) * math.cos(e), math.sin(e)))


@dataclass(frozen=True)
class Quality:
    """How a frame is sampled.

    variant    a Mitsuba variant that works here (see variants.choose)
    spp        samples per pixel, taken exactly
    max_depth  longest light path, in edges: 2 is direct light only
    haze       one of HAZES: how the air between is worked out
    """

    variant: str
    spp: int = 16
    seed: int = 0
    max_depth: int = 4
    haze: str = "analytic"

    def __post_init__(self) -> None:
        if not 1 <= self.spp <= 65536:
            raise InputError("spp", self.spp, "from 1 to 65536 samples per pixel", "try 16")
        if not 0 <= self.seed < SEED_LIMIT:
            raise InputError("seed", self.seed, "from 0 to 2**63 - 1")
        if not 1 <= self.max_depth <= 64:
            raise InputError("max_depth", self.max_depth, "from 1 to 64", "try 4")
        if self.haze not in HAZES:
            raise InputError("haze", self.haze, f"one of {', '.join(HAZES)}", "try analytic")
        if self.is_spectral and self.haze != "analytic":
            rule = "analytic where pictures are spectral"
            raise InputError("--haze", self.haze, rule, "leave out --spectral")

    @property
    def is_spectral(self) -> bool:
        """Whether light has wavelengths, and not just three colours."""
        return self.variant.endswith("_spectral")


@dataclass(frozen=True, eq=False)
class Extras:
    """Layers beside the usual ones.

    after    the next frame's camera, where motion is asked for
    denoise  whether a denoised picture is
    """

    after: Camera | None = None
    denoise: bool = False


USUAL = Extras()
"""No other layers."""


@dataclass(frozen=True)
class FileForm:
    """How a frame's file is laid out; none of it loses anything but half's rounding.

    compression  zip, zips, piz, rle or none. Only zip and zips notice a flipped bit by themselves
    multipart    a part for each group of layers instead of one part with all
    colour       "half" or "float" pixels in R G B, albedo and denoised
    """

    compression: str = "zip"
    multipart: bool = False
    colour: str = "half"


PLAIN = FileForm()
"""One part, ZIP, half."""


@dataclass(frozen=True, eq=False)
class Instant:
    """One moment of a frame while the shutter is open, in the frame's own coordinates.

    after  the camera a frame's time later, where motion is asked for
    """

    camera: Camera
    visible: tuple[Visible, ...]
    after: Camera | None = None


@dataclass(frozen=True, eq=False)
class FrameInput:
    """All that one frame of a sequence is made from.

    instants   of the sub-frames, made when called; none where nothing moves, or no shutter is open
    fps        frames a second, for the header
    form       of the file
    extras     layers beside the usual ones
    seconds    of the stages that made this input, such as pruning
    counts     worth keeping beside those of the scene
    """

    camera: Camera
    visible: tuple[Visible, ...]
    air: Air
    light: Light
    quality: Quality
    fps: float = 24.0
    form: FileForm = PLAIN
    extras: Extras = USUAL
    seconds: dict[str, float] = field(default_factory=dict)
    counts: dict[str, int] = field(default_factory=dict)
    instants: tuple[Callable[[], Instant], ...] = ()


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


def sampler_seed(seed: int, frame: int, *where: int) -> int:
    """32 bits for Mitsuba's samplers: BLAKE2b of seed, frame and place as 8-byte integers."""
    words = struct.pack(f"<Q{1 + len(where)}q", seed, frame, *where)
    digest = hashlib.blake2b(words, digest_size=4, person=b"lodbench frame").digest()
    return int.from_bytes(digest, "little")
