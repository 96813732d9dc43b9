"""How do a frame's parts, time and memory grow with K, the world and the pixels? (§4.1)

A preset is swept as it stands, one quantity at a time, by each metric that has a law. Every step
counts a frame by the pruner and predicts it without; time is the processor's, from pruning to plain
arrays, as a frame is made a second time, before any renderer, and memory that of these arrays.
Exponents are fitted within a field, and fields are the replicates, so that no time is compared with
one of another machine. Species that have no law are not counted.
"""

import re
import time
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from jaxtyping import Float64

from bench.experiment import Case, OwnPreset
from bench.frame_costs import AT_ORIGIN, plain_frame
from bench.frame_counts import predict
from bench.plots import Curve, Panel, Plot, figure
from bench.records.claims import Claim, at_most, claim, within
from bench.records.records import Point, Record, columns, grouped, where
from bench.seeds import first_seed
from bench.statistics.estimates import two_sided_mean, two_sided_paired_ratio
from lod.arrays import Reals
from lod.law import LIMITS, max_ground_distance
from lod.pruner import prune
from scenes.presets.load import load_preset
from scenes.presets.schema import Preset
from scenes.scene import Scene

USUAL = "crowd", ("view.detail=2",)
"""The preset of a run without a user's own, and what is changed in it."""

METRICS = tuple(name for name in LIMITS if name != "full")

MARGIN = 0.05
"""How far an exponent may be from that of the prediction, and a count from the prediction."""

MOST_PARTS = 3e6  # the predicted parts from which on a step is left out

BEYOND = 2.0
"""The side, in limit distances on both sides of the eye, from which on the world is not felt."""

SWEEPS: Mapping[str, tuple[str, tuple[float, ...]]] = {
    "density": ("K, objects per m²", (1 / 16, 1 / 8, 1 / 4, 1 / 2, 1.0)),
    "world": ("side of the world (m)", (0.5, 1.0, 2.5, 10.0, 100.0)),
    "pixels": ("pixels of the picture", (160, 320, 640, 1280, 2560)),
}
"""Axis and steps of each sweep: factors on K, sides in twice the limit distance, widths [px]."""

GROWN = {
    "parts": ("parts", "parts displayed", 1.0),
    "cpu_us": ("CPU time", "CPU time before tracing (s)", 1e-6),
    "bytes": ("memory", "memory of plain arrays (MB)", 1e-6),
}
"""What is measured at each step: its name, its axis, and its unit in that of the axis."""


def cases(fields: int, unseen: bool, preset: OwnPreset | None = None) -> list[Case]:
    """Return every sweep by every metric in each field, of a preset or the usual one."""
    own, first = preset or (USUAL[0], load_preset(*USUAL)), first_seed(unseen, 8)
    asked = [(*own, metric, sweep) for metric in METRICS for sweep in SWEEPS]
    return [partial(measure, *each, first + k) for k in range(fields) for each in asked]


def measure(
    name: str, preset: Preset, metric: str, sweep: str, first: int, seed: int
) -> list[Point]:
    """Measure every step of a sweep in one field, but those with too many parts."""
    words = f"view.metric={metric}", f"seed={first + 20 * seed}"
    made: list[Point] = []
    for step in SWEEPS[sweep][1]:
        x, changes = _step(preset, words, sweep, step)
        scene = Scene(load_preset(preset, (*words, *changes)))
        view = scene.view(1)
        laws = [(each, law) for each in scene.world.fields if (law := predict(each, view))]
        told = sum(each.species.density * law.parts for each, law in laws)
        if told > MOST_PARTS:
            continue
        plain_frame(scene)  # compiles, makes what later frames reuse, and is not timed
        start = time.process_time()
        plain = plain_frame(scene)
        counts = {
            "cpu_us": [round(1e6 * (time.process_time() - start))],
            "bytes": [_bytes_of(plain)],
            "parts": [sum(prune(each, view).displayed_parts for each, _ in laws)],
            "predicted": [round(1e3 * told)],
        }
        named = {"topic": "growth", "preset": name, "metric": metric, "sweep": sweep}
        made.append(Point(named | {"step": float(step), "x": x}, samples=columns(counts)))
    return made


def _bytes_of(plain: Mapping[str, Any]) -> int:
    arrays = [a for shape in plain["shapes"].values() for a in shape.values()]
    arrays += [plain["ids"], *plain["owners"].values()]
    return sum(a.nbytes for a in arrays if isinstance(a, np.ndarray))


