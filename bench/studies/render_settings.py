"""Noise times rendering time of other samplers, sun weights and path depths.

One setting is changed at a time from what frames are rendered with. Every setting renders the same
scene with pairs of independent seeds, all settings taking turns. Noise is the mean over pixels of
(a − b)²/2 over the squared light of the mean of all pictures, which holds no bias; time is that of
the processor, on all cores, for the trace alone, once its code is compiled. What counts is noise ×
time, as a share of that of the settings in use, pair by pair, with the 95 % interval of the median:
below 1 is better. Light tells what a setting leaves out: mean radiance over that of the deepest
paths tried.
"""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any
from unittest.mock import patch

import click
import numpy as np

from bench.cli.output import table
from bench.statistics.estimates import LEAST_REPEATS, Estimate, median
from scenes.frame.frame_input import assemble_frame
from scenes.frame.quality import Quality
from scenes.frame.types import FrameInput
from scenes.preset.load import load_preset
from scenes.render.description import describe
from scenes.render.drivers import camera_rays
from scenes.render.drivers import jit as jit_frame
from scenes.render.pipeline.render import BuiltFrame, build_frame, trace
from scenes.world.world import build_world

DARK = 1e-2
"""Added to the squared radiance that noise is held against, as a share of its mean square."""


SPP = 25
"""Samples a pixel: orthogonal arrays take no other numbers than squares of primes."""


@dataclass(frozen=True)
class Setting:
    """One way to render: ``scene`` and ``trace`` are what is changed where a scene is built and
    where it is traced, as (module, name, value).
    """

    name: str
    max_depth: int | None = None
    scene: tuple[tuple[Any, str, Any], ...] = ()
    trace: tuple[tuple[Any, str, Any], ...] = ()


def settings() -> tuple[Setting, ...]:
    """What is tried; the first is what is used."""
    weights = [1.0, 3.0, 6.0, 24.0, 48.0]
    suns = [
        Setting(f"sun sampled {w:g} to 1 sky", scene=((describe, "SUN_SAMPLING", w),))
        for w in weights
    ]
    kinds = ("independent", "stratified", "orthogonal")
    samplers = [Setting(f"sampler {k}", trace=((camera_rays, "SAMPLER", k),)) for k in kinds]
    sizes = [
        Setting(f"2^{k} samples at once", trace=((jit_frame, "MOST_SAMPLES", 2**k),))
        for k in (16, 18, 21)
    ]
    depths = [Setting(f"paths of {n} edges", max_depth=n) for n in (2, 3, 6, 16)]
    return (Setting("as used"), *suns, *samplers, *sizes, *depths)


@contextmanager
def changed(names: Sequence[tuple[Any, str, Any]]) -> Iterator[None]:
    """Constants at other values for a while."""
    patches = [patch.object(*each) for each in names]
    for each in patches:
        each.start()
    try:
        yield
    finally:
        for each in patches:
            each.stop()


def built(made: FrameInput, setting: Setting) -> tuple[BuiltFrame, Quality]:
    """The scene of a frame by one setting."""
    quality = made.quality
    if setting.max_depth is not None:
        quality = replace(quality, max_depth=setting.max_depth)
    with changed(setting.scene):
        return build_frame(made.camera, made.visible, made.air, made.light, quality), quality


def traced(
    stage: BuiltFrame, quality: Quality, setting: Setting, seed: int
) -> tuple[np.ndarray, float]:
    """A picture (h, w, 3), and the processor's seconds that it took."""
    with changed(setting.trace):
        start = time.process_time()
        layers = trace(stage, replace(quality, seed=seed), 1)
        return np.asarray(layers.rgb, np.float64), time.process_time() - start


def noise(a: np.ndarray, b: np.ndarray, light: np.ndarray) -> float:
    """Variance of a picture, over the squared light there."""
    squared = light**2
    return float(((a - b) ** 2 / 2 / (squared + DARK * squared.mean())).mean())


def tried(name: str, size: str, spp: int, pairs: int) -> list[tuple[Any, ...]]:
    """One preset's table."""
    preset = load_preset(name, [f"render.size={size}", f"render.spp={spp}"])
    made, all_settings = assemble_frame(build_world(preset), preset, 1, "llvm_ad_rgb"), settings()
    scenes = [built(made, each) for each in all_settings]
    for scene, each in zip(scenes, all_settings, strict=True):
        traced(*scene, each, 2**20)  # compiles
    pictures: list[list[np.ndarray]] = [[] for _ in all_settings]
    spent: list[list[float]] = [[] for _ in all_settings]
    for seed in range(2 * pairs):
        for scene, each, held, times in zip(scenes, all_settings, pictures, spent, strict=True):
            picture, seconds = traced(*scene, each, seed)
            held.append(picture)
            times.append(seconds)
    light = np.mean([np.mean(held, axis=0) for held in pictures[:-4]], axis=0)
    rows = [
        (
            np.array([noise(*pair, light) for pair in zip(held[::2], held[1::2], strict=True)]),
            np.add.reduceat(times, np.arange(0, 2 * pairs, 2)),
        )
        for held, times in zip(pictures, spent, strict=True)
    ]
    deepest = float(np.mean(pictures[-1]))
    used = rows[0][0] * rows[0][1]
    return [
        (
            each.name,
            f"{np.median(found):.4f}",
            f"{np.median(seconds) / 2:.2f}",
            _among(median(found * seconds / used)),
            f"{np.mean(held) / deepest:.3f}",
        )
        for each, held, (found, seconds) in zip(all_settings, pictures, rows, strict=True)
    ]


def _among(found: Estimate) -> str:
    return f"{found.value:.2f} ({found.low:.2f} to {found.high:.2f})"


@click.command()
@click.argument("presets", nargs=-1)
@click.option("--size", default="320x180", metavar="WxH", show_default=True)
@click.option("--spp", default=SPP, show_default=True, help="Orthogonal arrays: a prime squared.")
@click.option(
    "--pairs",
    type=click.IntRange(LEAST_REPEATS),
    default=LEAST_REPEATS,
    show_default=True,
    help="Pairs of seeds.",
)
def command(presets: tuple[str, ...], size: str, spp: int, pairs: int) -> None:
    """Try the settings on these PRESETS (meadow, crowd and forest by default), under LLVM."""
    heads = ("setting", "noise", "processor s", "noise × time, of that used", "light")
    for name in presets or ("meadow", "crowd", "forest"):
        click.echo(f"\n{name}, {size}, {spp} samples a pixel")
        click.echo(table([heads, *tried(name, size, spp, pairs)]))
