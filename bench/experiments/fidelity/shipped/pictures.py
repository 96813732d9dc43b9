"""What is seen of a built scene: pictures of several counts of samples, and the light of its land.

The land's luminance is summed over rays, each of which is of one place alone: pictures of one
sample a pixel have a distance for every ray, and no pixel is half land and half sky.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64

from bench.experiments.fidelity.shipped.claims import BANDS
from bench.statistics.excess_flip import flip_by_pixel
from lod.arrays import Reals, freeze
from scenes.frame.frame_input import FrameInput
from scenes.frame.layers import SKY_Z
from scenes.presets.schema import Preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import build_frame, trace
from scenes.sticks.prototype import LUMINANCE

REFERENCE, TESTED, LIGHT = 0, 1000, 2000
"""First frame numbers of samples: pictures of the reference and of what is tested have others.

The light of both is of the same samples: where they show the same, there is no noise between them.
"""

Picture = Float64[np.ndarray, "h w 3"]


@dataclass(frozen=True, eq=False)
class LandLight:
    """Sums over the rays that meet land, by bands of distance, (bands,) each.

    light  luminance
    rays   how many there are
    """

    light: Float64[np.ndarray, " bands"]
    rays: Int64[np.ndarray, " bands"]

    def __post_init__(self) -> None:
        freeze(self, light=np.float64, rays=np.int64)


@dataclass(frozen=True, eq=False)
class Seen:
    """What is seen of one scene.

    pictures  linear radiance, one of every count of samples
    land      the light of the land by bands of distance
    Z         (h, w) distance of what each pixel shows [m], in the last picture
    sticks, triangles   how many the scene has
    """

    pictures: tuple[Picture, ...]
    land: LandLight
    Z: np.ndarray
    sticks: int
    triangles: int


@dataclass(frozen=True)
class Looks:
    """How scenes are looked at: samples of a pixel in each picture, and passes over the light."""

    samples: tuple[int, ...]
    light_passes: int


def look(frame_input: FrameInput, looks: Looks, edges_m: np.ndarray, first: int) -> Seen:
    """Build a frame's scene once and look at it; its pictures are of samples ``first`` and on."""
    stage, quality = build_frame(frame_input), frame_input.quality
    made = [
        trace(stage, replace(quality, spp=spp), first + k) for k, spp in enumerate(looks.samples)
    ]
    passes = (trace(stage, replace(quality, spp=1), LIGHT + k) for k in range(looks.light_passes))
    land = sum_land(((each.rgb, each.Z) for each in passes), edges_m)
    pictures = tuple(each.rgb.astype(np.float64) for each in made)
    counts = made[0].statistics
    return Seen(pictures, land, made[-1].Z, counts["sticks"], counts["triangles"])


def sum_land(passes: Iterable[tuple[np.ndarray, np.ndarray]], edges_m: np.ndarray) -> LandLight:
    """Sum the luminance of rays that meet land, band by band.

    ``passes`` are pairs of radiance (h, w, 3) and distance (h, w) [m], of one ray a pixel.
    """
    light, rays = np.zeros(BANDS), np.zeros(BANDS, np.int64)
    for rgb, Z in passes:
        land = Z < SKY_Z
        band = np.digitize(Z[land].astype(np.float64), edges_m[1:-1])
        light += np.bincount(band, rgb[land].astype(np.float64) @ LUMINANCE, BANDS)
        rays += np.bincount(band, minlength=BANDS)
    return LandLight(light, rays)


def band_edges(preset: Preset) -> np.ndarray:
    """Return the edges of a preset's bands of distance, (bands + 1,) [m].

    They are even in the logarithm, from twice the height of the eye to where air leaves 2 % of the
    contrast, or the ground ends. The first band then begins at the eye, and the last has no end.
    """
    farthest = min(preset.air.visibility or np.inf, preset.terrain.reach)
    edges = np.geomspace(2 * preset.camera.height, farthest, BANDS + 1)
    edges[0], edges[-1] = 0.0, float(SKY_Z)
    return edges


def flips(tested: Sequence[Picture], reference: Sequence[Picture]) -> list[float]:
    """Return the mean FLIP of each two pictures with as many samples, as ``flips_by_pixel``."""
    return [float(each.mean()) for each in flips_by_pixel(tested, reference)]


def flips_by_pixel(tested: Sequence[Picture], reference: Sequence[Picture]) -> list[Reals]:
    """Return FLIP of every pixel of each two pictures with as many samples, row by row.

    They are displayed at one exposure, that of the reference's last picture.
    """
    exposure = auto_exposure(reference[-1])
    shown = (
        [to_srgb(each, exposure).astype(np.float32) for each in pictures]
        for pictures in (tested, reference)
    )
    return [flip_by_pixel(one, other) for one, other in zip(*shown, strict=True)]
