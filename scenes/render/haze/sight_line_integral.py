"""The integral of the light that the air adds along lines of sight, over uneven ground.

The source term of the air is known by the height above the ground, for a few heights of the ground
itself; along a line it is taken from the ground below, and the equation of transfer is summed from
step to step, exact where the source is a line in optical depth between them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64

from lod.air import Air, optical_depth
from lod.arrays import Reals, freeze
from lod.plane_parallel import RINGS, mean_path_fraction
from scenes.render.description.direction_table import row_sine

Light = Float64[np.ndarray, "rows spokes bands"]

_THIN = 1e-9


@dataclass(frozen=True, eq=False)
class Sources:
    """Source function J of the air over level ground, at a few heights.

    ground  (k,) increasing, heights of the ground [m]
    height  (k, levels) above it, from 0 up [m]
    source  (k, levels, RINGS, SPOKES, bands)
    """

    ground: np.ndarray
    height: np.ndarray
    source: np.ndarray

    def __post_init__(self) -> None:
        freeze(self, ground=np.float64, height=np.float64, source=np.float64)


class Lines(NamedTuple):
    """Lines of sight from a height [m], in every azimuth, that rise by ``up`` (rows,) a metre.

    ``ground`` gives the ground's height at horizontal distances, (rows,) → (rows, spokes) [m].
    """

    start_m: float
    up: np.ndarray
    ground: Callable[[np.ndarray], np.ndarray]


class Gathered(NamedTuple):
    """The light that the air has added by the end of each step along lines of sight.

    light   (steps, rows, spokes, bands) radiance that the air has added
    source  (steps, rows, spokes, bands) the radiance that an endless path of such air would add:
            light / (1 − exp(−depth))
    depth   (steps, rows, bands) optical depth
    """

    light: np.ndarray
    source: np.ndarray
    depth: np.ndarray


def gather(
    sources: Sources, lines: Lines, air: Air, wavelengths: np.ndarray, ends: np.ndarray
) -> Gathered:
    """Integrate the air's light along lines up to increasing distances (steps, rows) [m]."""
    spokes, bands = sources.source.shape[-2:]
    light, total = np.zeros((len(lines.up), spokes, bands)), np.zeros((len(lines.up), bands))
    start, before = np.zeros(len(lines.up)), _source_at(sources, lines, np.zeros(len(lines.up)))
    made = []
    for end in ends:
        heights = lines.start_m + lines.up * start, lines.start_m + lines.up * end
        depth = optical_depth(air, *heights, end - start, wavelengths)
        here = _source_at(sources, lines, end)
        share = mean_path_fraction(depth)[:, None]
        own = before * (1 - share) + here * share
        light = light + (np.exp(-total) * -np.expm1(-depth))[:, None] * own
        total, start, before = total + depth, end, here
        held = -np.expm1(-total)[:, None]
        made.append((light, np.where(held > _THIN, light / np.maximum(held, _THIN), own), total))
    return Gathered(*(np.stack(each) for each in zip(*made, strict=True)))


def _source_at(sources: Sources, lines: Lines, distance: Reals) -> Light:
    """Interpolate the source function J at distances (rows,) [m] along the lines."""
    ground = lines.ground(distance * np.sqrt(np.maximum(1 - lines.up**2, 0.0)))
    above = np.maximum((lines.start_m + lines.up * distance)[:, None] - ground, 0.0)
    row = np.clip(row_sine(RINGS, lines.up), 0, RINGS - 1)
    spoke = np.arange(sources.source.shape[-2])
    total = np.zeros((*ground.shape, sources.source.shape[-1]))
    at = np.interp(ground, sources.ground, np.arange(len(sources.ground)))
    for k in range(len(sources.ground)):
        weight = np.maximum(1 - np.abs(at - k), 0.0)
        level = np.interp(above, sources.height[k], np.arange(sources.height.shape[1]))
        for up, up_share in _neighbours(level, sources.height.shape[1]):
            for ring, ring_share in _neighbours(row, RINGS):
                share = weight * up_share * ring_share[:, None]
                total += share[..., None] * sources.source[k, up, ring[:, None], spoke]
    return total


def _neighbours(place: np.ndarray, count: int) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Find the two whole numbers about each place, below ``count``, and the share of each."""
    below = np.floor(place).astype(np.int64)
    share = place - below
    return (below, 1 - share), (np.minimum(below + 1, count - 1), share)
