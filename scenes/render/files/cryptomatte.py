"""Mattes of objects and species by Cryptomatte's specification 1.2.0, ranked by coverage.

The sky has no id and takes no rank. https://github.com/Psyop/Cryptomatte, folder specification.
"""

import json
from collections.abc import Mapping
from dataclasses import replace

import mmh3
import numpy as np

from scenes.frame.layers import Coverage, Layers, Mattes, add_coverage

TYPES = ("CryptoObject", "CryptoSpecies")
RANKS = 6
"""Ids in a pixel, those that cover most of it; the specification suggests six."""

CHANNELS = tuple(
    f"{name}{rank // 2:02d}.{'rgba'[2 * (rank % 2) + i]}"
    for name in TYPES
    for rank in range(RANKS)
    for i in range(2)
)


def with_mattes(layers: Layers, names: Mapping[int, tuple[str, str]]) -> Layers:
    """Turn the coverage of layers into mattes; ``names``: of each object, its own and species'."""
    coverage = layers.coverage
    assert coverage is not None
    met = np.flatnonzero(coverage.object)
    objects, row = np.unique(coverage.object[met], return_inverse=True)
    channels: dict[str, np.ndarray] = {}
    attributes: dict[str, str] = {}
    for number, name in enumerate(TYPES):
        of_object = [names[each][number] for each in objects.tolist()]
        ids = {each: matte_id(each) for each in of_object}
        numbers = np.array([ids[each] for each in of_object], np.uint32)
        shares = add_coverage(coverage.pixel[met], numbers[row], coverage.share[met])
        channels |= _channels(name, shares, layers.Z.shape)
        attributes |= _attributes(name, ids)
    return replace(layers, coverage=None, mattes=Mattes(channels, attributes))


def matte_id(name: str) -> int:
    """Hash a name to the 32 bits of a float that is neither NaN, infinite, 0 nor subnormal."""
    number: int = mmh3.hash(name, signed=False)
    return number ^ 1 << 23 if number >> 23 & 255 in (0, 255) else number


def _channels(name: str, shares: Coverage, size: tuple[int, ...]) -> dict[str, np.ndarray]:
    """Ids and coverage of each pixel by rank, (h, w) float32 each, 0 where there are fewer."""
    order = np.lexsort((shares.object, -shares.share, shares.pixel))
    pixel, ids = shares.pixel[order], shares.object[order].view(np.float32)
    begins = np.flatnonzero(np.diff(pixel, prepend=-1))
    rank = np.arange(len(pixel)) - np.repeat(begins, np.diff(begins, append=len(pixel)))
    found = np.zeros((2 * RANKS, *size), np.float32)
    kept = rank < RANKS
    flat = found.reshape(2 * RANKS, -1)
    flat[2 * rank[kept], pixel[kept]] = ids[kept]
    flat[2 * rank[kept] + 1, pixel[kept]] = shares.share[order][kept]
    own = [each for each in CHANNELS if each.startswith(name)]
    return dict(zip(own, found, strict=True))


def _attributes(name: str, ids: Mapping[str, int]) -> dict[str, str]:
    key = f"cryptomatte/{matte_id(name):08x}"[:-1]
    manifest = {each: f"{number:08x}" for each, number in sorted(ids.items())}
    return {
        f"{key}/name": name,
        f"{key}/hash": "MurmurHash3_32",
        f"{key}/conversion": "uint32_to_float32",
        f"{key}/manifest": json.dumps(manifest, separators=(",", ":"), ensure_ascii=False),
    }
