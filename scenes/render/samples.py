"""Samples of a frame are summed here, and made its layers."""

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from scenes.frame.frame_input import Quality, Window
from scenes.frame.layers import SKY_Z, Coverage, Layers, add_coverage
from scenes.render.build import GUIDES, BuiltScene
from scenes.render.motion_vectors import motion_vectors


@dataclass(eq=False)
class Samples:
    """Sums over the samples of a window of a frame, of which rgb and albedo end as means.

    window     (h, w) pixels of a picture of ``width``, by whose numbers runs of pixels come
    hit        (h, w, 9) distance, normal, shape and primitive number, and position where motion is
               asked for, of one sample of each pixel
    replaced   samples that were not finite and count as black
    counts     of samples by pixel and object, where they are asked for
    """

    window: Window
    width: int
    rgb: np.ndarray
    albedo: np.ndarray
    hit: np.ndarray
    replaced: int = 0
    counts: list[Coverage] = field(default_factory=list)

    @staticmethod
    def none_of(built: BuiltScene, quality: Quality) -> "Samples":
        """Return the sums of a frame's window of which no sample is taken yet."""
        size = built.description["camera"]["size"]
        window = quality.window_of(size)
        columns, rows = window.size
        rgb, albedo = np.zeros((2, rows, columns, 3))
        hit = np.zeros((rows, columns, 9), np.float32)  # as the renderer gives it
        return Samples(window, size[0], rgb, albedo, hit)

    def runs(self, height: int, step: int) -> Iterator[tuple[slice, int]]:
        """Yield runs of ``step`` pixels, and how many of each are in the window, if any are."""
        for first in range(0, self.width * height, step):
            pixels = slice(first, min(first + step, self.width * height))
            if taken := int(np.count_nonzero(self.window.share(pixels, self.width)[0])):
                yield pixels, taken

    def add(self, layer: str, pixels: slice, values: np.ndarray) -> None:
        """Add values (n, 3) of a run of the picture's pixels to ``rgb`` or ``albedo``."""
        inside, own = self.window.share(pixels, self.width)
        sums = getattr(self, layer).reshape(-1, 3)[own]
        sums += values.reshape(-1, 3)[inside]

    def keep(self, pixels: slice, guides: np.ndarray) -> None:
        """Keep the guides of one sample of each pixel of a run, with channels as build.GUIDES."""
        inside, own = self.window.share(pixels, self.width)
        columns = [0, 1, 2, 3, 7, 8, *range(9, guides.shape[-1])]
        flat = guides.reshape(-1, guides.shape[-1])[inside]
        self.hit.reshape(-1, 9)[own, : len(columns)] = flat[:, columns]

    def count_objects(self, built: BuiltScene, pixels: slice, guides: np.ndarray) -> None:
        """Count what the samples of a run of pixels meet, of guides (n, spp, channels)."""
        inside, own = self.window.share(pixels, self.width)
        pixel = np.arange(own.start, own.stop).repeat(guides.shape[1])
        guides = guides[inside].reshape(-1, guides.shape[-1])
        shape, prim = (guides[:, GUIDES[k].start] for k in ("shape_index", "prim_index"))
        met = built.hit_ids(shape, prim)[:, 0] * (guides[:, 0] > 0)
        self.counts.append(add_coverage(pixel, met, np.ones(len(pixel))))

    def coverage(self) -> Coverage | None:
        """Share of each pixel's samples by object; None where none were counted."""
        if not self.counts:
            return None
        columns = [(each.pixel, each.object, each.share) for each in self.counts]
        pixel, met, count = map(np.concatenate, zip(*columns, strict=True))
        pixels = self.hit.shape[0] * self.hit.shape[1]
        return add_coverage(pixel, met, count * (pixels / count.sum()))


def make_layers(
    samples: Samples, built: BuiltScene, seconds: dict[str, float], statistics: dict[str, int]
) -> Layers:
    """Make the layers of a frame; small negatives left of the sky become 0 and are counted."""
    met = samples.hit[..., 0] > 0
    ids = built.hit_ids(samples.hit[..., 4], samples.hit[..., 5]) * met[..., None].astype(np.uint32)
    clamped = int(np.count_nonzero((samples.rgb < 0).any(axis=-1)))
    motion = None
    if built.description["after"]:
        motion = motion_vectors(samples.hit, built, samples.window)
    return Layers(
        rgb=np.maximum(samples.rgb, 0.0),
        Z=np.where(met, samples.hit[..., 0], SKY_Z),
        N=samples.hit[..., 1:4] * met[..., None],
        albedo=np.clip(samples.albedo, 0.0, 1.0),
        object=ids[..., 0],
        part=ids[..., 1],
        level=ids[..., 2],
        seconds=seconds,
        coverage=samples.coverage(),
        statistics={**statistics, "clamped": clamped, "replaced": samples.replaced},
        motion=motion,
    )
