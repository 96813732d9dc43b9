"""How a frame is sampled: variant, samples, seed, depth of paths and kind of haze."""

import hashlib
import struct
from collections.abc import Callable
from dataclasses import dataclass

from lod.errors import InputError
from scenes.frame.window import Window, whole_window

SEED_LIMIT = 2**63


HAZES = ("analytic", "scattered", "medium")
"""Closed form whose airlight is the horizon's sky; closed form in the light of a layer of air,
which scatters what sun, sky and ground send; a medium that scatters light (the reference)."""


SampleWatch = Callable[[int], object]
"""Called again and again while a frame is traced, with the number of samples just taken."""


@dataclass(frozen=True)
class Quality:
    """How a frame is sampled.

    variant    a Mitsuba variant that works here (see variants.choose)
    spp        samples per pixel, taken exactly
    max_depth  longest light path, in edges: 2 is direct light only
    haze       one of HAZES: how the air between is worked out
    sun_sampling  share of light samples for the sun against 1 for the sky; of those that were tried
        12 has the least noise for the time (``lodbench study render_settings``)
    sampler    a Mitsuba sampler for JIT variants; of those that were tried none has less noise for
        the time than multijitter (the same study)
    coverage   whether it is counted which objects the samples of a pixel meet
    window     what of the picture is rendered; None = all of it
    most_samples  traced at once: bounds memory, and how long Ctrl-C waits
    """

    variant: str
    spp: int = 16
    seed: int = 0
    max_depth: int = 4
    haze: str = "analytic"
    sun_sampling: float = 12.0
    sampler: str = "multijitter"
    coverage: bool = False
    window: Window | None = None
    most_samples: int = 2**19

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

    def window_of(self, size: tuple[int, int]) -> Window:
        """Return the window that is rendered of a picture of that size [px]."""
        return self.window or whole_window(size)

    @property
    def is_jit(self) -> bool:
        """Tell whether the variant traces wavefronts of rays with code that it compiles."""
        return not self.variant.startswith("scalar_")

    @property
    def is_spectral(self) -> bool:
        """Tell whether light has wavelengths, and not just three colours."""
        return self.variant.endswith("_spectral")


def sampler_seed(seed: int, frame: int, *where: int) -> int:
    """32 bits for Mitsuba's samplers: BLAKE2b of seed, frame and place as 8-byte integers."""
    words = struct.pack(f"<Q{1 + len(where)}q", seed, frame, *where)
    digest = hashlib.blake2b(words, digest_size=4, person=b"lodbench frame").digest()
    return int.from_bytes(digest, "little")
