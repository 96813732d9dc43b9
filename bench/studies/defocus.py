"""Parts that a lens's blur saves by distance, whether the law knows, and what it costs the picture.

A preset is seen through a lens of 50 mm. Its cut is compared with the cut of the same detail that
does not know of the lens. The pictures of both, taken through the lens in a window of the world,
are compared with that of everything there is: FLIP at several counts of samples, extrapolated to
pictures without noise (``bench.statistics.fits``), with one-sided 95 % bounds over
pairs of seeds, over the pixels whose centre shows ground or objects of that distance, up to half
the side of the window: beyond it a pruned picture still has the far cover of an endless field. The
same extrapolation of two pictures of everything is the floor, and near 0.
The law is held against whole fields on flat ground, seen all round.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import click
import numpy as np

from bench.cli.output import counted, table
from bench.images.compare import LEAST_PAIRS, flip_by_pixel
from bench.part_sizes import (
    COARSE_M,
    camera,
    count_sizes,
    density_of,
    predicted_sizes,
    prototypes_with,
    seed_of,
    view_through,
)
from bench.records.study_record import study_record, write_study_record
from bench.statistics.estimates import Estimate, two_sided_mean
from bench.statistics.fits import noise_free, one_sided_mean
from lod.arrays import Reals
from lod.camera import ThinLens
from lod.errors import InputError
from lod.metric import METRICS
from lod.pruner import prune
from lod.view import View, distance
from lod.viewing import BlurWidths, Defocus, ViewingConditions, defocus_width, defocused_distance
from scenes.frame.frame_input import FrameInput, display
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.render.pictures import auto_exposure, to_srgb
from scenes.render.render import build_frame, trace
from scenes.render.variants import choose
from scenes.scene import frame_light, frame_quality, preset_air, view_at
from scenes.world.world import World, build_world

BANDS_M = (0.0, 6.0, 12.0, 24.0, 48.0, 100.0, 150.0, 400.0, math.inf)
"""Where bands of distance begin and end [m]."""


SPP = 16, 64, 256
"""Samples a pixel from which errors are extrapolated."""


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
    shown = counted(seeds, "field", lambda seed: "fields against the law")
    found = [sum(count_sizes(*things, view, seed).by_size) for seed in shown]
    return two_sided_mean(np.array(found) / expected)


def pictures(
    world: World, preset: Preset, view: View, seeds: range, exposure: float | None, spp: int
) -> tuple[Pictures, float]:
    """Render what a view displays with every seed and so many samples a pixel.

    The exposure is the first picture's where none is given.
    """
    displayed = tuple(display(each, prune(each, view), view) for each in world.representations)
    quality = replace(frame_quality(preset, choose(preset.render.variant)), spp=spp)
    scene = build_frame(
        FrameInput(view.camera, displayed, preset_air(preset), frame_light(world, preset), quality)
    )
    shown = counted(seeds, "picture", lambda seed: f"{spp} samples a pixel")
    layers = [trace(scene, replace(quality, seed=seed)) for seed in shown]
    light = [each.rgb.astype(np.float64) for each in layers]
    exposure = auto_exposure(light[0]) if exposure is None else exposure
    return Pictures(
        [to_srgb(each, exposure) for each in light], layers[0].Z.ravel().astype(np.float64)
    ), exposure


def band_means(shown: list[np.ndarray], other: list[np.ndarray], here: np.ndarray) -> Reals:
    """Mean FLIP of each pair of pictures, over the pixels that are ``here``, (n,)."""
    flips = [flip_by_pixel(a, b)[here].mean() for a, b in zip(shown, other, strict=True)]
    return np.array(flips)


def errors_by_distance(
    tested: Mapping[int, Pictures], everything: Mapping[int, Pictures], farthest_m: float
) -> dict[str, dict[str, float]]:
    """Errors of each band and of all that is no farther, extrapolated to pictures without noise.

    Pictures are by their samples a pixel. ``everything`` has twice as many: with the seeds of those
    tested, and with others. A band has ``error``, its bounds ``low`` and ``high``, the ``floor`` of
    everything against itself, and its ``share`` of the pixels.
    """
    samples = sorted(tested)
    away, found = everything[samples[-1]].away, {}
    bands = [(low, high) for low, high in pairwise(BANDS_M) if high <= farthest_m]
    for low, high in (*bands, (0.0, farthest_m)):
        here = (low <= away) & (away < high)
        if here.any():
            errors, floors = [], []
            for count in samples:
                shown, whole = tested[count].shown, everything[count].shown
                same, other = whole[: len(shown)], whole[len(shown) :]
                errors.append(band_means(shown, other, here))
                floors.append(band_means(same, other, here))
            each, floor = (
                one_sided_mean(noise_free(np.array(samples, np.float64), np.array(e)))
                for e in (errors, floors)
            )
            found[_band(low, high)] = {
                "error": each.value,
                "low": each.low,
                "high": each.high,
                "floor": floor.value,
                "share": float(here.mean()),
            }
    return found


def _band(low: float, high: float) -> str:
    return f"from {low:g} m" if math.isinf(high) else f"{low:g} to {high:g} m"


@click.command()
@click.argument("preset", default="crowd")
@click.option("--f-stop", default=2.0, show_default=True, help="Of the lens.")
@click.option("--focus", default=12.0, show_default=True, help="Distance in focus [m].")
@click.option("--fields", default=24, show_default=True, help="Fields held against the law.")
@click.option("--pairs", default=LEAST_PAIRS, show_default=True, help="Of seeds; 0 = no pictures.")
@click.option("--extent", default=150.0, show_default=True, help="Side of the window [m].")
@click.option("--size", default="160x90", show_default=True, help="Of the pictures.")
@click.option("--parts-size", default="480x270", show_default=True, help="Where parts are counted.")
@click.option("--spp", multiple=True, default=SPP, show_default=True, help="Samples a pixel.")
@click.option("--record", type=click.Path(path_type=Path), help="A file for the figures.")
def command(record: Path | None, **asked: Any) -> None:
    """Measure and print."""
    if asked["pairs"] and len(set(asked["spp"])) < 2:
        raise InputError("--spp", asked["spp"], "two counts to extrapolate from", "say it twice")
    preset, f_stop, extent = asked["preset"], asked["f_stop"], asked["extent"]
    keys = [f"camera.f_stop={f_stop}", f"camera.focus={asked['focus']}", "camera.focal_length=50"]
    counted = load_preset(preset, [*keys, f"render.size={asked['parts_size']}"])
    found: dict[str, Any] = {"parts": saved_parts(counted)}
    click.echo(_saved_text(found["parts"]))
    if asked["fields"] > 1:
        ratio = law_ratio(0.05 / f_stop, asked["focus"], asked["fields"])
        found["law"] = {"ratio": ratio.value, "low": ratio.low, "high": ratio.high}
        numbers = f"{ratio.value:.4f} ({ratio.low:.4f} to {ratio.high:.4f})"
        click.echo(f"parts over the law's, {asked['fields']} fields: {numbers}")
    if asked["pairs"]:
        keys += [f"render.size={asked['size']}", f"world.extent={extent}"]
        world = load_preset(preset, keys)
        found["errors"] = compare(world, asked["pairs"], extent / 2, sorted(set(asked["spp"])))
        for name, each in found["errors"].items():
            click.echo(f"{name}, against everything, without noise\n{_errors_text(each)}")
    if record:
        variant = choose() if asked["pairs"] else None
        write_study_record(record, study_record("defocus", asked, found, variant))


def saved_parts(preset: Preset) -> dict[str, dict[str, int]]:
    """Count parts in each band of distance, with and without what the lens hides.

    Of those kept near though blurred only the first count is known.
    """
    world = build_world(preset)
    view = view_at(world, preset, 1)
    (aware, near), (sharp, _) = (parts_by_distance(world, v) for v in (view, without_lens(view)))
    names = [_band(*each) for each in pairwise(BANDS_M)]
    counts = [*zip(names, sharp, aware, strict=True), ("all", sharp.sum(), aware.sum())]
    found = {name: {"no_lens": int(s), "lens": int(a)} for name, s, a in counts}
    return {**found, "of these kept near though blurred": {"no_lens": 0, "lens": near}}


def saved_share(parts: Mapping[str, int]) -> float | None:
    """Share of parts that the lens saves; None where there are none."""
    return 1 - parts["lens"] / parts["no_lens"] if parts["no_lens"] else None


def _saved_text(parts: Mapping[str, Mapping[str, int]]) -> str:
    rows: list[tuple[Any, ...]] = [("distance", "parts, no lens", "with lens", "saved (%)")]
    for name, each in parts.items():
        share = saved_share(each)
        rows.append((name, *each.values(), "-" if share is None else f"{100 * share:.1f}"))
    return table(rows)


def compare(
    preset: Preset, pairs: int, farthest_m: float, samples: Sequence[int]
) -> dict[str, dict[str, dict[str, float]]]:
    """Errors of the cut that knows of the lens and of the one that does not, by distance."""
    world = build_world(preset)
    view = view_at(world, preset, 1)
    exposure: float | None = None
    everything: dict[int, Pictures] = {}
    for count in samples:
        seeds = range(2 * pairs)
        everything[count], exposure = pictures(world, preset, whole(view), seeds, exposure, count)
    found = {}
    for name, each in (
        ("a cut that knows of the lens", view),
        ("one that does not", without_lens(view)),
    ):
        tested = {
            count: pictures(world, preset, each, range(pairs), exposure, count)[0]
            for count in samples
        }
        found[name] = errors_by_distance(tested, everything, farthest_m)
    return found


def _errors_text(errors: Mapping[str, Mapping[str, float]]) -> str:
    rows: list[tuple[Any, ...]] = [("distance", "FLIP", "low", "high", "floor", "% of pixels")]
    for name, each in errors.items():
        numbers = (f"{each[key]:+.4f}" for key in ("error", "low", "high", "floor"))
        rows.append((name, *numbers, f"{100 * each['share']:.1f}"))
    return table(rows)
