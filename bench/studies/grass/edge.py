"""Does grass go on where far cover takes over, or is there an edge?

Nothing but grass on ground that is nearly level. One pixel of detail is held against a quarter of
one, of which the limits are four times as far: mean luminance in bands of distance, each picture's
by its own distances, and how many rays meet a band. (Wholly level ground would not do: its tiles
are not refined, and what stands on it would be painted at corners that are far apart.)
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.statistics.estimates import two_sided_mean
from bench.studies.grass.counts import grass_alone
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.render import build_frame, trace
from scenes.scene import assemble_frame
from scenes.sticks.prototype import LUMINANCE
from scenes.world.world import build_world

WITHIN = 0.05
"""How far from 1 a ratio of luminances should be at most."""

TESTED, FINE = 1.0, 0.25
"""Details that are compared [px]."""

WIDTH_PX, ASPECT = 640, 16 / 9
EDGES_M = (16.0, 24.0, 36.0, 52.0, 72.0, 96.0, 128.0, 170.0)
"""Edges of the bands in a picture of that width: tufts end there at 49 to 82 m, and at FINE at 193
m and more. In smaller pictures all is nearer by as much."""

HEADINGS_DEG = {"behind the eye": 70.0, "beside it": 160.0, "before it": 250.0}
"""Where the sun of `meadow` stands, and the heading that puts it there."""

RAYS = 16
"""Rays of each pixel, of which each has a distance of its own."""

LEVEL = ("terrain.amplitude=2", "camera.pitch=-6", "render.spp=1", "render.max_depth=3")


@dataclass(frozen=True)
class Outlook:
    """A picture so wide [px], to a heading [degrees], of the world of a seed."""

    width: int
    heading: float
    seed: int

    def preset(self, detail: float) -> Preset:
        """Return the preset that is seen, at a detail [px]."""
        size = f"{self.width}x{round(self.width / ASPECT)}"
        keys = f"render.size={size}", f"camera.heading={self.heading:g}", f"seed={self.seed}"
        density = load_preset("meadow").species["sward"].density
        return grass_alone(density, None, *LEVEL, *keys, f"view.detail={detail}")

    def sums(self, detail: float, variant: str, first: int = 1) -> np.ndarray:
        """Sum luminance and rays in each band, (2, bands); ``first`` is the first samples' seed."""
        preset = self.preset(detail)
        made = assemble_frame(build_world(preset), preset, 1, variant)
        built = build_frame(made)
        edges = np.array(EDGES_M) * self.width / WIDTH_PX
        found = np.zeros((2, len(edges) + 1))
        for seed in range(first, first + RAYS):
            layers = trace(built, made.quality, seed)
            light = layers.rgb.astype(np.float64).reshape(-1, 3) @ np.array(LUMINANCE)
            band = np.digitize(layers.Z.astype(np.float64).ravel(), edges)
            found += [np.bincount(band, weight, len(edges) + 1) for weight in (light, None)]
        return found[:, 1:-1]


def edge_figures(tested: np.ndarray, fine: np.ndarray) -> list[dict[str, Any]]:
    """Give for each band the luminance and the rays over those at the fine detail.

    Sums are (fields, 2, bands). The luminance has its 95 % interval from two fields on; None stands
    where a band is empty in a field.
    """
    rows = []
    for k in range(tested.shape[2]):
        one, two = tested[:, :, k], fine[:, :, k]
        row: dict[str, Any] = dict.fromkeys(("luminance", "low", "high", "rays"))
        if one[:, 1].all() and two[:, 1].all():
            ratio = one[:, 0] / one[:, 1] / (two[:, 0] / two[:, 1])
            row |= {"luminance": float(ratio.mean()), "rays": one[:, 1].sum() / two[:, 1].sum()}
            if len(ratio) > 1:
                found = two_sided_mean(ratio)
                row |= {"low": found.low, "high": found.high}
        rows.append(row)
    return rows
