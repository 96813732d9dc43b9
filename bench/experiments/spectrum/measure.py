"""Is pruning a low-pass filter? (§2.1, §2.2)

Radial power spectra of a whole picture, of pruned ones, and of their difference are compared with
the cut-off that m predicts: a feature of τ pixels is half a period, so pruning at τ should remove
the frequencies above 1/(2τ) cycles a pixel, and no others. Pictures show albedo alone, and all are
sampled at the same places: there is no noise in them.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from jaxtyping import Float64

from bench.experiments.spectrum.claims import EDGES
from bench.old_experiment import Effort
from bench.records.provenance import scene_digest
from bench.records.records import Column, Point, Prediction
from lod.air import CLEAR
from lod.arrays import Reals
from lod.metric import METRICS
from lod.pruner import prune
from scenes.frame.frame_input import FrameInput, Quality, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import view_at
from scenes.sticks.prototype import LUMINANCE
from scenes.world.light import Light
from scenes.world.world import World, build_world

DETAILS = (2.0, 4.0, 8.0, 16.0)
_SPP = 36
SCENE = (
    "world.extent=200",
    "terrain.amplitude=0",
    "terrain.reach=256",
    "terrain.finest=1",
    "species.figure.density=0.006",
    "species.figure.prototypes=4",
    "species.tree.density=0.001",
    "species.sward.density=0",
    "species.tree.prototypes=2",
    "air.visibility=clear",
    "camera.pitch=0",
    "render.size=192x96",
)

Picture = Float64[np.ndarray, "h w"]


@dataclass(frozen=True)
class Case:
    """A heading of the camera [degrees], and the variant that renders the picture."""

    heading: float
    variant: str


def cases(effort: Effort) -> list[Case]:
    """Return as many directions as the effort says, evenly all round."""
    count, variant = effort["directions"], choose()
    return [Case(360.0 * number / count - 180.0, variant) for number in range(count)]


def measure(case: Case, seed: int) -> list[Point]:
    """Measure, for each detail, the powers of every octave, in 10⁻¹²."""
    whole, points = picture(case.heading, None, case.variant, seed), []
    for detail in DETAILS:
        pruned = picture(case.heading, detail, case.variant, seed)
        pictures = {"whole": whole, "pruned": pruned, "lost": whole - pruned}
        powers = tuple(
            Column("power", [round(1e12 * float(power))], {"picture": name, "octave": k})
            for name, each in pictures.items()
            for k, power in enumerate(spectrum(each))
        )
        cutoff = Prediction("cutoff", 1 / (2 * detail))
        points.append(Point({"detail": detail}, (cutoff,), powers))
    return points


def spectrum(picture: Picture) -> Reals:
    """Return the power of a picture in every octave between EDGES, (octaves,).

    The picture is less its mean and seen through a Hann window, whose mean square is divided out:
    the sum over all frequencies is the variance of the picture (Parseval).
    """
    height, width = picture.shape
    window = np.outer(np.hanning(height), np.hanning(width))
    mean = float((picture * window).sum() / window.sum())
    power = np.abs(np.fft.fft2((picture - mean) * window)) ** 2
    power /= (window**2).mean() * picture.size**2
    along = np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None]
    band = np.digitize(np.hypot(*along), EDGES) - 1
    return np.bincount(np.clip(band, 0, None).ravel(), power.ravel(), len(EDGES))[: len(EDGES) - 1]


def picture(heading: float, detail: float | None, variant: str, seed: int) -> Picture:
    """Render albedo as luminance, towards a heading, pruned at a detail or, at None, whole."""
    preset, world = _preset(heading), _world(seed)
    view = view_at(world, preset, 1)
    metric = METRICS["full" if detail is None else "blake"]
    view, visible = replace(view, metric=metric, detail=detail or 1.0), []
    for each in world.representations:
        visible.append(display(each, prune(each, view), view))
    quality = Quality(variant, _SPP, 0, max_depth=1)
    light = Light(preset.light.sun_azimuth, preset.light.sun_elevation)
    layers = render_frame(FrameInput(view.camera, tuple(visible), CLEAR, light, quality))
    return np.asarray(layers.albedo.astype(np.float64) @ LUMINANCE)


def _preset(heading: float) -> Preset:
    return load_preset("meadow", (*SCENE, f"camera.heading={heading}"))


@lru_cache(maxsize=1)
def _world(seed: int) -> World:
    return build_world(_preset(0.0).model_copy(update={"seed": seed}))


def scene_hash(points: tuple[Point, ...]) -> str:
    """Return the SHA-256 of the preset and of what is measured in how many directions."""
    count = len(points[0].samples[0].values)
    return scene_digest([_preset(0.0).model_dump(mode="json"), DETAILS, EDGES, _SPP, count])