def _step(
    preset: Preset, words: Sequence[str], sweep: str, step: float
) -> tuple[float, tuple[str, ...]]:
    K = {name: step * each.density for name, each in preset.species.items()}
    if sweep == "density":
        return sum(K.values()), tuple(f"species.{name}.density={k!r}" for name, k in K.items())
    if sweep == "pixels":
        width, height = int(step), int(step) * 9 // 16
        return float(width * height), (f"render.size={width}x{height}",)
    endless = Scene(load_preset(preset, (*words, *AT_ORIGIN)))
    kinds = [each.prototypes.part_tables.hierarchies for each in endless.world.fields]
    limit = max(max_ground_distance(each, endless.view(1)) for each in kinds)
    side = float(f"{2 * step * limit:.3g}")
    return side, (f"world.extent={side!r}", *AT_ORIGIN)


# Claims, from raw points alone.


Rows = Float64[np.ndarray, "fields steps"]


def _rows(points: Sequence[Point], *quantities: str) -> list[np.ndarray]:
    """Return x and each quantity, (fields, steps), of the steps that all fields have."""
    fields = max(len(p.column("parts")) for p in points)
    whole = [p for p in points if len(p.column("parts")) == fields]
    x = np.tile([float(p.case["x"]) for p in whole], (fields, 1))
    return [x, *(np.array([p.values(each) for p in whole]).T for each in quantities)]


def _exponents(x: Rows, y: Rows) -> Reals:
    pairs = zip(np.log(np.maximum(x, 1e-9)), np.log(np.maximum(y, 1.0)), strict=True)
    return np.array([np.polyfit(one, other, 1)[0] for one, other in pairs])


def claims(points: Sequence[Point]) -> Iterator[Claim]:
    """Claim exponents and counts as predicted, and that time and memory grow no faster."""
    made = partial(claim, unit="field", source="§4.1")
    for (preset, metric), mine in grouped(points, "preset", "metric").items():
        of, check = {"preset": preset, "metric": metric}, partial(made, kind="verification")
        sweeps = {sweep: row for (sweep,), row in grouped(mine, "sweep").items() if len(row) > 1}
        for sweep, row in sweeps.items():
            x, parts, told = _rows(row, "parts", "predicted")
            bound = within(round(float(_exponents(x, told).mean()), 3), MARGIN)
            estimand = f"exponent of parts displayed against {SWEEPS[sweep][0].split(',')[0]}"
            yield check(estimand, bound, of, two_sided_mean(_exponents(x, parts)))
        every = [_rows(row, "predicted", *GROWN)[1:] for row in sweeps.values()]
        told, parts, *costs = (np.hstack(row) for row in zip(*every, strict=True))
        whole = two_sided_paired_ratio(parts.sum(axis=1), told.sum(axis=1) / 1e3)
        yield check("parts displayed ÷ predicted", within(1, MARGIN), of, whole)
        beyond = [p for p in sweeps.get("world", ()) if p.case["step"] >= BEYOND]
        for (quantity, (cost, *_)), spent in zip([*GROWN.items()][1:], costs, strict=True):
            found = two_sided_mean(_exponents(parts, spent))
            yield made(f"exponent of {cost} against parts displayed", at_most(1), of, found)
            if len(beyond) > 1:
                found = two_sided_mean(_exponents(*_rows(beyond, quantity)))
                far = {**of, "side of the world": f"beyond {BEYOND:g} limit distances"}
                estimand = f"exponent of {cost} against side of the world"
                yield made(estimand, within(0, MARGIN), far, found)


def plots(record: Record) -> Iterator[Plot]:
    """Draw parts with their prediction, time and memory, against what is swept, by metric."""
    for (preset,), mine in grouped(record.points, "preset").items():
        panels, told = [], []
        for sweep, (axis, _) in SWEEPS.items():
            by_metric = grouped(where(mine, sweep=sweep), "metric")
            for quantity, (_, label, unit) in GROWN.items():
                drawn = []
                for (metric,), row in by_metric.items():
                    x, y, law = (np.mean(each, 0) for each in _rows(row, quantity, "predicted"))
                    line = (x.tolist(), (law / 1e3).tolist()) if unit == 1 else ((), ())
                    drawn.append(Curve(metric, x.tolist(), (unit * y).tolist(), line=line))
                panels.append(Panel("", (axis, label), drawn))
            if len(row := by_metric.get((METRICS[0],), [])) > 1:
                power = float(_exponents(*_rows(row, "parts")).mean())
                told.append(f"{power:.2f} of {axis.split(',')[0].split(' (')[0]}")
        caption = (
            "Means of fields; dashed: parts predicted by the law, without free parameters. Time is "
            "the processor's from pruning to plain arrays, when a frame is made a second time; "
            "memory is that of these arrays."
        )
        title = f"Parts of {preset} by {METRICS[0]} grow with the power {', '.join(told)}"
        name = re.sub("[^a-z0-9]+", "-", preset.lower())
        yield figure(f"growth-{name}", title, caption, panels)
