"""How long the rays of a frame take by our integrator, by Mitsuba's, and by intersections alone.

It is the topic ``tracing`` of the experiment ``cost``; ``scenes/render/ray_times.py`` traces.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from bench.experiment import Table
from bench.records.claims import Claim, at_most, claim
from bench.records.records import Point, Record, columns
from bench.seeds import first_seed
from bench.statistics.estimates import LEAST_REPEATS, two_sided_factor
from lod.arrays import Reals
from scenes.presets.load import load_preset
from scenes.render.render import build_frame
from scenes.render.variants import JIT_VARIANT
from scenes.scene import Scene

DARK = 1e-2  # the number added to the squared radiance by which noise is divided, ÷ its mean square


def measure_tracing(preset: str, size: str, field: int, unseen: bool, seed: int) -> Point:
    """Trace a frame of one field in every way, in turns, with two independent seeds of samples.

    Times are those of the processor on all cores [µs]: of the rays of a picture, and of what comes
    before; the floor has one seed. Noise is the variance of a pixel ÷ its squared light, and light
    the mean radiance, both in millionths.
    """
    begun = time.process_time()
    # Flat: with copies Mitsuba's own completion of a hit takes time as their number squared.
    keys = (
        "view.copies=0",
        f"render.size={size}",
        f"seed={first_seed(unseen, 4) + 12 * seed + field}",
    )
    made = Scene(load_preset(preset, keys)).input(1, JIT_VARIANT)
    frame = build_frame(made)
    samples = {"set_up_us": [round(1e6 * (time.process_time() - begun))]}
    from scenes.render.ray_times import trace_times

    seeds = {"ours": (0, 1), "mitsuba": (0, 1), "floor": (0,)}
    for way in seeds:
        trace_times(frame.scene, replace(made.quality, seed=2), way, most_runs=1)  # compiles
    found = {
        (way, number): trace_times(frame.scene, replace(made.quality, seed=number), way)
        for number in range(2)
        for way in seeds
        if number in seeds[way]
    }
    pictures = {way: [found[way, k][1] for k in seeds[way]] for way in seeds}
    squared = np.mean([*pictures["ours"], *pictures["mitsuba"]], axis=0) ** 2
    squared += DARK * squared.mean()
    for way, seen in pictures.items():
        samples[f"{way}_us"] = [round(1e6 * np.mean([found[way, k][0] for k in seeds[way]]))]
        if way != "floor":
            noise = ((seen[0] - seen[1]) ** 2 / 2 / squared).mean()
            samples[f"{way}_noise_ppm"] = [round(1e6 * float(noise))]
            samples[f"{way}_light_ppm"] = [round(1e6 * float(np.mean(seen)))]
    case = {"topic": "tracing", "preset": preset, "size": size}
    return Point(case, samples=columns(samples))


def tracing_claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Bound time to equal error by Mitsuba's, and the time of rays by that of intersections."""
    for point in points:
        of = {name: str(point.case[name]) for name in ("preset", "size")}
        for estimand, most, ratio in (
            ("noise × time of rays, ours ÷ Mitsuba's", 0.55, _to_error(point)),
            ("time of rays ÷ time to intersect them", 1.6, _times(point, "ours", "floor")),
        ):
            if len(ratio) >= LEAST_REPEATS:
                found = two_sided_factor(ratio)
                yield claim(estimand, at_most(most), of, found, unit="field", source="asked")


def _times(point: Point, way: str, other: str) -> Reals:
    return np.asarray(point.values(f"{way}_us") / point.values(f"{other}_us"))


def _to_error(point: Point) -> Reals:
    noise = point.values("ours_noise_ppm") / point.values("mitsuba_noise_ppm")
    return np.asarray(noise * _times(point, "ours", "mitsuba"))


def tracing_tables(record: Record) -> Iterator[tuple[str, Table]]:
    """Show medians; ``whole`` adds what comes before the trace to both."""
    rows: list[tuple[str, ...]] = []
    for point in record.points:
        ours, theirs, floor = (point.values(f"{way}_us") for way in ("ours", "mitsuba", "floor"))
        before = point.values("set_up_us")
        noise = point.values("ours_noise_ppm") / point.values("mitsuba_noise_ppm")
        light = np.mean(point.values("ours_light_ppm")) / np.mean(point.values("mitsuba_light_ppm"))
        rows.append(
            (
                f"{point.case['preset']}, {point.case['size']}",
                *(f"{np.median(us) / 1e6:.2f}" for us in (ours, theirs, floor)),
                *(f"{np.median(ours / each):.2f}" for each in (theirs, floor)),
                f"{np.median(noise):.2f}",
                f"{np.median(_to_error(point)):.2f}",
                f"{np.median((ours + before) / (theirs + before)):.2f}",
                f"{light:.5f}",
            )
        )
    heads = ("frame", "ours [s]", "Mitsuba's [s]", "floor [s]", "ours ÷ Mitsuba's", "ours ÷ floor")
    others = "noise ÷ Mitsuba's", "noise × time", "whole ÷ Mitsuba's", "light ÷ Mitsuba's"
    yield "Processor seconds of the rays of a frame", ((*heads, *others), rows)
