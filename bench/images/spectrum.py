"""Is pruning a low-pass filter? (§2.1, §2.2)

Radial power spectra of a whole picture, of pruned ones, and of their difference are compared with
the cut-off that m predicts: a feature of τ pixels is half a period, so pruning at τ should remove
the frequencies above 1/(2τ) cycles a pixel, and no others. Pictures show albedo alone, and all are
sampled at the same places: there is no noise in them.
"""

from dataclasses import replace
from functools import lru_cache, partial

import numpy as np
from jaxtyping import Float64

from bench.experiment import Case
from bench.records.records import Column, Point, Prediction
from lod.air import CLEAR
from lod.arrays import Reals
from lod.metric import METRICS
from lod.pruner import prune
from scenes.frame.frame_input import FrameInput, Light, Quality, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.render import render_frame
from scenes.render.variants import choose
from scenes.scene import Scene
from scenes.sticks.prototype import LUMINANCE

EDGES = tuple(2.0**k for k in range(-6, 0))
"""Edges of octaves of frequency [cycles a pixel], from 1/64 to 1/2; lower ones are in the first."""

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


def cases(directions: int) -> list[Case]:
    """Return so many directions, evenly all round."""
    return [
        partial(measure, 360.0 * number / directions - 180.0, choose())
        for number in range(directions)
    ]


def measure(heading: float, variant: str, seed: int) -> list[Point]:
    """Measure, for each detail, the powers of every octave towards a heading, in 10⁻¹²."""
    whole, points = picture(heading, None, variant, seed), []
    for detail in DETAILS:
        pruned = picture(heading, detail, variant, seed)
        pictures = {"whole": whole, "pruned": pruned, "lost": whole - pruned}
        powers = tuple(
            Column("power", [round(1e12 * float(power))], {"picture": name, "octave": k})
            for name, each in pictures.items()
            for k, power in enumerate(spectrum(each))
        )
        cutoff = Prediction("cutoff", 1 / (2 * detail))
        points.append(Point({"topic": "spectrum", "detail": detail}, (cutoff,), powers))
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
    scene = _scene(seed).with_preset(_preset(heading))
    metric = METRICS["full" if detail is None else "blake"]
    view = replace(scene.view(1), metric=metric, detail=detail or 1.0)
    visible = tuple(display(each, prune(each, view), view) for each in scene.world.representations)
    quality = Quality(variant, _SPP, 0, max_depth=1)
    light = Light(scene.preset.light.sun_azimuth, scene.preset.light.sun_elevation)
    layers = render_frame(FrameInput(view.camera, visible, CLEAR, light, quality))
    return np.asarray(layers.albedo.astype(np.float64) @ LUMINANCE)


def _preset(heading: float) -> Preset:
    return load_preset("meadow", (*SCENE, f"camera.heading={heading}"))


@lru_cache(maxsize=1)
def _scene(seed: int) -> Scene:
    return Scene(_preset(0.0).model_copy(update={"seed": seed}))


def power(point: Point, name: str, above: bool) -> Reals:
    """Return the power above the cut-off, or below it, in every direction, (directions,)."""
    cutoff = point.prediction("cutoff")
    chosen = [k for k in range(len(EDGES) - 1) if (EDGES[k] >= cutoff) == above]
    rows = [point.values("power", picture=name, octave=k) for k in chosen]
    return np.sum(rows, axis=0)


def octaves(point: Point, name: str) -> Reals:
    """Return the mean power in every octave."""
    rows = [point.values("power", picture=name, octave=k) for k in range(len(EDGES) - 1)]
    return np.array([each.mean() for each in rows]) / 1e12
