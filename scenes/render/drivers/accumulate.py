"""Samples of a frame are summed here, and made its layers."""

from dataclasses import dataclass, field

import numpy as np

from scenes.frame.layers import SKY_Z, Coverage, Layers, add_coverage
from scenes.render.drivers.motion_vectors import motion_vectors
from scenes.render.mitsuba.build import GUIDES, BuiltScene


@dataclass(eq=False)
class Samples:
    """Sums over the samples of a frame, of which rgb and albedo end as means.

    hit        (h, w, 9) distance, normal, shape and primitive number, and position where motion is
               asked for, of one sample of each pixel
    replaced   samples that were not finite and count as black
    counts     of samples by pixel and object, where they are asked for
    """

    rgb: np.ndarray
    albedo: np.ndarray
    hit: np.ndarray
    replaced: int = 0
    counts: list[Coverage] = field(default_factory=list)

    @staticmethod
    def zeros(width: int, height: int) -> "Samples":
        """Return the sums of a picture of which no sample is taken yet."""
        colour = (height, width, 3)
        hit = np.zeros((height, width, 9), np.float32)  # as the renderer gives it
        return Samples(np.zeros(colour), np.zeros(colour), hit)

    def keep(self, band: slice, guides: np.ndarray) -> None:
        """Keep the guides of one sample of each pixel, with channels as in build.GUIDES.

        They are those of a band of rows, (h, w, n), or of a run of pixels, (k, n).
        """
        kept = self.hit if guides.ndim == 3 else self.hit.reshape(-1, 9)
        columns = [0, 1, 2, 3, 7, 8, *range(9, guides.shape[-1])]
        kept[band, ..., : len(columns)] = guides[..., columns]

    def count_objects(self, built: BuiltScene, pixel: np.ndarray, guides: np.ndarray) -> None:
        """Count what samples meet, given their pixels (n,) and guides (n, channels)."""
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
        motion=motion_vectors(samples.hit, built) if built.description["after"] else None,
    )
