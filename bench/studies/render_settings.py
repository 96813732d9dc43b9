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
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import click
import numpy as np

from bench.cli.output import counted, table
from bench.statistics.estimates import LEAST_REPEATS, two_sided_median
from scenes.frame.frame_input import Quality
from scenes.presets.load import load_preset
from scenes.render.render import BuiltFrame, build_frame, trace
from scenes.scene import assemble_frame
from scenes.world.world import build_world

DARK = 1e-2
"""The number added to the squared radiance by which noise is divided, ÷ its mean square."""


SPP = 25
"""The samples of a pixel: orthogonal arrays allow only squares of primes."""


@dataclass(frozen=True)
class Setting:
    """One way to render: a name, and the fields of Quality that it changes."""

    name: str
    changes: Mapping[str, Any] = field(default_factory=dict)

    def of(self, quality: Quality) -> Quality:
        """Return a quality with this setting's changes."""
        return replace(quality, **self.changes)


def settings() -> tuple[Setting, ...]:
    """Return the settings that are tried; the first is the one in use."""
    weights, kinds = [1.0, 3.0, 6.0, 24.0, 48.0], ("independent", "stratified", "orthogonal")
    suns = [Setting(f"sun sampled {w:g} to 1 sky", {"sun_sampling": w}) for w in weights]
    samplers = [Setting(f"sampler {k}", {"sampler": k}) for k in kinds]
    sizes = [Setting(f"2^{k} samples at once", {"most_samples": 2**k}) for k in (16, 18, 21)]
    depths = [Setting(f"paths of {n} edges", {"max_depth": n}) for n in (2, 3, 6, 16)]
    return (Setting("as used"), *suns, *samplers, *sizes, *depths)


def traced(built: BuiltFrame, quality: Quality, seed: int) -> tuple[np.ndarray, float]:
    """Render a picture (h, w, 3), and return it with the CPU seconds that it took."""
    start = time.process_time()
    layers = trace(built, replace(quality, seed=seed), 1)
    return np.asarray(layers.rgb, np.float64), time.process_time() - start


def noise(a: np.ndarray, b: np.ndarray, light: np.ndarray) -> float:
    """Return the variance of a picture ÷ its squared light."""
    squared = light**2
    return float(((a - b) ** 2 / 2 / (squared + DARK * squared.mean())).mean())


def tried(name: str, size: str, spp: int, pairs: int) -> list[tuple[Any, ...]]:
    """Try every setting on one preset, and return the rows of its table."""
    preset = load_preset(name, [f"render.size={size}", f"render.spp={spp}"])
    made, all_settings = assemble_frame(build_world(preset), preset, 1, "llvm_ad_rgb"), settings()
    qualities = [each.of(made.quality) for each in all_settings]
    scenes = [(build_frame(replace(made, quality=each)), each) for each in qualities]
    for scene in scenes:
        traced(*scene, 2**20)  # compiles
    pictures: list[list[np.ndarray]] = [[] for _ in all_settings]
    spent: list[list[float]] = [[] for _ in all_settings]
    for seed in counted(range(2 * pairs), "seed", lambda seed: name):
        for scene, held, times in zip(scenes, pictures, spent, strict=True):
            picture, seconds = traced(*scene, seed)
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
            f"{two_sided_median(found * seconds / used):.2f}",
            f"{np.mean(held) / deepest:.3f}",
        )
        for each, held, (found, seconds) in zip(all_settings, pictures, rows, strict=True)
    ]


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
