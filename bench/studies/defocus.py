"""Parts that a lens's blur saves by distance, whether the law knows, and what it costs the picture.

A preset is seen through a lens of 50 mm. Its cut is compared with the cut of the same detail that
does not know of the lens. The pictures of both, taken through the lens in a window of the world,
are compared with that of everything there is. Excess FLIP is over the noise of pairs of seeds, with
one-sided 95 % bounds, over the pixels whose centre shows ground or objects of that distance, up to
half the side of the window: beyond it a pruned picture still has the far cover of an endless field.
The law is held against whole fields on flat ground, seen all round.
"""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import click
import numpy as np

from bench.cli.output import table
from bench.fields.part_sizes import (
    COARSE_M,
    camera,
    count_sizes,
    density_of,
    predicted_sizes,
    prototypes_with,
    seed_of,
    view_through,
)
from bench.statistics.estimates import Estimate, two_sided_mean
from bench.statistics.excess_flip import LEAST_PAIRS, flip_by_pixel, one_sided_excess
from lod.arrays import Reals
from lod.metric.family import METRICS
from lod.pruning.pruner import prune
from lod.pruning.view import View
from lod.pruning.view_geometry import distance
from lod.thin_lens import ThinLens
from lod.vision.blur_cascade import BlurWidths
from lod.vision.defocus import Defocus, defocus_width, defocused_distance
from lod.vision.viewer import ViewingConditions
from scenes.frame.assemble import frame_light, frame_quality
from scenes.frame.displayed import display
from scenes.frame.frame_input import FrameInput
from scenes.preset.load import load_preset
from scenes.preset.tables import Preset
from scenes.render.mitsuba.variants import choose
from scenes.render.pictures.tone_map import auto_exposure, to_srgb
from scenes.render.pipeline.stages import build_frame, trace
from scenes.world.view import preset_air, view_at
from scenes.world.world import World, build_world

BANDS_M = (0.0, 6.0, 12.0, 24.0, 48.0, 100.0, 150.0, 400.0, math.inf)
"""Where bands of distance begin and end [m]."""


@dataclass(frozen=True, eq=False)
class Pictures:
    """Displayed pictures of one cut, by seed, and the distance of what each pixel shows (h·w,)."""

    shown: list[np.ndarray]
    away: Reals


def without_lens(view: View) -> View:
    """Return the view whose cut does not know of the lens that it is seen through."""
    assert view.conditions is not None
    return replace(view, conditions=replace(view.conditions, defocus=None))


def whole(view: View) -> View:
    """Return the view that displays everything there is, seen through the same lens."""
    return replace(view, metric=METRICS["full"], fade=0.0, conditions=None, offscreen_detail=1.0)


def parts_by_distance(world: World, view: View) -> tuple[Reals, int]:
    """Count the parts of all fields in each band of distance, and those that are kept near.

    Kept near are parts before the focus that are blurred there to less than the metric asks: their
    limits do not say so, because limits must not begin at a distance.
    """
    counts, near = np.zeros(len(BANDS_M) - 1), 0
    for each in world.fields:
        parts = prune(each, view).parts
        away = distance(view, parts.position)
        counts += np.histogram(away, BANDS_M)[0]
        sight = view.conditions
        if sight is not None and sight.defocus is not None:
            theta = sight.widths.effective
            blurred = away * np.hypot(theta, defocus_width(sight.defocus, away)) / theta
            asked = defocused_distance(sight.defocus, theta, parts.limit)
            near += int(np.count_nonzero(blurred > asked * (1 + 1e-9)))
    return counts, near


def law_ratio(diameter_m: float, focus_m: float, fields: int) -> Estimate:
    """Estimate parts displayed through a lens ÷ those that the law predicts, over whole fields."""
    eye = camera(640)
    defocus = Defocus(ThinLens(diameter_m, focus_m), eye.corner_secant)
    sight = ViewingConditions(BlurWidths(eye.pixel_angle), acuity=False, defocus=defocus)
    view = view_through(sight, 640)
    things = prototypes_with("figure", None), 4 * density_of("figure", COARSE_M)
    expected = float(predicted_sizes(*things, view).sum())
    seeds = [seed_of("defocus", 0, index) for index in range(fields)]
    found = [sum(count_sizes(*things, view, seed).by_size) for seed in seeds]
    return two_sided_mean(np.array(found) / expected)


def pictures(
    world: World, preset: Preset, view: View, seeds: range, exposure: float | None
) -> tuple[Pictures, float]:
    """Render what a view displays with every seed; the exposure is the first picture's or given."""
    displayed = tuple(display(each, prune(each, view), view) for each in world.representations)
    quality = frame_quality(preset, choose(preset.render.variant))
    scene = build_frame(
        FrameInput(view.camera, displayed, preset_air(preset), frame_light(world, preset), quality)
    )
    layers = [trace(scene, replace(quality, seed=seed)) for seed in seeds]
    light = [each.rgb.astype(np.float64) for each in layers]
    exposure = auto_exposure(light[0]) if exposure is None else exposure
    return Pictures(
        [to_srgb(each, exposure) for each in light], layers[0].Z.ravel().astype(np.float64)
    ), exposure


def excess_rows(tested: Pictures, everything: Pictures, farthest_m: float) -> list[tuple[Any, ...]]:
    """Return excess FLIP of each band and of all that is no farther: excess, bounds, floor, share.

    ``everything`` has twice as many pictures: with the seeds of those tested, and with others.
    """
    pairs = len(tested.shown)
    same, other = everything.shown[:pairs], everything.shown[pairs:]
    found, floor = (
        np.stack([flip_by_pixel(a, b) for a, b in zip(shown, other, strict=True)])
        for shown in (tested.shown, same)
    )
    away, rows = everything.away, []
    bands = [(low, high) for low, high in pairwise(BANDS_M) if high <= farthest_m]
    for low, high in (*bands, (0.0, farthest_m)):
        here = (low <= away) & (away < high)
        if here.any():
            each = one_sided_excess(found[:, here].mean(axis=1), floor[:, here].mean(axis=1))
            numbers = (f"{value:+.4f}" for value in (each.excess, each.low, each.high))
            share = f"{100 * here.mean():.1f}"
            rows.append((_band(low, high), *numbers, f"{each.floor:.4f}", share))
    return rows


def _band(low: float, high: float) -> str:
    return f"from {low:g} m" if math.isinf(high) else f"{low:g} to {high:g} m"


@click.command()
@click.argument("preset", default="crowd")
@click.option("--f-stop", default=2.0, show_default=True, help="Of the lens.")
@click.option("--focus", default=12.0, show_default=True, help="Distance in focus [m].")
@click.option("--fields", default=24, show_default=True, help="Fields held against the law.")
@click.option("--pairs", default=LEAST_PAIRS, show_default=True, help="Of seeds; 0 = no pictures.")
@click.option("--extent", default=300.0, show_default=True, help="Side of the window [m].")
@click.option("--size", default="320x180", show_default=True, help="Of the pictures.")
@click.option("--spp", default=16, show_default=True, help="Samples a pixel.")
def command(
    preset: str,
    f_stop: float,
    focus: float,
    fields: int,
    pairs: int,
    extent: float,
    size: str,
    spp: int,
) -> None:
    """Measure and print."""
    keys = [f"camera.f_stop={f_stop}", f"camera.focus={focus}", "camera.focal_length=50"]
    keys += [f"render.size={size}", f"render.spp={spp}"]
    click.echo(table(_saved_rows(load_preset(preset, keys))))
    if fields > 1:
        ratio = law_ratio(0.05 / f_stop, focus, fields)
        numbers = f"{ratio.value:.4f} ({ratio.low:.4f} to {ratio.high:.4f})"
        click.echo(f"parts over the law's, {fields} fields: {numbers}")
    if pairs:
        _compare(load_preset(preset, [*keys, f"world.extent={extent}"]), pairs, extent / 2)


def _saved_rows(preset: Preset) -> list[tuple[Any, ...]]:
    """Return the table of parts by distance, with and without what the lens hides."""
    world = build_world(preset)
    view = view_at(world, preset, 1)
    (aware, near), (sharp, _) = (parts_by_distance(world, v) for v in (view, without_lens(view)))
    names = [_band(*each) for each in pairwise(BANDS_M)]
    counts = [*zip(names, sharp, aware, strict=True), ("all", sharp.sum(), aware.sum())]
    rows: list[tuple[Any, ...]] = [("distance", "parts, no lens", "with lens", "saved (%)")]
    rows += [(n, int(s), int(a), f"{100 * (1 - a / s):.1f}" if s else "-") for n, s, a in counts]
    return [*rows, ("of these kept near though blurred", "", near, "")]


def _compare(preset: Preset, pairs: int, farthest_m: float) -> None:
    """Print excess FLIP of both cuts against everything."""
    world = build_world(preset)
    view = view_at(world, preset, 1)
    everything, exposure = pictures(world, preset, whole(view), range(2 * pairs), None)
    heads = ("distance", "excess FLIP", "low", "high", "floor", "% of pixels")
    for name, each in (("knows of the lens", view), ("does not", without_lens(view))):
        tested, _ = pictures(world, preset, each, range(pairs), exposure)
        click.echo(f"the cut {name}, against everything")
        click.echo(table([heads, *excess_rows(tested, everything, farthest_m)]))
